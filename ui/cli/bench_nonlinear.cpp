#include "ui/cli/bench_nonlinear.h"

#include "fem/elastic_problem.h"
#include "fem/equilibrium.h"
#include "fem/near_field.h"
#include "mesh/base/error.h"
#include "mesh/cut_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <utility>

namespace retractor::cli {

namespace {

    constexpr double kNear = 40.0; // mm from the wound
    constexpr int kFrames = 40; // 0.25 mm each: at 15 frames a second the hooks take three seconds
    constexpr double kFinal = 1e-6; // residual of an answer that counts as converged

    struct CutScene {
        TetMesh mesh;
        Supports supports;
        std::vector<HookPatch> hooks;
        Points wound; ///< the vertices of the lips
        std::vector<std::pair<VertexId, VertexId>> gaps; ///< on the skin, one vertex on each lip
    };

    CutScene cut_scene(const OpenScene& scene)
    {
        CutSession session(scene.mesh);
        if (session.cut(scene.blade).status != CutStatus::done)
            throw SolverError("the bench's cut was not made");
        SlotMap map;
        CutScene cut { session.compact_mesh(&map), {}, {}, {}, {} };
        const auto compact = [&](VertexId v) { return map.compact_vertex[static_cast<std::size_t>(v)]; };
        for (const VertexId v : scene.supports.fixed)
            cut.supports.fixed.push_back(compact(v));
        for (const OnlineHook& hook : scene.hooks) {
            cut.hooks.push_back({ hook.name, hook.side, {}, hook.drive.displacement });
            for (const VertexId v : hook.nodes)
                cut.hooks.back().nodes.push_back(compact(v));
        }
        std::map<std::tuple<double, double, double>, std::array<VertexId, 2>> lips;
        for (const LipFace& lip : session.lips())
            for (const VertexId v :
                face_vertices(cut.mesh, { map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner })) {
                const Vec3 p = cut.mesh.vertices.row(v);
                auto& pair
                    = lips.try_emplace({ p.x(), p.y(), p.z() }, std::array<VertexId, 2> { -1, -1 }).first->second;
                pair[lip.side > 0 ? 0 : 1] = v;
            }
        cut.wound.resize(static_cast<Eigen::Index>(lips.size()), 3);
        const double highest = cut.mesh.vertices.col(2).maxCoeff();
        const double skin
            = highest - 1e-9 * std::abs(highest); // where a cut puts a vertex on the skin, it is there to round-off
        Eigen::Index row = 0;
        for (const auto& [place, pair] : lips) {
            cut.wound.row(row++) << std::get<0>(place), std::get<1>(place), std::get<2>(place);
            if (std::get<2>(place) >= skin && pair[0] >= 0 && pair[1] >= 0 && pair[0] != pair[1])
                cut.gaps.emplace_back(pair[0], pair[1]);
        }
        if (cut.gaps.empty())
            throw SolverError("the bench's wound has no lips on the skin");
        return cut;
    }

    /// Of the largest displacement.
    double difference(const Eigen::VectorXd& u, const Eigen::VectorXd& reference)
    {
        return (u - reference).lpNorm<Eigen::Infinity>() / reference.lpNorm<Eigen::Infinity>();
    }

    /// Between the lips, the worst place's, of the widest gap.
    double opening_difference(const CutScene& scene, const Eigen::VectorXd& u, const Eigen::VectorXd& reference)
    {
        double worst = 0.0, widest = 0.0;
        for (const auto& [a, b] : scene.gaps) {
            const auto gap = [&, a = a, b = b](
                                 const Eigen::VectorXd& x) { return Vec3(x.segment<3>(3 * a) - x.segment<3>(3 * b)); };
            worst = std::max(worst, (gap(u) - gap(reference)).norm());
            widest = std::max(widest, gap(reference).norm());
        }
        return worst / widest;
    }

    std::vector<Vec3> hooks_at(const CutScene& scene, double share)
    {
        std::vector<Vec3> at;
        for (const HookPatch& hook : scene.hooks)
            at.push_back(share * hook.displacement);
        return at;
    }

