#include "tests/benchmarks/opening/bench_gape.h"

#include "fem/model/pre_strain.h"
#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/opening/gape_pictures.h"
#include "tests/verification/framework/element_stress.h"
#include "tests/verification/framework/tension.h"
#include "ui/cli/framework/out_folder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace retractor::benchmarks {

namespace {

    constexpr std::array<double, 3> kStrains { 0.02, 0.04, 0.06 };
    constexpr double kModulus = 0.2; // skin, MPa; the gape does not depend on the modulus
    // Poisson's ratio of springs; under uniaxial stress the gape does not depend on the ratio
    constexpr double kRatio = 0.25;
    constexpr double kTolerance = 1e-4;
    constexpr double kStep = 5.0; // step of a freehand stroke, mm
    constexpr int kFrameIterations = 25;

    struct GapeRow {
        std::string model;
        double strain = 0.0, gape_mm = 0.0, closed_form_mm = 0.0, ms = 0.0, setup_ms = 0.0;
        std::size_t tets = 0;
        std::string note;

        double error_percent() const { return 100.0 * (gape_mm / closed_form_mm - 1.0); }
    };

    fem::Material skin() { return { "skin", kModulus, kRatio, 1.1e-9, "bench" }; }

    /// A cut sheet under tension.
    struct Sheet {
        verification::SheetProblem problem;
        double strain = 0.0;
        std::vector<fem::Material> materials = std::vector<fem::Material>(2, skin());
        mesh::TetMesh uncut = verification::sheet_mesh(problem);
        std::vector<Mat3> stresses = verification::stress_of_elements(uncut, materials,
            std::vector<fem::PreStrain>(
                2, { fem::PreStrainKind::uniaxial_stress, strain, Vec3::UnitY(), Vec3::UnitZ() }));
        mesh::CutSession session { uncut };
        mesh::MeshDelta delta {};

        double right() const
        {
            return verification::sheet_gape(fem::PreStrainKind::uniaxial_stress, strain, problem.cut_length, kRatio);
        }
        void cut()
        {
            mesh::CutResult result = session.cut(verification::sheet_blade(problem));
            if (result.status != mesh::CutStatus::done)
                throw SolverError("the bench's cut was not made: " + result.message);
            delta = std::move(result.delta);
        }
        /// Displacement of an infinite sheet at the rim.
        Points rim_displacement(const mesh::TetMesh& mesh) const
        {
            Points u = Points::Zero(mesh.vertices.rows(), 3);
            for (const VertexId v : verification::sheet_rim(problem, mesh))
                u.row(v) = verification::sheet_displacement(
                    problem.cut_length, kModulus * strain, kModulus, kRatio, mesh.vertices.row(v).transpose())
                               .transpose();
            return u;
        }
        fem::SpringNetwork network(double calibration) const
        {
            std::vector<fem::Material> scaled = materials;
            for (fem::Material& material : scaled)
                material.youngs_modulus_MPa *= calibration;
            fem::SpringNetwork springs(mesh::CutSession { uncut }, scaled, stresses);
            springs.set_displacement(rim_displacement(uncut));
            springs.fix(verification::sheet_rim(problem, uncut));
            springs.fix(verification::sheet_middle_plane(uncut), 4);
            return springs;
        }
        double calibration(const Job& job) const
        {
            return verification::spring_calibration(uncut, materials, verification::sheet_rim(problem, uncut),
                Vec3::UnitY(), verification::sheet_middle_plane(uncut), job);
        }
    };

    /// Distance between the lips at the middle of the cut, averaged over the thickness.
    double gape_at_middle(const Sheet& sheet, const fem::SpringNetwork& springs)
    {
        double sum = 0.0;
        int count = 0;
        const double near = 1e-6;
        for (const mesh::MeshDelta::VertexBorn& born : sheet.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < near) {
                sum += std::abs(springs.displacement()(born.a, 1) - springs.displacement()(born.id, 1));
                ++count;
            }
        return count > 0 ? sum / count : 0.0;
    }

    std::string status_note(const fem::RelaxResult& result)
    {
        std::array<char, 96> text {};
        std::snprintf(text.data(), text.size(), "%d iterations, residual %.0e%s", result.iterations, result.residual,
            result.status == fem::RelaxStatus::converged ? "" : ", not converged");
        return text.data();
    }

