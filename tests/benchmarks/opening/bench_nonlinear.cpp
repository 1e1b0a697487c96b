#include "tests/benchmarks/opening/bench_nonlinear.h"

#include "datasets/phantoms/phantom.h"
#include "fem/statics/drag_options.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/equilibrium.h"
#include "fem/statics/nonlinear_region.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"
#include "planner/plan/opened_wound.h"
#include "planner/wall/wall_cut.h"
#include "tests/benchmarks/framework/bench_bodies.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/framework/cpu_watch.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace retractor::benchmarks {

namespace {

    constexpr double kNear = 40.0; // radius of the nonlinear region round the wound, mm
    constexpr int kFrames = 40; // 0.25 mm each: the hooks take three seconds at 15 frames a second
    constexpr double kFinal = 1e-6; // largest residual of a converged answer

    struct CutScene {
        mesh::TetMesh mesh;
        fem::Supports supports;
        std::vector<fem::HookPatch> hooks;
        Points wound; ///< positions of the lips' vertices
        /// pairs of vertices, one on each lip; in boxes, on the skin only
        std::vector<std::pair<VertexId, VertexId>> gaps;
    };

    /// @param lips faces of the scene's mesh.
    /// @param skin height from which on a place counts as a gap.
    void put_lips(CutScene& cut, const std::vector<mesh::LipFace>& lips, double skin)
    {
        std::map<std::tuple<double, double, double>, std::array<VertexId, 2>> places;
        for (const mesh::LipFace& lip : lips)
            for (const VertexId v : mesh::face_vertices(cut.mesh, lip.face)) {
                const Vec3 p = cut.mesh.vertices.row(v);
                auto& pair
                    = places.try_emplace({ p.x(), p.y(), p.z() }, std::array<VertexId, 2> { -1, -1 }).first->second;
                pair[lip.side > 0 ? 0 : 1] = v;
            }
        cut.wound.resize(static_cast<Eigen::Index>(places.size()), 3);
        Eigen::Index row = 0;
        for (const auto& [place, pair] : places) {
            cut.wound.row(row++) << std::get<0>(place), std::get<1>(place), std::get<2>(place);
            if (std::get<2>(place) >= skin && pair[0] >= 0 && pair[1] >= 0 && pair[0] != pair[1])
                cut.gaps.emplace_back(pair[0], pair[1]);
        }
        if (cut.gaps.empty())
            throw SolverError("the bench's wound has no lips");
    }

    CutScene cut_scene(const OpenScene& scene)
    {
        mesh::CutSession session(scene.mesh);
        if (session.cut(scene.blade).status != mesh::CutStatus::done)
            throw SolverError("the bench's cut was not made");
        mesh::SlotMap map;
        CutScene cut { session.compact_mesh(&map), {}, {}, {}, {} };
        const auto compact = [&](VertexId v) { return map.compact_vertex[static_cast<std::size_t>(v)]; };
        for (const VertexId v : scene.supports.fixed)
            cut.supports.fixed.push_back(compact(v));
        for (const fem::OnlineHook& hook : scene.hooks) {
            cut.hooks.push_back({ hook.name, hook.side, {}, hook.drive.displacement });
            for (const VertexId v : hook.nodes)
                cut.hooks.back().nodes.push_back(compact(v));
        }
        std::vector<mesh::LipFace> lips = session.lips();
        for (mesh::LipFace& lip : lips)
            lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
        const double highest = cut.mesh.vertices.col(2).maxCoeff();
        put_lips(cut, lips, highest - 1e-9 * std::abs(highest)); // a cut places vertices exactly up to round-off
        return cut;
    }

    /// Largest difference of the gaps between the lips, relative to the widest gap.
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

