#include "tests/benchmarks/palpation/bench_springs.h"

#include "fem/material/material.h"
#include "haptics/springs/spring_tissue.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/palpation/palpation_bench.h"
#include "tests/benchmarks/palpation/punch_reference.h"
#include "tests/benchmarks/palpation/spring_pictures.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/results/field_files.h"
#include "ui/scene/vtk/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

namespace retractor::benchmarks {

namespace {

    constexpr std::size_t kTicks = 3000;
    constexpr double kRadius = 4.0; // radius of the fingertip, mm
    constexpr double kLiveSeconds = 2.0;
    constexpr int kFrameWidth = 640, kFrameHeight = 480;

    /// Presses the middle 3 mm deep and releases it, once a second.
    void press_and_release(double time, std::span<haptics::Fingertip> fingers)
    {
        const double depth = 1.5 - 4.5 * std::cos(2.0 * std::numbers::pi * time); // -3 above to 6 ... clipped below
        for (haptics::Fingertip& finger : fingers) {
            finger.position = Vec3(0.0, 0.0, kRadius - std::min(3.0, depth));
            finger.radius = kRadius;
        }
    }

    std::unique_ptr<haptics::SpringTissue> sheet_of(int side)
    {
        const haptics::DeviceVoigt voigt = haptics::device_voigt({});
        haptics::SheetOptions options;
        options.columns = options.rows = side;
        options.stiffness = voigt.stiffness;
        return std::make_unique<haptics::SpringTissue>(
            haptics::make_spring_sheet(options), haptics::ElementLaw { .voigt_time = voigt.voigt_time });
    }

    std::string sheet_name(int side)
    {
        std::array<char, 64> text {};
        std::snprintf(text.data(), text.size(), "sheet %d x %d, %zu springs", side, side,
            haptics::make_spring_sheet({ .columns = side, .rows = side }).springs.size());
        return text.data();
    }

    /// Draws the deformed sheet off-screen: the work of a window.
    class SheetView {
    public:
        explicit SheetView(const TriMesh& surface, const Job& job)
            : renderer_(ui::make_offscreen_context(), job)
            , mesh_(std::make_shared<TriMesh>(surface))
        {
            picture_.width = kFrameWidth;
            picture_.height = kFrameHeight;
            picture_.viewports.push_back({ .scene = sheet_scene(mesh_, {}) });
        }
        void draw(const Points& deformed)
        {
            mesh_ = std::make_shared<TriMesh>(TriMesh { deformed, mesh_->triangles, {} });
            picture_.viewports[0].scene.surfaces[0].mesh = mesh_;
            renderer_.render(picture_);
        }

    private:
        ui::OffscreenRenderer renderer_;
        std::shared_ptr<TriMesh> mesh_;
        ui::Picture picture_;
    };

    PalpationRow sheet_row(int side, const Job& job)
    {
        const auto tissue = sheet_of(side);
        PalpationRow row {
            .model = "springs", .scene = sheet_name(side), .vertices = tissue->motion().body().mass.size()
        };
        const TickCost times = time_ticks(*tissue, press_and_release, side > 50 ? kTicks / 10 : kTicks);
        row.force_us_mean = times.mean_us;
        row.force_us_p999 = times.p999_us;
        std::vector<double> follow;
        Points deformed;
        for (int i = 0; i < 200; ++i) {
            const Stopwatch watch;
            tissue->follow(deformed);
            follow.push_back(1e3 * watch.seconds());
        }
        row.deform_ms_median = median(follow);
        SheetView view(tissue->surface(), job);
        const auto live_tissue = sheet_of(side);
        const LiveRun live = run_live(
            *live_tissue, press_and_release, kLiveSeconds, [&](const Points& now) { view.draw(now); }, job);
        row.fps = median(live.fps);
        row.ticks = live.ticks.ticks;
        row.missed = live.ticks.missed;
        std::array<char, 96> text {};
        std::snprintf(text.data(), text.size(), "stable step %.3g s: %d steps a tick", tissue->motion().stable_step(),
            tissue->steps_of(1e-3));
        row.note = text.data();
        return row;
    }

