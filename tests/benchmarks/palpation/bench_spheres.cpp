#include "tests/benchmarks/palpation/bench_spheres.h"
#include "mesh/base/text_format.h"

#include "haptics/condensed/sneddon.h"
#include "haptics/hand/obj_surface.h"
#include "haptics/spheres/sphere_tissue.h"
#include "mesh/base/atomic_file.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/framework/cpu_watch.h"
#include "tests/benchmarks/palpation/palpation_bench.h"
#include "tests/benchmarks/palpation/punch_reference.h"
#include "tests/benchmarks/palpation/sphere_scenes.h"
#include "tests/support/haptics/organ_volumes.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/results/field_files.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

namespace retractor::benchmarks {

namespace {

    constexpr double kTip = 8.0; // mm
    constexpr double kDisplayFrame = 1.0 / 60.0; // s
    constexpr double kDeep = 15.0; // mm

    /// Fingers on the front of an organ as in a grasp, with the path of each finger.
    struct Grip {
        std::vector<Vec3> point, inward;
    };

    Grip grip_on(const TriMesh& surface, std::size_t fingers)
    {
        const Vec3 low = surface.vertices.colwise().minCoeff().transpose(),
                   high = surface.vertices.colwise().maxCoeff().transpose();
        const Vec3 middle = 0.5 * (low + high), extent = high - low;
        Grip grip;
        for (std::size_t f = 0; f < fingers; ++f) {
            // Across the front from left to right, slightly up and down.
            const double across
                = fingers == 1 ? 0.0 : -0.28 + 0.56 * static_cast<double>(f) / static_cast<double>(fingers - 1);
            const Vec3 from
                = middle + Vec3(across * extent.x(), -extent.y(), ((f % 2 == 0) ? 0.08 : -0.08) * extent.z());
            const haptics::NearestOnSurface at = haptics::nearest_on_surface(from, surface.vertices, surface.triangles);
            grip.point.push_back(at.point);
            grip.inward.push_back((at.point - from).normalized());
        }
        return grip;
    }

    std::vector<haptics::Fingertip> tips_at(const Grip& grip, double depth)
    {
        std::vector<haptics::Fingertip> tips;
        for (std::size_t f = 0; f < grip.point.size(); ++f)
            tips.push_back({ grip.point[f] + (depth - kTip) * grip.inward[f], Vec3::Zero(), kTip });
        return tips;
    }

    struct Frames {
        double advance_ms = 0.0, deform_ms = 0.0;
        double displaced = 0.0; ///< displaced spheres per frame
        double volume_error = 0.0; ///< largest error of an organ over the run
        double force = 0.0; ///< force of the first finger at the deepest place, N
    };

    /// Two presses as in fig. 6 of [Suzuki and others, Performing virtual surgery with a force feedback system].
    /// Processor time, medians over the frames.
    Frames press_twice(haptics::SphereMotion& motion, const Grip& grip, std::string* csv = nullptr)
    {
        constexpr int kFrames = 120;
        std::vector<double> advance, deform;
        std::vector<haptics::SphereContact> contacts(grip.point.size());
        Points deformed;
        Frames result;
        for (int i = 0; i < kFrames; ++i) {
            const double phase = std::sin(2.0 * 3.14159265358979323846 * i / 60.0);
            const std::vector<haptics::Fingertip> tips = tips_at(grip, kDeep * phase);
            CpuWatch watch;
            motion.advance(kDisplayFrame, tips, contacts);
            advance.push_back(watch.milliseconds());
            watch = {};
            motion.deform(deformed);
            deform.push_back(watch.milliseconds());
            for (const haptics::SphereContact& contact : contacts)
                result.displaced += static_cast<double>(contact.spheres) / kFrames;
            result.force = std::max(result.force, contacts[0].force.norm());
            if (i % 5 == 0)
                for (const auto& volume : test_support::organ_volumes(motion))
                    if (std::abs(volume.error()) > std::abs(result.volume_error))
                        result.volume_error = volume.error();
            if (csv != nullptr)
                for (std::size_t f = 0; f < contacts.size(); ++f) {
                    std::array<char, 96> line {};
                    std::snprintf(
                        line.data(), line.size(), "%.4f,%zu,%.6f\n", i * kDisplayFrame, f, contacts[f].force.norm());
                    *csv += line.data();
                }
        }
        // The slower half of the pressing frames, which a display must keep up with.
        std::sort(advance.begin(), advance.end());
        result.advance_ms = advance[static_cast<std::size_t>(0.75 * static_cast<double>(advance.size()))];
        result.deform_ms = median(deform);
        return result;
    }

