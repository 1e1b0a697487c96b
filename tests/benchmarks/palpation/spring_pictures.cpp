#include "tests/benchmarks/palpation/spring_pictures.h"

#include "haptics/springs/spring_tissue.h"
#include "mesh/base/atomic_file.h"
#include "tests/support/haptics/ring_load.h"
#include "tests/support/haptics/spring_bodies.h"
#include "ui/cli/framework/ball_mesh.h"
#include "ui/scene/vtk/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace retractor::benchmarks {

namespace {

    constexpr double kRadius = 4.0; // mm
    constexpr double kSpringTick = 1e-3; // s
    constexpr double kArmRatio = 1.0, kArmTime = 4.0; // s: relaxation to a half, as in kidney and skin [PMC7595329]
    constexpr double kTaken = 0.4; // s after the press, when the sheet's own vibrations are over

    haptics::ElementLaw slow_tissue()
    {
        return { .voigt_time = 0.001, .arm_ratio = kArmRatio, .arm_time = kArmTime, .drag = 100.0 };
    }

    /// A finger over a sheet.
    struct Press {
        haptics::SpringTissue tissue;
        haptics::Fingertip tip { Vec3(0.0, 0.0, kRadius), Vec3::Zero(), kRadius };
        haptics::FingerContact contact {};
        double time = 0.0;

        explicit Press(const haptics::ElementLaw& law)
            : tissue(haptics::make_spring_sheet(), law)
        {
        }
        void move_to(double z, double seconds)
        {
            const double from = tip.position.z();
            const int ticks = std::max(1, static_cast<int>(std::lround(seconds / kSpringTick)));
            for (int i = 1; i <= ticks; ++i) {
                tip.position.z() = from + (z - from) * i / ticks;
                tissue.tick(time += kSpringTick, kSpringTick, { &tip, 1 }, { &contact, 1 });
            }
        }
    };

    /// Force (N) of Sneddon's rigid sphere on a half-space at a depth (mm): the force of a uniform tissue.
    double sneddon(double depth, double radius, double modulus, double ratio)
    {
        // the contact radius a follows from depth = a / 2 ln((R + a) / (R - a))
        double low = 0.0, high = radius * (1.0 - 1e-12);
        for (int i = 0; i < 200; ++i) {
            const double a = 0.5 * (low + high);
            (0.5 * a * std::log((radius + a) / (radius - a)) < depth ? low : high) = a;
        }
        const double a = 0.5 * (low + high);
        return 0.5 * modulus / (1.0 - ratio * ratio)
            * ((radius * radius + a * a) * std::log((radius + a) / (radius - a)) - 2.0 * a * radius);
    }

    ui::ChartSeries line(std::string name) { return { .name = std::move(name), .x = {}, .y = {}, .marks = false }; }

    ui::ChartPanel force_displacement()
    {
        ui::ChartPanel panel {
            .title = "Force and displacement", .series = {}, .x_title = "depth, mm", .y_title = "force, N"
        };
        ui::ChartSeries sheet = line("sheet 25 x 25"), stretched = line("sheet, stretched 10 %"),
                        liver = line("liver 5.4 kPa [PMC6925591]"), muscle = line("muscle 40 kPa [PMC9711973]");
        Press slack({ .drag = 30.0 });
        haptics::SpringTissue tight(haptics::make_spring_sheet({ .pre_strain = 0.1 }), { .drag = 30.0 });
        haptics::Fingertip tip { Vec3(0.0, 0.0, kRadius), Vec3::Zero(), kRadius };
        haptics::FingerContact contact;
        for (int step = 1; step <= 30; ++step) {
            const double depth = 0.1 * step;
            slack.move_to(kRadius - depth, 0.1);
            tip.position.z() = kRadius - depth;
            for (int i = 0; i < 100; ++i)
                tight.tick(0.0, kSpringTick, { &tip, 1 }, { &contact, 1 });
            const std::array<std::pair<ui::ChartSeries*, double>, 4> points { { { &sheet, slack.contact.force.z() },
                { &stretched, contact.force.z() }, { &liver, sneddon(depth, kRadius, 0.0054, 0.49) },
                { &muscle, sneddon(depth, kRadius, 0.04, 0.49) } } };
            for (const auto& [series, force] : points) {
                series->x.push_back(depth);
                series->y.push_back(force);
            }
        }
        panel.series = { sheet, stretched, liver, muscle };
        return panel;
    }