    /// Force of the springs on a patch that is pressed in and held until the remainder has settled.
    double settled_press(const PunchProblem& problem, double calibration)
    {
        const std::vector<double> moduli(problem.mesh.tet_count(), problem.material.youngs_modulus_MPa);
        // The drag is near the critical drag of the slowest motion, sqrt(E / density) times pi / 2 over the height of
        // the block.
        constexpr double kDrag = 300.0, kSettled = 0.15; // per second, s
        const std::vector<VertexId> patch = punch_patch(problem);
        std::vector<VertexId> held = problem.fixed;
        held.insert(held.end(), patch.begin(), patch.end());
        haptics::SpringMotion motion(
            haptics::make_spring_organ(problem.mesh, moduli, problem.material.density_tonne_per_mm3, held, calibration),
            { .voigt_time = 0.0, .drag = kDrag });
        for (const VertexId v : patch)
            motion.place(v, problem.mesh.vertices.row(v).transpose() + problem.press);
        const double dt = 0.5 * motion.stable_step();
        for (double time = 0.0; time < kSettled; time += dt)
            motion.step(dt);
        Vec3 force = Vec3::Zero();
        for (const VertexId v : patch)
            force += motion.element_force(v);
        return -force.dot(problem.press.normalized());
    }

    /// Compares springs on the edges of an organ with ten-node elements of the same organ.
    std::vector<PalpationRow> organ_rows(const Job& job)
    {
        std::vector<PalpationRow> rows;
        constexpr double kDepth = 0.5; // mm: small enough for linear elasticity
        for (const double ratio : { 0.25, 0.45 }) {
            const fem::Material tissue { "soft tissue", 0.02, ratio, 1.0e-9, "bench" };
            const PunchProblem problem = punched_block(12, 6, 4.0, kDepth, tissue);
            const PunchAnswer reference = punch_by_elements(punched_block(24, 12, 2.0, kDepth, tissue), true, job);
            const PunchAnswer same = punch_by_elements(problem, false, job);
            const double springs = settled_press(problem, 1.0);
            PalpationRow row { .model = "springs", .vertices = problem.mesh.vertex_count() };
            std::array<char, 200> text {};
            std::snprintf(text.data(), text.size(), "block 48 x 48 x 24, nu %.2f", ratio);
            row.scene = text.data();
            row.rel_error_vs_reference = springs / reference.force - 1.0;
            row.rel_diff_same_mesh = springs / same.force - 1.0;
            std::snprintf(text.data(), text.size(),
                "punch %.1f mm deep: springs %.4f N, P1 %.4f N, P2 of half the size (%zu nodes) %.4f N; springs' own "
                "nu is 1/4",
                kDepth, springs, same.force, reference.nodes, reference.force);
            row.note = text.data();
            rows.push_back(row);
        }
        return rows;
    }

    /// Compares the sheet, which does not represent a solid, with a block of its size and in-plane stiffness that is
    /// held at its sides.
    PalpationRow sheet_error_row(const Job& job)
    {
        constexpr double kDepth = 2.0, kThickness = 8.0;
        const haptics::DeviceVoigt voigt = haptics::device_voigt({});
        // In the plane of the sheet there are structural springs k, bending springs 4 k and shear springs k along an
        // axis, and k across the sheet: E t = 6 k - k / 6.
        const double modulus = voigt.stiffness * (6.0 - 1.0 / 6.0) / kThickness;
        PunchProblem problem = punched_block(12, 4, 2.0, kDepth, { "sheet", modulus, 0.45, 1.0e-9, "bench" });
        problem.fixed.clear();
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v)
            if (problem.mesh.vertices(v, 0) == 0.0 || problem.mesh.vertices(v, 0) == 24.0
                || problem.mesh.vertices(v, 1) == 0.0 || problem.mesh.vertices(v, 1) == 24.0)
                problem.fixed.push_back(v);
        problem.radius = 2.0;
        const PunchAnswer reference = punch_by_elements(problem, true, job);
        const auto tissue = sheet_of(25);
        haptics::Fingertip finger { Vec3(0.0, 0.0, kRadius + 0.5), Vec3::Zero(), kRadius };
        haptics::FingerContact contact;
        for (int i = 0; i < 3000; ++i) {
            finger.position.z() = std::max(kRadius - kDepth, finger.position.z() - 0.01);
            tissue->tick(i * 1e-3, 1e-3, { &finger, 1 }, { &contact, 1 });
        }
        PalpationRow row { .model = "springs", .scene = "sheet 25 x 25 as a solid", .vertices = 625 };
        row.rel_error_vs_reference = contact.force.z() / reference.force - 1.0;
        std::array<char, 200> text {};
        std::snprintf(text.data(), text.size(),
            "pressed 2 mm: sheet %.4f N, P2 block 24 x 24 x 8 of the same in-plane stiffness (E %.3f MPa) %.4f N",
            contact.force.z(), modulus, reference.force);
        row.note = text.data();
        return row;
    }