    /// The slow, exact path: Newton with the true stiffness on the whole body, from rest, at half and at full
    /// displacement. @return the fields; `seconds` for both.
    std::array<Eigen::VectorXd, 2> exact(
        const CutScene& scene, std::span<const Material> materials, const Job& job, double& seconds)
    {
        const Stopwatch watch;
        const Lame all = lame(materials[scene.mesh.labels.front()]);
        ElasticBody body(scene.mesh, uniform_tissue(scene.mesh, NeoHookean { all.mu, all.lambda }));
        EquilibriumSolver solver;
        std::array<Eigen::VectorXd, 2> fields;
        Eigen::VectorXd start = Eigen::VectorXd::Zero(3 * scene.mesh.vertices.rows());
        for (int half = 0; half < 2; ++half) {
            const Prescribed prescribed = prescribe(scene.mesh, scene.supports, scene.hooks);
            const Equilibrium equilibrium = solver.solve(body, prescribed.flag, 0.5 * (half + 1) * prescribed.value,
                start, { .load_steps = 2, .tolerance = 1e-2 * kFinal }, job);
            if (equilibrium.status != EquilibriumStatus::converged)
                throw SolverError("the exact path of the nonlinear bench did not converge");
            start = equilibrium.displacement;
            fields[static_cast<std::size_t>(half)] = start;
        }
        seconds = watch.seconds();
        return fields;
    }

    double percentile(std::vector<double> values, double share)
    {
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
    }

} // namespace

Json measure_nonlinear(const OpenScene& scene, const Job& job)
{
    const CutScene cut = cut_scene(scene);
    const std::vector<std::uint8_t> near = elements_near(cut.mesh, cut.wound, kNear);
    Json row;
    const Stopwatch planning;
    NearField field(cut.mesh, scene.materials, cut.supports, cut.hooks, near);
    row["nonlinear_plan_ms"] = 1e3 * planning.seconds();
    row["nonlinear_tets"] = field.near_elements();
    row["nonlinear_rim_vertices"] = field.rim_vertices();
    row["nonlinear_mb"] = static_cast<double>(field.bytes()) / 1e6;
    std::vector<double> frame_ms;
    double residual = 0.0;
    std::array<NearFrame, 2> dragged; // at half and at full displacement, while moving
    for (int f = 1; f <= kFrames; ++f) {
        const Stopwatch watch;
        NearFrame frame = field.drag(hooks_at(cut, static_cast<double>(f) / kFrames));
        frame_ms.push_back(1e3 * watch.seconds());
        residual = std::max(residual, frame.residual);
        if (2 * f == kFrames)
            dragged[0] = std::move(frame);
        else if (f == kFrames)
            dragged[1] = std::move(frame);
    }
    const Stopwatch finishing;
    NearField whole(cut.mesh, scene.materials, cut.supports, cut.hooks,
        std::vector<std::uint8_t>(cut.mesh.tet_count(), 1), { .tolerance = kFinal });
    whole.start_from(dragged[1]);
    const NearFrame final = whole.settle(job);
    row["final_ms"] = 1e3 * finishing.seconds();
    row["final_residual"] = final.residual;
    row["final_settled"] = final.status == NearStatus::settled;
    double seconds = 0.0;
    const std::array<Eigen::VectorXd, 2> reference = exact(cut, scene.materials, job, seconds);
    row["nonlinear_frame_ms_median"] = percentile(frame_ms, 0.5);
    row["nonlinear_frame_ms_p95"] = percentile(frame_ms, 0.95);
    row["nonlinear_fps"] = 1e3 / percentile(frame_ms, 0.5);
    row["nonlinear_residual"] = residual;
    double field_diff = 0.0, opening_diff = 0.0;
    for (std::size_t half = 0; half < 2; ++half) {
        field_diff = std::max(field_diff, difference(dragged[half].displacement, reference[half]));
        opening_diff = std::max(opening_diff, opening_difference(cut, dragged[half].displacement, reference[half]));
    }
    row["nonlinear_rel_diff"] = field_diff;
    row["nonlinear_opening_diff"] = opening_diff;
    row["final_rel_diff"] = difference(final.displacement, reference[1]);
    row["nonlinear_exact_ms"] = 1e3 * seconds;
    return row;
}

std::string nonlinear_text(const Json& row)
{
    const auto number = [&](const char* key) { return row.at(key).get<double>(); };
    std::array<char, 512> text {};
    std::snprintf(text.data(), text.size(),
        "  nonlinear drag    %.1f ms, p95 %.1f: %.0f frames/s, %zu neo-Hookean elements (planned in %.0f ms, %.0f MB)\n"
        "                    %.1e off the fully nonlinear field, %.1e off its opening; residual up to %.1e\n"
        "  fully nonlinear   %.0f ms after the last frame, residual %.1e; exact path %.0f ms, %.1e apart\n",
        number("nonlinear_frame_ms_median"), number("nonlinear_frame_ms_p95"), number("nonlinear_fps"),
        row.at("nonlinear_tets").get<std::size_t>(), number("nonlinear_plan_ms"), number("nonlinear_mb"),
        number("nonlinear_rel_diff"), number("nonlinear_opening_diff"), number("nonlinear_residual"),
        number("final_ms"), number("final_residual"), number("nonlinear_exact_ms"), number("final_rel_diff"));
    return text.data();
}

} // namespace retractor::cli