    /// The exact path: Newton's method with the true stiffness on the whole body, from rest, at half and at full
    /// displacement.
    /// @return the fields; `seconds` is the time of both.
    std::array<Eigen::VectorXd, 2> exact(
        const CutScene& scene, std::span<const fem::Material> materials, const Job& job, double& seconds)
    {
        const Stopwatch watch;
        const fem::Lame all = fem::lame(materials[scene.mesh.labels.front()]);
        fem::ElasticBody body(
            scene.mesh, verification::uniform_tissue(scene.mesh, fem::NeoHookean { all.mu, all.lambda }));
        fem::EquilibriumSolver solver;
        std::array<Eigen::VectorXd, 2> fields;
        Eigen::VectorXd start = Eigen::VectorXd::Zero(3 * scene.mesh.vertices.rows());
        for (int half = 0; half < 2; ++half) {
            const fem::Prescribed prescribed = fem::prescribe(scene.mesh, scene.supports, scene.hooks);
            const fem::Equilibrium equilibrium = solver.solve(body, prescribed.flag,
                0.5 * (half + 1) * prescribed.value, start, { .load_steps = 2, .tolerance = 1e-2 * kFinal }, job);
            if (equilibrium.status != fem::EquilibriumStatus::converged)
                throw SolverError("the exact path of the nonlinear bench did not converge");
            start = equilibrium.displacement;
            fields[static_cast<std::size_t>(half)] = start;
        }
        seconds = watch.seconds();
        return fields;
    }

    struct Drag {
        std::vector<double> ms, processor_ms; ///< times per frame
        double residual = 0.0; ///< largest residual
        std::array<fem::NearFrame, 2> frame; ///< frames at half and at full displacement, while moving
    };

    Drag drag(fem::NonlinearRegion& field, const std::vector<fem::HookPatch>& hooks, int frames)
    {
        Drag drag;
        for (int f = 1; f <= frames; ++f) {
            std::vector<Vec3> at;
            for (const fem::HookPatch& hook : hooks)
                at.push_back(hook.displacement * f / frames);
            const Stopwatch watch;
            const ProcessCpuWatch processor;
            fem::NearFrame frame = field.drag(at);
            drag.processor_ms.push_back(processor.milliseconds());
            drag.ms.push_back(1e3 * watch.seconds());
            drag.residual = std::max(drag.residual, frame.residual);
            if (2 * f == frames)
                drag.frame[0] = std::move(frame);
            else if (f == frames)
                drag.frame[1] = std::move(frame);
        }
        return drag;
    }

    /// Set up as in the window.
    CutScene cut_thorax(const Job& job, std::vector<fem::Material>& materials)
    {
        const datasets::Phantom phantom = datasets::make_thorax_phantom({ .noise_hu = 0.0 }, job);
        planner::ApproachRequest request;
        request.template_name = "median";
        request.target.label = "aneurysm";
        planner::Approach approach = planner::approach_from_template(phantom.labels, request);
        approach.hooks = planner::make_hooks(approach, "4", 60.0);
        BenchWall wall = bench_wall(phantom, approach, job);
        planner::CutWall cut
            = planner::cut_wall(std::move(wall.mesh), approach, phantom.labels.table, std::move(wall.supports), job);
        if (cut.status != mesh::CutStatus::done)
            throw SolverError("the thorax of the bench was not cut: " + cut.message);
        materials = std::move(wall.materials);
        for (fem::Material& material : materials)
            material = planner::as_solved(std::move(material), planner::ElementKind::p1);
        CutScene scene { std::move(cut.wall), std::move(cut.supports), std::move(cut.hooks), {}, {} };
        put_lips(scene, cut.lips, -std::numeric_limits<double>::infinity());
        return scene;
    }

} // namespace