    /// Moved and drawn frames, off-screen: the work of a window on a machine without a graphics card.
    double frames_drawn_per_second(haptics::SphereMotion& motion, const Grip& grip, const Job& job)
    {
        constexpr int kFrames = 20, kWarm = 2; // the first pictures compile shaders
        constexpr int kWidth = 940, kHeight = 540; // size of the picture in the window
        ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
        ui::Picture picture { .width = kWidth, .height = kHeight, .viewports = {} };
        ui::Scene scene;
        scene.surfaces.push_back({ .name = "tissue",
            .mesh = std::make_shared<TriMesh>(motion.surface()),
            .look = ui::tissue_look("liver") });
        scene.camera = ui::camera_for_box(*ui::scene_bounds(scene), Vec3::UnitY(), Vec3::UnitZ());
        picture.viewports.push_back({ .scene = scene });
        std::vector<haptics::SphereContact> contacts(grip.point.size());
        TriMesh moved = motion.surface();
        std::vector<double> seconds;
        for (int i = 0; i < kFrames + kWarm; ++i) {
            const Stopwatch watch;
            motion.advance(kDisplayFrame, tips_at(grip, kDeep * std::sin(0.1 * i)), contacts);
            motion.deform(moved.vertices);
            picture.viewports[0].scene.surfaces[0].mesh = std::make_shared<TriMesh>(moved);
            renderer.render(picture);
            if (i >= kWarm)
                seconds.push_back(watch.seconds());
        }
        return 1.0 / median(seconds);
    }

    PalpationRow row_of(const std::string& scene, haptics::SphereMotion& motion, const Grip& grip, const Job& job)
    {
        const Frames frames = press_twice(motion, grip);
        PalpationRow row {
            .model = "spheres", .scene = scene, .vertices = motion.sphere_count(), .fingers = grip.point.size()
        };
        row.deform_ms_median = frames.advance_ms + frames.deform_ms;
        row.fps = 1e3 / *row.deform_ms_median;
        row.note = std::to_string(motion.law().depth_limit) + " layers, " + formatted("%.0f", frames.displaced)
            + " spheres moved, volume " + formatted("%+.2f", 100.0 * frames.volume_error) + " %, "
            + formatted("%.3f N", frames.force);
        row.fps_drawn = frames_drawn_per_second(motion, grip, job);
        row.note += ", drawn " + formatted("%.0f", *row.fps_drawn) + " frames/s";
        return row;
    }

    void time_servo(
        PalpationRow& row, std::vector<haptics::SphereOrgan> organs, const haptics::SphereLaw& law, const Grip& grip)
    {
        haptics::SphereTissue tissue(std::move(organs), law);
        Points deformed;
        std::size_t tick = 0;
        const TickCost cost = time_ticks(
            tissue,
            [&](double time, std::span<haptics::Fingertip> fingers) {
                const std::vector<haptics::Fingertip> tips = tips_at(grip, kDeep * std::sin(6.0 * time));
                std::copy(tips.begin(), tips.end(), fingers.begin());
                if (++tick % 16 == 0)
                    tissue.follow(deformed); // the time of a tick excludes this
            },
            3000);
        row.force_us_mean = cost.mean_us;
        row.force_us_p999 = cost.p999_us;
        row.ticks = cost.ticks;
        row.missed = cost.missed;
    }