    GapeRow row_of(const Sheet& sheet, const char* model)
    {
        GapeRow row;
        row.model = model;
        row.strain = sheet.strain;
        row.closed_form_mm = sheet.right();
        row.tets = sheet.uncut.tet_count();
        return row;
    }

    GapeRow spring_row(const Sheet& sheet, double reach, double calibration, double calibration_ms, const Job& job)
    {
        GapeRow row = row_of(sheet, reach == 0.0 ? "springs" : "springs_local");
        Stopwatch watch;
        fem::SpringNetwork springs = sheet.network(calibration);
        springs.apply(sheet.delta);
        springs.set_wound(sheet.session.lips());
        row.setup_ms = calibration_ms + 1e3 * watch.seconds();
        watch = {};
        const fem::RelaxResult result = fem::relax(springs, { .tolerance = kTolerance, .reach_mm = reach }, job);
        row.ms = 1e3 * watch.seconds();
        row.gape_mm = gape_at_middle(sheet, springs);
        row.note = status_note(result);
        std::array<char, 96> text {};
        if (reach > 0.0) {
            std::snprintf(text.data(), text.size(), "; reach %.0f mm, %zu vertices", reach, result.active);
            row.note += text.data();
        } else {
            std::snprintf(text.data(), text.size(), "; calibration %.3f", calibration);
            row.note += text.data();
        }
        return row;
    }