ui::cli::Json measure_nonlinear(const OpenScene& scene, const Job& job)
{
    const CutScene cut = cut_scene(scene);
    const std::vector<std::uint8_t> near = fem::elements_near(cut.mesh, cut.wound, kNear);
    ui::cli::Json row;
    const Stopwatch planning;
    fem::NonlinearRegion field(cut.mesh, scene.materials, cut.supports, cut.hooks, near);
    (void)field.prepare();
    row["nonlinear_plan_ms"] = 1e3 * planning.seconds();
    row["nonlinear_tets"] = field.near_elements();
    row["nonlinear_rim_vertices"] = field.rim_vertices();
    row["nonlinear_mb"] = static_cast<double>(field.bytes()) / 1e6;
    const Drag dragged = drag(field, cut.hooks, kFrames);
    const Stopwatch finishing;
    fem::NonlinearRegion whole(cut.mesh, scene.materials, cut.supports, cut.hooks,
        std::vector<std::uint8_t>(cut.mesh.tet_count(), 1), { .tolerance = kFinal });
    whole.start_from(dragged.frame[1]);
    const fem::NearFrame final = whole.settle(job);
    row["final_ms"] = 1e3 * finishing.seconds();
    row["final_residual"] = final.residual;
    row["final_settled"] = final.status == fem::NearStatus::settled;
    double seconds = 0.0;
    const std::array<Eigen::VectorXd, 2> reference = exact(cut, scene.materials, job, seconds);
    row["nonlinear_frame_ms_median"] = percentile(dragged.ms, 0.5);
    row["nonlinear_frame_ms_p95"] = percentile(dragged.ms, 0.95);
    row["nonlinear_fps"] = 1e3 / percentile(dragged.ms, 0.5);
    row["nonlinear_residual"] = dragged.residual;
    double field_diff = 0.0, opening_diff = 0.0;
    for (std::size_t half = 0; half < 2; ++half) {
        field_diff = std::max(field_diff, relative_difference(dragged.frame[half].displacement, reference[half]));
        opening_diff
            = std::max(opening_diff, opening_difference(cut, dragged.frame[half].displacement, reference[half]));
    }
    row["nonlinear_rel_diff"] = field_diff;
    row["nonlinear_opening_diff"] = opening_diff;
    row["final_rel_diff"] = relative_difference(final.displacement, reference[1]);
    row["nonlinear_exact_ms"] = 1e3 * seconds;
    return row;
}

std::string nonlinear_text(const ui::cli::Json& row)
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