    /// Force of a block of spheres under a bonded patch, compared with ten-node elements of the modulus of
    /// calibration.
    PalpationRow error_row(const Job& job)
    {
        constexpr double kDepth = 3.0, kModulus = 0.0054, kRatio = 0.49, kRadius = 3.0;
        const haptics::SphereLaw law;
        // Sneddon's formula gives the force of a spherical finger on a half-space; elements give the force on a block
        // of 96 x 96 x 48 on its bottom.
        PunchProblem problem = punched_block(24, 12, 4.0, kDepth, { "liver", kModulus, 0.45, 1.0e-9, "bench" });
        problem.radius = kTip;
        const PunchAnswer reference = punch_by_elements(problem, true, job);
        TriMesh box;
        const double width = 96.0, height = 48.0;
        box.vertices.resize(8, 3);
        for (int v = 0; v < 8; ++v)
            box.vertices.row(v) << ((v & 1) != 0 ? width : 0.0), ((v & 2) != 0 ? width : 0.0),
                ((v & 4) != 0 ? height : 0.0);
        box.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 }, { 2, 6, 3 },
            { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
        haptics::SphereOrgan block { "block", box, haptics::fill_with_spheres(box, kRadius),
            haptics::calibrate_sphere_force(kRadius, law, kModulus, kRatio) };
        haptics::SphereMotion motion({ block }, law);
        PalpationRow row { .model = "spheres", .scene = "block 96 x 96 x 48", .vertices = motion.sphere_count() };
        std::string forces;
        haptics::SphereContact contact;
        for (const double depth : { 1.0, 2.0, 4.0, 6.0 }) {
            for (int i = 0; i < 60; ++i) {
                const haptics::Fingertip tip { Vec3(0.5 * width, 0.5 * width, height + kTip - depth), Vec3::Zero(),
                    kTip };
                motion.advance(kDisplayFrame, { &tip, 1 }, { &contact, 1 });
            }
            const double right = haptics::sneddon_force(depth, kTip, kModulus, kRatio);
            forces += formatted(" %.0f mm", depth) + formatted(": %.4f", contact.force.z())
                + formatted(" N (half-space %.4f)", right);
            if (depth == 6.0)
                row.rel_error_vs_reference = contact.force.z() / right - 1.0;
        }
        // A sphere filling aims at the right force, not at the right motion of the surface beside the finger. Only
        // the force is compared.
        row.note
            = "calibrated at 4 mm;" + forces + formatted("; P2 flat punch of 8 mm at 3 mm %.4f N", reference.force);
        return row;
    }