    GapeRow element_row(const Sheet& sheet, bool quadratic, const Job& job)
    {
        GapeRow row = row_of(sheet, quadratic ? "fem_linear_p2" : "fem_linear");
        Stopwatch watch;
        mesh::SlotMap map;
        const mesh::TetMesh cut = sheet.session.compact_mesh(&map);
        const mesh::TetMesh mesh = quadratic ? mesh::with_midpoints(cut) : cut;
        std::vector<mesh::TetFace> faces;
        for (const mesh::LipFace& lip : sheet.session.lips())
            faces.push_back({ map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
        std::vector<Mat3> stresses;
        for (const TetId slot : map.tet_slot)
            stresses.push_back(sheet.stresses[static_cast<std::size_t>(sheet.session.origin(slot))]);
        row.setup_ms = 1e3 * watch.seconds();
        watch = {};
        const verification::ReleasedWound wound = verification::release_wound(mesh, faces, stresses, sheet.materials,
            { .fixed = verification::sheet_rim(sheet.problem, mesh) }, sheet.rim_displacement(mesh), job);
        row.ms = 1e3 * watch.seconds();
        double sum = 0.0;
        int count = 0;
        for (const auto& born : sheet.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < 1e-6) {
                sum += std::abs(wound.displacement(map.compact_vertex[static_cast<std::size_t>(born.id)], 1)
                    - wound.displacement(map.compact_vertex[static_cast<std::size_t>(born.a)], 1));
                ++count;
            }
        row.gape_mm = count > 0 ? sum / count : 0.0;
        std::array<char, 64> text {};
        std::snprintf(text.data(), text.size(), "relative residual %.0e", wound.relative_residual);
        row.note = text.data();
        return row;
    }

    /// Opens the wound while the blade moves: one frame of few iterations per step, then until equilibrium.
    GapeRow freehand_row(Sheet& sheet, double calibration, const Job& job)
    {
        GapeRow row = row_of(sheet, "springs_freehand");
        mesh::CutSession session(sheet.uncut);
        fem::SpringNetwork springs = sheet.network(calibration);
        const mesh::Blade whole = verification::sheet_blade(sheet.problem);
        const Vec3 along = (whole.line[1] - whole.line[0]).normalized();
        std::vector<double> follow, frame;
        const auto step = [&](const mesh::CutResult& cut) {
            if (cut.status != mesh::CutStatus::done)
                throw SolverError("the bench's stroke was not made: " + cut.message);
            Stopwatch watch;
            springs.apply(cut.delta);
            springs.set_wound(session.lips());
            follow.push_back(1e3 * watch.seconds());
            watch = {};
            static_cast<void>(
                fem::relax(springs, { .tolerance = kTolerance, .max_iterations = kFrameIterations }, job));
            frame.push_back(1e3 * watch.seconds());
        };
        mesh::Blade drawn = whole;
        drawn.line = { whole.line[0] };
        for (double at = kStep; at <= sheet.problem.cut_length + 1e-9; at += kStep) {
            drawn.line.push_back(whole.line[0] + at * along);
            step(session.extend_stroke(drawn));
        }
        step(session.finish_stroke());
        row.gape_mm = gape_at_middle(sheet, springs);
        row.ms = percentile(frame, 0.5);
        std::array<char, 160> text {};
        std::snprintf(text.data(), text.size(),
            "per frame of %d iterations (p95 %.1f ms); following the mesh %.1f ms; gape when the blade stops",
            kFrameIterations, percentile(frame, 0.95), percentile(follow, 0.5));
        row.note = text.data();
        return row;
    }

    std::vector<GapeRow> gape_rows(const GapeBenchOptions& options, const Job& job)
    {
        std::vector<GapeRow> rows;
        const std::vector<int> meshes = options.quick ? std::vector<int> { 64 } : std::vector<int> { 32, 64, 128 };
        const double total = static_cast<double>(meshes.size() * kStrains.size());
        for (const int around : meshes)
            for (const double strain : kStrains) {
                if (job.cancelled())
                    return rows;
                job.report("bench gape", static_cast<double>(rows.size() / 2) / total);
                Sheet sheet { .problem = { .around = around }, .strain = strain };
                sheet.cut();
                const Stopwatch watch;
                const double calibration = sheet.calibration({});
                const double calibration_ms = 1e3 * watch.seconds();
                rows.push_back(spring_row(sheet, 0.0, calibration, calibration_ms, {}));
                rows.push_back(element_row(sheet, false, {}));
                if (options.quick || around != 64)
                    continue;
                rows.push_back(element_row(sheet, true, {}));
                if (strain != kStrains.back())
                    continue;
                for (const double reach : { 10.0, 20.0, 40.0 })
                    rows.push_back(spring_row(sheet, reach, calibration, 0.0, {}));
                rows.push_back(freehand_row(sheet, calibration, {}));
            }
        return rows;
    }

    ui::cli::Json as_json(const GapeRow& row)
    {
        return { { "model", row.model }, { "strain", row.strain }, { "gape_mm", row.gape_mm },
            { "closed_form_mm", row.closed_form_mm }, { "error_percent", row.error_percent() }, { "ms", row.ms },
            { "setup_ms", row.setup_ms }, { "tets", row.tets }, { "note", row.note } };
    }

    std::string as_text(const GapeRow& row)
    {
        std::array<char, 320> line {};
        std::snprintf(line.data(), line.size(), "%-17s %3.0f %% %7zu %8.3f %8.3f %+7.2f %8.1f  %s\n", row.model.c_str(),
            100.0 * row.strain, row.tets, row.gape_mm, row.closed_form_mm, row.error_percent(), row.ms,
            row.note.c_str());
        return line.data();
    }

} // namespace

ui::cli::Outcome bench_gape(const GapeBenchOptions& options, const Job& job)
{
    ui::cli::Outcome outcome;
    ui::cli::Json results = ui::cli::Json::array();
    outcome.text = "An 80 mm cut through a large sheet under uniaxial tension: gape at the middle, closed form 2 e L\n"
                   "model            strain    tets  gape mm right mm error %       ms\n";
    for (const GapeRow& row : gape_rows(options, job)) {
        results.push_back(as_json(row));
        outcome.text += as_text(row);
    }
    outcome.document["results"] = results;
    if (!options.out.empty() && !job.cancelled()) {
        const std::filesystem::path folder = options.out;
        ui::cli::make_folder(folder);
        ui::cli::Json pictures = ui::cli::Json::array();
        for (const GapePicture& picture : draw_gapes(folder, job)) {
            pictures.push_back(
                { { "strain", picture.strain }, { "gape_mm", picture.gape_mm }, { "spring_seconds", picture.seconds },
                    { "status", picture.status }, { "file", picture.file.string() } });
            outcome.text += picture.file.string() + ": " + picture.status + "\n";
        }
        outcome.document["pictures"] = pictures;
        write_file_atomically(folder / "bench_gape.json", outcome.document.dump(2) + "\n");
    }
    if (job.cancelled()) {
        outcome.text += "cancelled\n";
        outcome.exit_code = 1;
    }
    return outcome;
}

} // namespace retractor::benchmarks