ui::cli::Json measure_under_hand(const Job& job)
{
    constexpr int kHandFrames = 60; // 0.5 mm each: the hooks take four seconds at 15 frames a second
    std::vector<fem::Material> materials;
    const CutScene cut = cut_thorax(job, materials);
    const fem::DragRegion zone = fem::drag_region(cut.mesh, cut.wound);
    ui::cli::Json row { { "mesh", "thorax" }, { "tets", cut.mesh.tet_count() }, { "nodes", cut.mesh.vertex_count() },
        { "nonlinear_within_mm", zone.within_mm }, { "hooks", cut.hooks.size() } };
    const Stopwatch planning;
    fem::NonlinearRegion field(cut.mesh, materials, cut.supports, cut.hooks, zone.near, fem::drag_options());
    (void)field.prepare();
    row["nonlinear_plan_ms"] = 1e3 * planning.seconds();
    row["nonlinear_tets"] = field.near_elements();
    row["nonlinear_rim_vertices"] = field.rim_vertices();
    row["nonlinear_mb"] = static_cast<double>(field.bytes()) / 1e6;
    const Drag dragged = drag(field, cut.hooks, kHandFrames);
    row["nonlinear_frame_ms_median"] = percentile(dragged.ms, 0.5);
    row["nonlinear_frame_ms_p95"] = percentile(dragged.ms, 0.95);
    row["nonlinear_processor_ms_median"] = percentile(dragged.processor_ms, 0.5);
    row["nonlinear_fps"] = 1e3 / percentile(dragged.ms, 0.5);
    row["nonlinear_residual"] = dragged.residual;
    // The same displacement in large steps, each converged.
    fem::NonlinearRegionOptions tight = fem::drag_options();
    tight.tolerance = kFinal;
    const auto converged = [&](const std::vector<std::uint8_t>& near, double& seconds) {
        fem::NonlinearRegion slow(cut.mesh, materials, cut.supports, cut.hooks, near, tight);
        std::array<fem::NearFrame, 2> frames;
        for (int half = 0; half < 2; ++half) {
            std::vector<Vec3> at;
            for (int step = 1; step <= kHandFrames / 10; ++step) {
                at.clear();
                for (const fem::HookPatch& hook : cut.hooks)
                    at.push_back(hook.displacement * (0.5 * half + 5.0 * step / kHandFrames));
                (void)slow.drag(at);
            }
            const Stopwatch watch;
            frames[static_cast<std::size_t>(half)] = slow.settle(job);
            seconds = watch.seconds();
        }
        return frames;
    };
    double settling = 0.0, ignored = 0.0;
    const std::array<fem::NearFrame, 2> rest = converged(zone.near, settling),
                                        whole = converged(std::vector<std::uint8_t>(cut.mesh.tet_count(), 1), ignored);
    row["final_ms"] = 1e3 * settling;
    row["final_residual"] = std::max(rest[1].residual, whole[1].residual);
    double moving = 0.0, opening = 0.0, force = 0.0, zone_opening = 0.0;
    for (std::size_t half = 0; half < 2; ++half) {
        const fem::NearFrame& frame = dragged.frame[half];
        moving = std::max(moving, relative_difference(frame.displacement, rest[half].displacement));
        opening = std::max(opening, opening_difference(cut, frame.displacement, rest[half].displacement));
        zone_opening
            = std::max(zone_opening, opening_difference(cut, rest[half].displacement, whole[half].displacement));
        double largest = 0.0;
        for (const Vec3& f : rest[half].hook_forces_N)
            largest = std::max(largest, f.norm());
        for (std::size_t h = 0; h < cut.hooks.size(); ++h)
            force = std::max(force, (frame.hook_forces_N[h] - rest[half].hook_forces_N[h]).norm() / largest);
    }
    row["nonlinear_rel_diff"] = moving;
    row["nonlinear_opening_diff"] = opening;
    row["nonlinear_force_diff"] = force;
    row["nonlinear_zone_opening_diff"] = zone_opening;
    return row;
}

std::string under_hand_text(const ui::cli::Json& row)
{
    const auto number = [&](const char* key) { return row.at(key).get<double>(); };
    std::array<char, 900> text {};
    std::snprintf(text.data(), text.size(),
        "thorax %zu tetrahedra, cut along its median approach, %zu hooks dragged by 30 mm a side as in the window:\n"
        "  nonlinear drag    %.1f ms, p95 %.1f: %.0f frames/s; %.1f ms of processor time a frame\n"
        "                    %zu elements, within %.0f mm of the wound (planned in %.0f ms, %.0f MB)\n"
        "  a frame beside rest  %.1e of the largest displacement, %.1e of the opening, %.1e of the largest hook force; "
        "residual up to %.1e\n"
        "  at rest           %.0f ms after the hooks stop, residual %.1e; its opening %.1e off that of the whole wall, "
        "nonlinear\n",
        row.at("tets").get<std::size_t>(), row.at("hooks").get<std::size_t>(), number("nonlinear_frame_ms_median"),
        number("nonlinear_frame_ms_p95"), number("nonlinear_fps"), number("nonlinear_processor_ms_median"),
        row.at("nonlinear_tets").get<std::size_t>(), number("nonlinear_within_mm"), number("nonlinear_plan_ms"),
        number("nonlinear_mb"), number("nonlinear_rel_diff"), number("nonlinear_opening_diff"),
        number("nonlinear_force_diff"), number("nonlinear_residual"), number("final_ms"), number("final_residual"),
        number("nonlinear_zone_opening_diff"));
    return text.data();
}

} // namespace retractor::benchmarks