    ui::ChartPanel relaxation()
    {
        constexpr double kEvery = 0.15; // s
        ui::ChartPanel panel { .title = "Relaxation: pressed 2 mm and held",
            .series = {},
            .x_title = "time, s",
            .y_title = "force / first force" };
        for (const bool arms : { true, false }) {
            haptics::ElementLaw law = slow_tissue();
            if (!arms)
                law.arm_ratio = 0.0;
            Press press(law);
            press.move_to(kRadius - 2.0, 0.1);
            press.move_to(kRadius - 2.0, kTaken);
            const double first = press.contact.force.z();
            ui::ChartSeries series = line(arms ? "with Maxwell arms" : "Voigt only");
            for (int i = 0; i <= 80; ++i) {
                series.x.push_back(kEvery * i);
                series.y.push_back(press.contact.force.z() / first);
                press.move_to(kRadius - 2.0, kEvery);
            }
            panel.series.push_back(series);
        }
        ui::ChartSeries closed = line("closed form of one element"),
                        half = line("1/2: kidney, skin, spleen reach below [PMC7595329]");
        for (int i = 0; i <= 80; ++i) {
            const auto left = [](double time) { return 1.0 + kArmRatio * std::exp(-time / kArmTime); };
            closed.x.push_back(kEvery * i);
            closed.y.push_back(left(kTaken + kEvery * i) / left(kTaken));
            half.x.push_back(kEvery * i);
            half.y.push_back(0.5);
        }
        panel.series.push_back(closed);
        panel.series.push_back(half);
        return panel;
    }

    /// One element of the sheet, along x under a constant force.
    ui::ChartPanel creep()
    {
        constexpr double kStiffness = 0.075, kForce = 0.05, kStep = 2e-4, kVoigt = 0.4;
        ui::ChartPanel panel { .title = "Creep of one element under 0.05 N",
            .series = {},
            .x_title = "time, s",
            .y_title = "displacement, mm" };
        haptics::SpringBody body;
        body.surface.vertices = Points::Zero(2, 3);
        body.surface.vertices(1, 0) = 1.0;
        body.springs = { { 0, 1, 1.0, kStiffness } };
        body.mass = { 1e-8, 1e-8 };
        body.held = { 1, 0 };
        for (const bool voigt : { true, false }) {
            haptics::SpringMotion motion(body,
                { .voigt_time = voigt ? kVoigt : 0.001,
                    .arm_ratio = voigt ? 0.0 : kArmRatio,
                    .arm_time = kArmTime,
                    .drag = 0.0 });
            motion.set_load(1, Vec3(kForce, 0.0, 0.0));
            ui::ChartSeries simulated = line(voigt ? "Voigt" : "standard linear solid");
            ui::ChartSeries closed = line(voigt ? "Voigt, closed form" : "standard linear solid, closed form");
            for (int i = 0; i <= 80; ++i) {
                const double t = 0.1 * i;
                simulated.x.push_back(t);
                simulated.y.push_back(motion.position(1).x() - 1.0);
                closed.x.push_back(t);
                closed.y.push_back(kForce / kStiffness
                    * (voigt ? 1.0 - std::exp(-t / kVoigt)
                             : 1.0 - kArmRatio / (1.0 + kArmRatio) * std::exp(-t / (kArmTime * (1.0 + kArmRatio)))));
                const double stable = std::min(kStep, motion.stable_step());
                const int steps = static_cast<int>(std::ceil(0.1 / stable));
                for (int s = 0; s < steps; ++s)
                    motion.step(0.1 / steps);
            }
            closed.marks = true;
            panel.series.push_back(simulated);
            panel.series.push_back(closed);
        }
        return panel;
    }

    std::string csv_of(const ui::ChartPicture& chart)
    {
        std::string csv = "panel,curve,x,y\n";
        for (const ui::ChartPanel& panel : chart.panels)
            for (const ui::ChartSeries& series : panel.series)
                for (std::size_t i = 0; i < series.x.size(); ++i) {
                    std::array<char, 96> numbers {};
                    std::snprintf(numbers.data(), numbers.size(), "%.6g,%.6g\n", series.x[i], series.y[i]);
                    csv += "\"" + panel.title + "\",\"" + series.name + "\"," + numbers.data();
                }
        return csv;
    }

    ui::Scene state_of(
        const haptics::SpringMotion& motion, const char* title, const std::vector<std::pair<Vec3, double>>& tips)
    {
        ui::Scene scene = sheet_scene(
            std::make_shared<TriMesh>(TriMesh { motion.positions(), motion.body().surface.triangles, {} }), tips);
        scene.title = title;
        return scene;
    }

