#include "ui/cli/palpate_command.h"

#include "haptics/csv_field.h"
#include "haptics/replay.h"
#include "haptics/servo.h"
#include "haptics/simulated_hand.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "ui/cli/arguments.h"
#include "ui/cli/command.h"
#include "ui/scene/render.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>

namespace retractor::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr double kStep = 1e-3; ///< s
    constexpr double kClear = 8.0; ///< mm above the surface where a hand starts and ends
    constexpr double kApproach = 1.0, kRelease = 0.5; ///< s
    constexpr int kFollowEvery = 33; ///< ticks: a display's 30 Hz

    struct PalpateOptions {
        std::string scene, press, pinch, out = "palpation.csv", plot;
        std::vector<std::string> devices { "fixed" };
        TissueChoice tissue;
        double depth_mm = 2.0, seconds = 4.0;
    };

    /// Device up is out of the body.
    Mat3 scene_from_device(const Vec3& outward)
    {
        return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitY(), outward).toRotationMatrix();
    }

    HandPath path_of(double depth, double seconds, double radius)
    {
        const auto up = [](double y) { return Vec3(0.0, y, 0.0); };
        return HandPath({ { 0.0, up(radius + kClear), 0 }, { kApproach, up(radius - depth), 0 },
            { kApproach + seconds, up(radius - depth), 0 },
            { kApproach + seconds + kRelease, up(radius + kClear), 0 } });
    }

    /// The path as a recording: a finger that goes its way whatever pushes back.
    MotionRecording as_recording(const HandPath& path)
    {
        MotionRecording recording;
        recording.devices.push_back({ "fixed", "", "" });
        const auto ticks = static_cast<std::size_t>(std::ceil(path.end_s() / kStep)) + 1;
        for (std::size_t i = 0; i < ticks; ++i) {
            const double t = static_cast<double>(i) * kStep;
            MotionSample sample;
            sample.position = path.position(t);
            sample.velocity = (path.position(t + kStep) - path.position(t - kStep)) / (2.0 * kStep);
            recording.times_s.push_back(t);
            recording.samples.push_back(sample);
        }
        return recording;
    }

    std::unique_ptr<Device> make_device(const std::string& name, const HandPath& path)
    {
        if (name == "fixed")
            return std::make_unique<ReplayDevice>(as_recording(path), 0);
        if (name == "simulated" || name == "simulated:firm")
            return std::make_unique<SimulatedHand>(
                SimulatedHandOptions { .hand = name == "simulated" ? relaxed_grip() : firm_grip(), .path = path });
        if (name.rfind("replay:", 0) == 0)
            return std::make_unique<ReplayDevice>(read_motion(name.substr(7)), 0);
        throw InputError(
            "there is no device \"" + name + "\"; there is fixed, simulated, simulated:firm, replay:FILE", "--device");
    }

    struct Press {
        std::string name;
        std::vector<TouchSite> sites; ///< one per finger
    };

    std::vector<Press> presses(const PalpationScene& scene, const PalpateOptions& options)
    {
        std::vector<Press> list;
        if (!options.pinch.empty())
            for (const std::string& name : split(options.pinch, ','))
                list.push_back({ name + ", pinched", { scene.site(name), scene.site(name + "-opposite") } });
        else if (!options.press.empty())
            for (const std::string& name : split(options.press, ','))
                list.push_back({ name, { scene.site(name) } });
        else
            for (const TouchSite& site : scene.sites)
                if (!site.name.ends_with("-opposite"))
                    list.push_back({ site.name, { site } });
        if (list.empty())
            throw InputError("has no site to press", scene.name);
        return list;
    }

    double pressure_at(const TissueResponse& tissue, double time)
    {
        const auto* condensed = dynamic_cast<const CondensedTissue*>(&tissue);
        return condensed == nullptr ? 0.0 : condensed->pulse().at(time) / kMPaPerMmHg;
    }

    long late_ticks(const TissueResponse& tissue)
    {
        const auto* condensed = dynamic_cast<const CondensedTissue*>(&tissue);
        return condensed == nullptr ? 0 : condensed->late_ticks();
    }

    void log_tick(PressLog& log, const TissueResponse& tissue, const ServoState& state)
    {
        for (std::size_t f = 0; f < log.fingers.size(); ++f) {
            FingerLog& finger = log.fingers[f];
            const FingerContact& contact = state.contacts[f];
            finger.time.push_back(state.time_s);
            finger.pressure_mmHg.push_back(pressure_at(tissue, state.time_s));
            finger.position.push_back(state.fingers[f].position);
            finger.depth.push_back(contact.depth);
            finger.stiffness.push_back(contact.stiffness);
            finger.force.push_back(contact.force);
            finger.hand_force.push_back(state.forces[f].norm());
        }
    }

    PressLog run_press(const Press& press, TissueResponse& tissue, const PalpateOptions& options, const Job& job,
        double done, double share)
    {
        const HandPath path = path_of(options.depth_mm, options.seconds, Fingertip {}.radius);
        std::vector<std::unique_ptr<Device>> devices;
        std::vector<ServoDevice> mapped;
        PressLog log;
        log.name = press.name;
        for (std::size_t f = 0; f < press.sites.size(); ++f) {
            devices.push_back(make_device(options.devices[std::min(f, options.devices.size() - 1)], path));
            mapped.push_back({ devices.back().get(),
                { .scene_centre = press.sites[f].point,
                    .scene_from_device = scene_from_device(press.sites[f].outward) } });
            log.fingers.push_back({ press.sites[f].name, {}, {}, {}, {}, {}, {}, {} });
        }
        Servo servo(mapped, tissue);
        const auto ticks = static_cast<std::uint64_t>(std::llround(path.end_s() / kStep));
        double deepest = -1.0;
        const long late_before = late_ticks(tissue);
        for (std::uint64_t tick = 0; tick < ticks && !job.cancelled(); ++tick) {
            run_ticks(servo, 1, kStep, tick);
            const ServoState& state = servo.latest();
            log_tick(log, tissue, state);
            if (state.fault.kind != FaultKind::none)
                throw SolverError("the servo let go: " + describe(state.fault), press.name);
            if (tick % kFollowEvery != 0)
                continue;
            Points deformed;
            tissue.follow(deformed);
            double depth = 0.0;
            for (std::size_t f = 0; f < log.fingers.size(); ++f)
                depth += state.contacts[f].depth;
            if (depth > deepest) {
                deepest = depth;
                log.deformed = std::move(deformed);
            }
            job.report("palpate", done + share * static_cast<double>(tick) / static_cast<double>(ticks));
        }
        log.ticks = static_cast<long>(ticks);
        log.late_ticks = late_ticks(tissue) - late_before;
        return log;
    }

    std::string csv_of(const std::vector<PressLog>& logs)
    {
        std::string text = "press,finger,site,time_s,pressure_mmHg,x_mm,y_mm,z_mm,depth_mm,stiffness_N_per_mm,"
                           "force_x_N,force_y_N,force_z_N,force_N,hand_force_N\n";
        std::array<char, 512> line {};
        for (const PressLog& log : logs)
            for (std::size_t f = 0; f < log.fingers.size(); ++f) {
                const FingerLog& finger = log.fingers[f];
                const std::string who = csv_field(log.name) + "," + std::to_string(f) + "," + csv_field(finger.site);
                for (std::size_t i = 0; i < finger.time.size(); ++i) {
                    const Vec3 &p = finger.position[i], &force = finger.force[i];
                    std::snprintf(line.data(), line.size(),
                        ",%.6f,%.4f,%.5f,%.5f,%.5f,%.5f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", finger.time[i],
                        finger.pressure_mmHg[i], p.x(), p.y(), p.z(), finger.depth[i], finger.stiffness[i], force.x(),
                        force.y(), force.z(), force.norm(), finger.hand_force[i]);
                    text += who + line.data();
                }
            }
        return text;
    }

    struct Held {
        double low = std::numeric_limits<double>::infinity(), high = 0.0, depth = 0.0;
    };

    /// While the finger stays down: from half a second after it got there, so that a hand has settled.
    Held while_held(const FingerLog& finger, double seconds)
    {
        constexpr double kSettle = 0.5;
        Held held;
        for (std::size_t i = 0; i < finger.time.size(); ++i) {
            if (finger.time[i] < kApproach + std::min(kSettle, 0.5 * seconds) || finger.time[i] > kApproach + seconds)
                continue;
            const double force = finger.force[i].norm();
            held.low = std::min(held.low, force);
            held.high = std::max(held.high, force);
            held.depth = std::max(held.depth, finger.depth[i]);
        }
        return held;
    }

    void write_chart(
        const fs::path& file, const std::vector<PressLog>& logs, const TissueChoice& choice, const Job& job)
    {
        ChartPicture picture { .x_title = "time, s", .y_title = "", .panels = {}, .columns = 1 };
        picture.logarithmic_x = picture.logarithmic_y = false;
        picture.panel_width = 900;
        picture.panel_height = 300;
        ChartPanel pressure { "blood pressure", {}, {}, "mmHg" }, depth { "depth of the fingertip", {}, {}, "mm" };
        std::array<char, 64> gain {};
        std::snprintf(gain.data(), gain.size(), " (force gain %.3g)", choice.force_gain);
        ChartPanel force { std::string("force on the finger") + (choice.force_gain == 1.0 ? "" : gain.data()), {}, {},
            "N" };
        const FingerLog& first = logs.front().fingers.front();
        if (*std::max_element(first.pressure_mmHg.begin(), first.pressure_mmHg.end()) > 0.0)
            pressure.series.push_back({ "pressure", first.time, first.pressure_mmHg, false });
        for (const PressLog& log : logs)
            for (const FingerLog& finger : log.fingers) {
                std::vector<double> newtons;
                for (const Vec3& f : finger.force)
                    newtons.push_back(f.norm());
                force.series.push_back({ finger.site, finger.time, newtons, false });
                depth.series.push_back({ finger.site, finger.time, finger.depth, false });
            }
        if (!pressure.series.empty())
            picture.panels.push_back(pressure);
        picture.panels.push_back(force);
        picture.panels.push_back(depth);
        OffscreenRenderer renderer(make_offscreen_context(), job);
        write_png(file, renderer.render(picture));
    }

    std::shared_ptr<TriMesh> ball(const Vec3& centre, double radius)
    {
        constexpr int kRound = 24, kHigh = 12;
        auto mesh = std::make_shared<TriMesh>();
        mesh->vertices.resize((kHigh + 1) * kRound, 3);
        const auto id = [](int i, int j) { return static_cast<VertexId>(j * kRound + i % kRound); };
        for (int j = 0; j <= kHigh; ++j)
            for (int i = 0; i < kRound; ++i) {
                const double a = 2.0 * std::numbers::pi * i / kRound, b = std::numbers::pi * j / kHigh;
                mesh->vertices.row(id(i, j))
                    = (centre + radius * Vec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b)))
                          .transpose();
            }
        for (int j = 0; j < kHigh; ++j)
            for (int i = 0; i < kRound; ++i) {
                if (j > 0)
                    mesh->triangles.push_back({ id(i, j), id(i + 1, j), id(i + 1, j + 1) });
                if (j + 1 < kHigh)
                    mesh->triangles.push_back({ id(i, j), id(i + 1, j + 1), id(i, j + 1) });
            }
        return mesh;
    }

    Scene view_of(const PressLog& log, const TissueResponse& tissue, const PalpateOptions& options, const Press& press)
    {
        Scene scene;
        scene.title = log.name;
        std::array<char, 128> note {};
        std::snprintf(
            note.data(), note.size(), "depth %.1f mm, force gain %.3g", options.depth_mm, options.tissue.force_gain);
        scene.notes.push_back(note.data());
        auto surface = std::make_shared<TriMesh>(tissue.surface());
        surface->vertices = log.deformed;
        SurfaceItem item { .name = "tissue", .mesh = surface };
        item.look = { .color = { 0.82, 0.36, 0.32 }, .finish = Finish::wet };
        for (const Label label : surface->labels)
            item.look_of_label[label] = { .color = label == 2 ? Color { 0.93, 0.82, 0.50 } : Color { 0.82, 0.36, 0.32 },
                .finish = Finish::wet };
        item.show_edges = true;
        item.smooth = false;
        scene.surfaces.push_back(item);
        for (std::size_t f = 0; f < press.sites.size(); ++f) {
            const TouchSite& site = press.sites[f];
            const double radius = Fingertip {}.radius;
            scene.surfaces.push_back({ .name = "finger",
                .mesh = ball(site.point + (radius - options.depth_mm) * site.outward, radius),
                .look = { .color = { 0.85, 0.70, 0.60 }, .finish = Finish::skin } });
        }
        const Vec3 out = press.sites[0].outward;
        Vec3 aside = out.cross(Vec3::UnitZ());
        if (aside.norm() < 0.3)
            aside = out.cross(Vec3::UnitX());
        const Vec3 look = -(0.7 * aside.normalized() + 0.7 * out + 0.25 * Vec3::UnitZ()).normalized();
        const Vec3 up = std::abs(look.z()) > 0.9 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
        scene.camera = camera_for_box(*scene_bounds(scene), look, up);
        return scene;
    }

    void write_view(const fs::path& file, const std::vector<PressLog>& logs, const std::vector<Press>& list,
        const TissueResponse& tissue, const PalpateOptions& options, const Job& job)
    {
        const auto count = static_cast<double>(logs.size());
        Picture picture { .width = static_cast<int>(800 * logs.size()), .height = 800, .viewports = {} };
        for (std::size_t i = 0; i < logs.size(); ++i)
            picture.viewports.push_back({ .left = static_cast<double>(i) / count,
                .bottom = 0.0,
                .right = static_cast<double>(i + 1) / count,
                .top = 1.0,
                .scene = view_of(logs[i], tissue, options, list[i]) });
        OffscreenRenderer renderer(make_offscreen_context(), job);
        write_png(file, renderer.render(picture));
    }

    Json document_of(const PressLog& log, const PalpateOptions& options, std::string& text)
    {
        Json fingers = Json::array();
        for (const FingerLog& finger : log.fingers) {
            const Held held = while_held(finger, options.seconds);
            fingers.push_back({ { "site", finger.site }, { "force_low_N", held.low }, { "force_high_N", held.high },
                { "pulse_N", held.high - held.low }, { "depth_high_mm", held.depth } });
            std::array<char, 200> line {};
            std::snprintf(line.data(), line.size(), "%-22s force %.3f to %.3f N, pulse %.3f N\n", finger.site.c_str(),
                held.low, held.high, held.high - held.low);
            text += line.data();
        }
        return { { "press", log.name }, { "fingers", fingers }, { "ticks", log.ticks },
            { "late_ticks", log.late_ticks } };
    }

    Outcome palpate(PalpateOptions options, const Job& job)
    {
        job.report("read scene", 0.0);
        const PalpationScene scene = read_palpation_scene(options.scene);
        const std::vector<Press> list = presses(scene, options);
        options.tissue.fingers = list.front().sites.size();
        const auto tissue = make_tissue(scene, options.tissue, job);
        Outcome outcome;
        Json documents = Json::array();
        std::vector<PressLog> logs;
        for (std::size_t i = 0; i < list.size() && !job.cancelled(); ++i) {
            const double share = 1.0 / static_cast<double>(list.size());
            logs.push_back(run_press(list[i], *tissue, options, job, share * static_cast<double>(i), share));
            documents.push_back(document_of(logs.back(), options, outcome.text));
        }
        if (job.cancelled())
            throw SolverError("cancelled", scene.name);
        const fs::path out = options.out;
        fs::path plot = options.plot, view = out;
        if (plot.empty())
            plot = fs::path(out).replace_extension(".png");
        view.replace_filename(out.stem().string() + "-view.png");
        write_file_atomically(out, csv_of(logs));
        write_chart(plot, logs, options.tissue, job);
        write_view(view, logs, list, *tissue, options, job);
        outcome.document = { { "scene", scene.name }, { "model", std::string(tissue->name()) },
            { "vertices", tissue->surface().vertices.rows() }, { "force_gain", options.tissue.force_gain },
            { "depth_mm", options.depth_mm }, { "presses", documents }, { "csv", out.string() },
            { "plot", plot.string() }, { "view", view.string() } };
        if (options.tissue.model == "fem") {
            outcome.document["element"] = options.tissue.element;
            outcome.document["fingertip"] = options.tissue.fingertip;
            outcome.document["pressure"] = pulse_of(scene, options.tissue).source();
        }
        if (options.tissue.force_gain != 1.0)
            outcome.text
                += "force gain on: all forces are multiplied by " + std::to_string(options.tissue.force_gain) + "\n";
        outcome.text += "forces: " + out.string() + "\nplot:   " + plot.string() + "\nview:   " + view.string() + "\n";
        return outcome;
    }

} // namespace