    ui::cli::Outcome frame_curves(const SpringBenchOptions& options, const Job& job)
    {
        ui::cli::Outcome outcome;
        ui::cli::Json results = ui::cli::Json::array();
        ui::ChartPicture chart { .x_title = "time, s",
            .y_title = "frames per second",
            .panels = { {} },
            .columns = 1,
            .panel_width = 900,
            .panel_height = 560,
            .logarithmic_x = false,
            .logarithmic_y = false };
        chart.panels[0].title = "Frames per second while the sheet is pressed (ticks at 1 kHz beside it)";
        std::string csv = "side,second,frames_per_second\n";
        std::vector<PalpationRow> rows;
        for (const int side : { 20, 25, 30 }) {
            const auto tissue = sheet_of(side);
            SheetView view(tissue->surface(), job);
            const LiveRun live = run_live(
                *tissue, press_and_release, options.seconds, [&](const Points& now) { view.draw(now); }, job);
            ui::ChartSeries series {
                .name = std::to_string(side * side) + " particles", .x = {}, .y = {}, .marks = false
            };
            for (std::size_t i = 0; i < live.fps.size(); ++i) {
                series.x.push_back(static_cast<double>(i + 1));
                series.y.push_back(live.fps[i]);
                csv += std::to_string(side) + "," + std::to_string(i + 1) + "," + std::to_string(live.fps[i]) + "\n";
            }
            chart.panels[0].series.push_back(std::move(series));
            PalpationRow row {
                .model = "springs", .scene = sheet_name(side), .vertices = static_cast<std::size_t>(side * side)
            };
            row.fps = median(live.fps);
            row.force_us_mean = live.ticks.mean_us;
            row.force_us_p999 = live.ticks.p999_us;
            row.ticks = live.ticks.ticks;
            row.missed = live.ticks.missed;
            rows.push_back(row);
            results.push_back(row_document(row));
        }
        outcome.document = { { "results", results }, { "seconds", options.seconds } };
        outcome.text = row_table(rows);
        if (!options.out.empty()) {
            ui::cli::make_folder(options.out);
            const std::filesystem::path folder = options.out;
            write_file_atomically(folder / "frame_rate.csv", csv);
            ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
            ui::write_png(folder / "frame_rate.png", renderer.render(chart));
            write_file_atomically(folder / "bench_springs_curves.json", outcome.document.dump(2) + "\n");
            outcome.text
                += "Written: " + (folder / "frame_rate.png").string() + ", frame_rate.csv, bench_springs_curves.json\n";
        }
        return outcome;
    }

} // namespace

ui::cli::Outcome bench_springs(const SpringBenchOptions& options, const Job& job)
{
    if (options.curves)
        return frame_curves(options, job);
    std::vector<PalpationRow> rows;
    const std::array<int, 4> sides { 20, 25, 30, 100 };
    for (std::size_t i = 0; i < sides.size(); ++i) {
        job.report("sheets", static_cast<double>(i) / sides.size());
        rows.push_back(sheet_row(sides[i], job));
        ui::cli::refuse_if_cancelled(job);
    }
    job.report("finite elements", 0.0);
    for (PalpationRow& row : organ_rows(job))
        rows.push_back(std::move(row));
    rows.push_back(sheet_error_row(job));
    ui::cli::Outcome outcome;
    ui::cli::Json results = ui::cli::Json::array();
    for (const PalpationRow& row : rows)
        results.push_back(row_document(row));
    outcome.document = { { "results", results } };
    outcome.text = row_table(rows);
    if (!options.out.empty()) {
        ui::cli::make_folder(options.out);
        const std::filesystem::path folder = options.out;
        write_file_atomically(folder / "bench_springs.json", outcome.document.dump(2) + "\n");
        write_spring_pictures(folder, job);
        outcome.text
            += "Written: " + (folder / "bench_springs.json").string() + ", tissue_curves.png and .csv, sheet.png\n";
    }
    return outcome;
}

} // namespace retractor::benchmarks