    void write_pictures(const std::filesystem::path& folder, const TriMesh& liver, const Job& job)
    {
        ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
        haptics::SphereLaw law;
        law.fingers = 3;
        // As fig. 3 of Suzuki and others: three fingers grasp the liver; left the surface, right the spheres inside.
        haptics::SphereMotion motion({ filled_organ("liver", liver, 1880, law, 0.0054, 0.49) }, law);
        const Grip grip = grip_on(liver, 3);
        ui::Picture picture { .width = 1280, .height = 1440, .viewports = {} };
        std::vector<haptics::SphereContact> contacts(3);
        for (int row = 0; row < 3; ++row) {
            const double depth = -4.0 + 9.0 * row;
            const std::vector<haptics::Fingertip> tips = tips_at(grip, depth);
            for (int i = 0; i < 10; ++i)
                motion.advance(kDisplayFrame, tips, contacts);
            for (const bool spheres : { false, true }) {
                ui::Scene scene = sphere_scene(motion, spheres ? SphereView::spheres : SphereView::textured, tips);
                scene.title = spheres
                    ? formatted("%.0f spheres", static_cast<double>(motion.sphere_count()))
                    : formatted("%.0f mm deep", depth) + formatted(", %.2f N", contacts[0].force.norm());
                picture.viewports.push_back({ .left = spheres ? 0.5 : 0.0,
                    .bottom = (2.0 - row) / 3.0,
                    .right = spheres ? 1.0 : 0.5,
                    .top = (3.0 - row) / 3.0,
                    .scene = scene });
            }
        }
        ui::write_png(folder / "liver_fingers.png", renderer.render(picture));

        // Six fingers, three of each hand, on the wall over liver and stomach.
        law.fingers = 6;
        haptics::SphereMotion abdomen(abdomen_organs(law, job), law);
        const Grip both = grip_on(abdomen.organ(2).surface, 6);
        contacts.resize(6);
        const std::vector<haptics::Fingertip> tips = tips_at(both, 18.0);
        for (int i = 0; i < 30; ++i)
            abdomen.advance(kDisplayFrame, tips_at(both, -5.0 + 23.0 * std::min(1.0, i / 20.0)), contacts);
        ui::Picture six { .width = 1600, .height = 600, .viewports = {} };
        const std::array<std::size_t, 1> wall { 2 };
        const std::array<std::pair<ui::Scene, const char*>, 3> views {
            { { sphere_scene(abdomen, SphereView::textured, tips), "skin pressed with six fingers" },
                { sphere_scene(abdomen, SphereView::colored, tips, wall), "liver and stomach beneath it" },
                { sphere_scene(abdomen, SphereView::spheres, tips, wall), "their spheres (bright: displaced)" } }
        };
        for (std::size_t i = 0; i < views.size(); ++i) {
            ui::Scene scene = views[i].first;
            scene.title = views[i].second;
            six.viewports.push_back(
                { .left = static_cast<double>(i) / 3.0, .right = static_cast<double>(i + 1) / 3.0, .scene = scene });
        }
        ui::write_png(folder / "abdomen_six_fingers.png", renderer.render(six));

        // As fig. 6 of Suzuki and others: force over time, two presses.
        law.fingers = 1;
        haptics::SphereMotion again({ filled_organ("liver", liver, 1880, law, 0.0054, 0.49) }, law);
        std::string csv = "time_s,finger,force_N\n";
        press_twice(again, grip_on(liver, 1), &csv);
        write_file_atomically(folder / "two_presses.csv", csv);
        ui::ChartPicture chart { .x_title = "time, s",
            .y_title = "force on the forefinger, N",
            .panels = { {} },
            .columns = 1,
            .panel_width = 900,
            .panel_height = 500,
            .logarithmic_x = false,
            .logarithmic_y = false };
        chart.panels[0].title = "Two presses on the liver of 1,880 spheres";
        ui::ChartSeries series { .name = "force", .x = {}, .y = {}, .marks = false };
        std::size_t at = csv.find('\n') + 1;
        while (at < csv.size()) {
            double time = 0.0, force = 0.0;
            int finger = 0;
            std::sscanf(csv.c_str() + at, "%lf,%d,%lf", &time, &finger, &force);
            series.x.push_back(time);
            series.y.push_back(force);
            at = csv.find('\n', at) + 1;
        }
        chart.panels[0].series.push_back(series);
        ui::write_png(folder / "two_presses.png", renderer.render(chart));
    }

} // namespace

ui::cli::Outcome bench_spheres(const SphereBenchOptions& options, const Job& job)
{
    const TriMesh liver = options.surface.empty() ? phantom_liver_surface(job)
                                                  : haptics::read_obj_surface(options.surface, options.unit_mm);
    std::vector<PalpationRow> rows;
    const auto one = [&](std::size_t count, int depth, std::size_t fingers, bool servo) {
        job.report("liver", 0.1 * static_cast<double>(rows.size()));
        haptics::SphereLaw law;
        law.depth_limit = depth;
        law.fingers = fingers;
        haptics::SphereOrgan organ = filled_organ("liver", liver, count, law, 0.0054, 0.49);
        const std::string name = "liver of " + std::to_string(organ.filling.count()) + " spheres";
        const Grip grip = grip_on(liver, fingers);
        haptics::SphereMotion motion({ organ }, law);
        PalpationRow row = row_of(name, motion, grip, job);
        if (servo)
            time_servo(row, { organ }, law, grip);
        rows.push_back(std::move(row));
        ui::cli::refuse_if_cancelled(job);
    };
    one(1880, 8, 1, true);
    one(1880, 8, 3, false);
    one(1880, 8, 6, true);
    for (const int depth : { 2, 4, 16, 32 })
        one(1880, depth, 3, false);
    one(20000, 8, 1, true);
    one(20000, 8, 6, true);
    one(20000, 60, 6, false); // at the largest depth
    {
        haptics::SphereLaw law;
        law.fingers = 6;
        std::vector<haptics::SphereOrgan> organs = abdomen_organs(law, job);
        const Grip grip = grip_on(organs[2].surface, 6);
        haptics::SphereMotion motion(organs, law);
        PalpationRow row = row_of("abdomen: skin, liver, stomach", motion, grip, job);
        time_servo(row, organs, law, grip);
        rows.push_back(std::move(row));
    }
    rows.push_back(error_row(job));
    ui::cli::Outcome outcome;
    ui::cli::Json results = ui::cli::Json::array();
    for (const PalpationRow& row : rows)
        results.push_back(row_document(row));
    outcome.document = { { "results", results },
        { "notes",
            "vertices: spheres; deform_ms_median: one frame's motion and surface while pressed (75th percentile); fps: "
            "its inverse, without drawing; fps_drawn: moved and drawn off-screen at 940 x 540, wall time on this "
            "machine; "
            "rel_error_vs_reference: against an elastic half-space" } };
    outcome.text = row_table(rows);
    if (!options.out.empty()) {
        ui::cli::make_folder(options.out);
        const std::filesystem::path folder = options.out;
        write_file_atomically(folder / "bench_spheres.json", outcome.document.dump(2) + "\n");
        write_pictures(folder, liver, job);
        outcome.text += "Written: " + (folder / "bench_spheres.json").string()
            + ", liver_fingers.png, abdomen_six_fingers.png, two_presses.png and .csv\n";
    }
    return outcome;
}

} // namespace retractor::benchmarks