void add_palpate_command(Commands& commands)
{
    auto options = std::make_shared<PalpateOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "palpate", "Press on tissue with simulated or recorded hands: forces over time (CSV), a plot, a view");
    command->footer("Example: retractor palpate aorta/aorta.json --press normal,sclerotic --out forces.csv\n"
                    "         retractor palpate aorta/aorta.json --pinch normal --device simulated --out pinch.csv");
    command->add_option("scene", options->scene, "Scene file, e.g. from retractor phantom aorta")->required();
    CLI::Option* press = command->add_option(
        "--press", options->press, "Sites to press, one after the other: NAME,NAME (default: all but -opposite ones)");
    command->add_option("--pinch", options->pinch, "Sites to pinch with two fingers, the second at NAME-opposite")
        ->excludes(press);
    command
        ->add_option("--device", options->devices,
            "fixed (keeps its path whatever pushes back), simulated (a relaxed hand on a Touch), simulated:firm, "
            "replay:FILE; twice for two fingers")
        ->capture_default_str();
    command->add_option("--model", options->tissue.model, "Which tissue answers")
        ->check(CLI::IsMember(tissue_models()))
        ->capture_default_str();
    command->add_option("--element", options->tissue.element, "fem: p1 (the source's, too stiff), locking-free or p2")
        ->check(CLI::IsMember({ "p1", "locking-free", "p2" }))
        ->capture_default_str();
    command
        ->add_option("--fingertip", options->tissue.fingertip,
            "fem: pad (soft, pushes), sphere (rigid, pushes) or held (the source's equation: its rim may pull)")
        ->check(CLI::IsMember({ "pad", "sphere", "held" }))
        ->capture_default_str();
    command->add_option("--depth", options->depth_mm, "How far the fingertip presses in, mm")
        ->check(CLI::Range(0.01, 10.0))
        ->capture_default_str();
    command->add_option("--seconds", options->seconds, "How long it stays down")
        ->check(CLI::Range(0.1, 600.0))
        ->capture_default_str();
    command->add_option("--gain", options->tissue.force_gain, "Multiplies every force; said in the plot")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    command->add_option("--pressure", options->tissue.pressure_csv, "One beat as CSV: time_s,pressure_mmHg");
    command->add_option("--heart-rate", options->tissue.heart_rate_per_min, "Beats per minute (default: the scene's)")
        ->check(CLI::Range(20.0, 300.0));
    command->add_option("--out", options->out, "Forces, CSV")->capture_default_str();
    command->add_option("--plot", options->plot, "Plot, PNG (default: beside the CSV)");
    command->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return palpate(*options, job); }; });
}

} // namespace retractor::cli