    std::vector<ui::Scene> sheet_states()
    {
        std::vector<ui::Scene> scenes;
        const haptics::ElementLaw law { .drag = 30.0 };
        Press press(law);
        const auto tip = [](const Press& now) {
            return std::vector<std::pair<Vec3, double>> { { now.tip.position, now.tip.radius } };
        };
        press.move_to(kRadius + 2.0, 0.01);
        scenes.push_back(state_of(press.tissue.motion(), "not touched", tip(press)));
        press.move_to(kRadius - 4.0, 0.4);
        scenes.push_back(state_of(press.tissue.motion(), "pressed 4 mm", tip(press)));
        press.move_to(kRadius - 3.0, 0.4);
        press.tissue.grip(0, true);
        press.move_to(kRadius + 4.0, 0.7);
        scenes.push_back(state_of(press.tissue.motion(), "pulled 4 mm", tip(press)));
        press.tissue.grip(0, false);
        press.move_to(kRadius + 8.0, 0.5);
        scenes.push_back(state_of(press.tissue.motion(), "let go: half a second later", tip(press)));
        const auto settled = [&](const haptics::SpringBody& sheet, const Vec3& gravity, int load, const char* title) {
            haptics::ElementLaw heavy = law;
            heavy.gravity = gravity;
            haptics::SpringMotion motion(sheet, heavy);
            if (load == 1)
                motion.set_load(312, Vec3(0.0, 0.0, 0.4));
            else if (load == 2)
                test_support::set_ring_load(motion, 312, Vec3(0.0, 0.0, 0.4));
            for (int i = 0; i < 10000; ++i)
                motion.step(1e-4);
            scenes.push_back(state_of(motion, title, {}));
        };
        settled(haptics::make_spring_sheet(), Vec3(0.0, 0.0, -20.0 * haptics::kGravity), 0, "20 g, edges fixed");
        settled(test_support::hanging_sheet(), Vec3(0.0, 0.0, -haptics::kGravity), 0, "1 g, held at one side");
        settled(haptics::make_spring_sheet(), Vec3::Zero(), 1, "0.4 N on the point alone");
        settled(haptics::make_spring_sheet(), Vec3::Zero(), 2, "0.4 N on the point and its ring");
        return scenes;
    }

} // namespace

ui::Scene sheet_scene(std::shared_ptr<const TriMesh> sheet, std::span<const std::pair<Vec3, double>> tips)
{
    ui::Scene scene;
    scene.surfaces.push_back({ .name = "tissue",
        .mesh = std::move(sheet),
        .look = { .color = { 0.85, 0.45, 0.42 }, .finish = ui::Finish::skin },
        .show_edges = true });
    for (const auto& [centre, radius] : tips)
        scene.surfaces.push_back({ .name = "fingertip",
            .mesh = std::make_shared<TriMesh>(ui::cli::ball_mesh(centre, radius, 3)),
            .look = { .color = { 0.95, 0.95, 0.95 }, .finish = ui::Finish::matte } });
    scene.camera
        = { .eye = Vec3(18.0, -40.0, 26.0), .aim = Vec3(0.0, 0.0, -1.0), .up = Vec3::UnitZ(), .view_angle_deg = 32.0 };
    scene.orientation_marker = false;
    return scene;
}

void write_spring_pictures(const std::filesystem::path& folder, const Job& job)
{
    ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
    ui::ChartPicture chart { .x_title = {},
        .y_title = {},
        .panels = { force_displacement(), relaxation(), creep() },
        .columns = 3,
        .panel_width = 620,
        .panel_height = 480,
        .logarithmic_x = false,
        .logarithmic_y = false };
    ui::write_png(folder / "tissue_curves.png", renderer.render(chart));
    write_file_atomically(folder / "tissue_curves.csv", csv_of(chart));
    const std::vector<ui::Scene> scenes = sheet_states();
    constexpr int kColumns = 4, kWidth = 480, kHeight = 360;
    const int rows = (static_cast<int>(scenes.size()) + kColumns - 1) / kColumns;
    ui::Picture picture { .width = kColumns * kWidth, .height = rows * kHeight, .viewports = {} };
    for (int i = 0; i < static_cast<int>(scenes.size()); ++i) {
        const int column = i % kColumns, row = rows - 1 - i / kColumns;
        picture.viewports.push_back({ .left = static_cast<double>(column) / kColumns,
            .bottom = static_cast<double>(row) / rows,
            .right = static_cast<double>(column + 1) / kColumns,
            .top = static_cast<double>(row + 1) / rows,
            .scene = scenes[static_cast<std::size_t>(i)] });
    }
    ui::write_png(folder / "sheet.png", renderer.render(picture));
}

} // namespace retractor::benchmarks
