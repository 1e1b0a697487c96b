#include "ui/cli/commands.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "haptics/hand/hand_file.h"
#include "haptics/recording/motion_file.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/palpation/palpate_pictures.h"
#include "ui/cli/palpation/palpate_run.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct PalpateOptions {
        std::string scene, structure, press, pinch, out = "palpation.csv", plot, record, hand;
        std::vector<std::string> devices { "fixed" };
        planner::TissueChoice tissue;
        PressPlan plan;
    };

    /// The presses of an option's text: "a,b+c" means a, then b and c together.
    std::vector<Press> presses(const datasets::PalpationScene& scene, const PalpateOptions& options)
    {
        std::vector<Press> list;
        if (!options.pinch.empty())
            for (const std::string& name : split(options.pinch, ','))
                list.push_back({ name + ", pinched", { scene.site(name), scene.site(name + "-opposite") } });
        else if (!options.press.empty())
            for (const std::string& names : split(options.press, ',')) {
                list.push_back({ names, {} });
                for (const std::string& name : split(names, '+'))
                    list.back().sites.push_back(scene.site(name));
                if (list.back().sites.empty())
                    throw InputError("a press names no site", "--press");
            }
        else
            for (const datasets::TouchSite& site : scene.sites)
                if (!site.name.ends_with("-opposite"))
                    list.push_back({ site.name, { site } });
        if (list.empty())
            throw InputError("has no site to press", scene.name);
        for (const Press& press : list)
            if (press.sites.size() != list.front().sites.size())
                throw InputError("all presses must use the same number of fingers", "--press");
        return list;
    }

    struct Held {
        double low = std::numeric_limits<double>::infinity(), high = 0.0, depth = 0.0;
    };

    /// Range of the force and largest depth while the finger is meant to be down in the first press. The interval
    /// begins half a second after the finger arrives, so that a hand has settled.
    /// @param all use the whole motion, when the intended time of the press is unknown
    Held while_held(const FingerLog& finger, const PressPlan& plan, bool all)
    {
        constexpr double kSettle = 0.5;
        const auto [from, to] = held_between(plan, 0);
        Held held;
        for (std::size_t i = 0; i < finger.time.size(); ++i) {
            const double t = finger.time[i];
            if (!all && (t < from + std::min(kSettle, 0.5 * plan.seconds) || t > to))
                continue;
            const double force = finger.force[i].norm();
            held.low = std::min(held.low, force);
            held.high = std::max(held.high, force);
            held.depth = std::max(held.depth, finger.depth[i]);
        }
        return held;
    }

    Json document_of(const PressLog& log, const PressPlan& plan, bool all, std::string& text)
    {
        Json fingers = Json::array();
        for (const FingerLog& finger : log.fingers) {
            const Held held = while_held(finger, plan, all);
            fingers.push_back({ { "site", finger.site }, { "force_low_N", held.low }, { "force_high_N", held.high },
                { "pulse_N", held.high - held.low }, { "depth_high_mm", held.depth } });
            if (all) // the intended time of the press is unknown
                text += formatted(
                    "%-22s force up to %.3f N, depth up to %.2f mm\n", finger.site.c_str(), held.high, held.depth);
            else
                text += formatted("%-22s force %.3f to %.3f N, pulse %.3f N\n", finger.site.c_str(), held.low,
                    held.high, held.high - held.low);
        }
        Json document { { "press", log.name }, { "fingers", fingers }, { "ticks", log.ticks },
            { "late_ticks", log.late_ticks }, { "faults_passed", log.faults } };
        if (!log.device_problems.empty())
            document["device_problems"] = log.device_problems;
        for (const std::string& problem : log.device_problems)
            text += "a device reported: " + problem + "\n";
        if (!log.fault.empty()) {
            document["fault"] = log.fault;
            text += "the forces were switched off: " + log.fault + "\n";
        }
        return document;
    }

    /// Largest displacement of each organ's surface at the deepest press.
    Json organs_moved(const PressLog& log, const datasets::PalpationScene& scene, const haptics::TissueResponse& tissue,
        std::string& text)
    {
        Json moved = Json::array();
        const TriMesh& surface = tissue.surface();
        for (std::size_t o = 0; o < scene.organs.size() && !surface.labels.empty(); ++o) {
            const Label label = planner::surface_label(scene, o, tissue);
            double most = 0.0;
            for (std::size_t t = 0; t < surface.triangles.size(); ++t)
                for (const VertexId v : surface.triangles[t])
                    if (surface.labels[t] == label)
                        most = std::max(most, (log.deformed.row(v) - surface.vertices.row(v)).norm());
            moved.push_back({ { "organ", scene.organs[o].name }, { "moved_mm", most } });
            text += formatted("%-22s moved by up to %.2f mm\n", scene.organs[o].name.c_str(), most);
        }
        return moved;
    }

    bool is_live(const PalpateOptions& options)
    {
        return std::any_of(options.devices.begin(), options.devices.end(), is_live_hand);
    }

    std::string view_note(const PalpateOptions& options)
    {
        return (is_live(options) ? std::string() : formatted("depth %.1f mm, ", options.plan.depth_mm))
            + formatted("force gain %.3g", options.tissue.force_gain);
    }

    void write_files(const PalpateOptions& options, const datasets::PalpationScene& scene,
        const std::vector<Press>& list, const std::vector<PressLog>& logs, const haptics::TissueResponse& tissue,
        const std::array<haptics::HandModel, 2>* hands, Outcome& outcome, const Job& job)
    {
        const fs::path out = options.out;
        fs::path plot = options.plot, view = out;
        if (plot.empty())
            plot = fs::path(out).replace_extension(".png");
        view.replace_filename(out.stem().string() + "-view.png");
        write_file_atomically(out, palpation_csv(logs));
        write_palpation_chart(plot, logs, options.tissue.force_gain, job);
        write_palpation_view(view, logs, list, scene, tissue, view_note(options), hands, job);
        if (!options.record.empty())
            haptics::write_motion(options.record, logs.front().motion);
        outcome.document["csv"] = out.string();
        outcome.document["plot"] = plot.string();
        outcome.document["view"] = view.string();
        outcome.text += "forces: " + out.string() + "\nplot:   " + plot.string() + "\nview:   " + view.string() + "\n";
    }

    void describe_tissue(const PalpateOptions& options, const datasets::PalpationScene& scene,
        const planner::ChosenTissue& tissue, const haptics::PulsePressure* pressure, Outcome& outcome)
    {
        outcome.document = { { "scene", scene.name }, { "model", std::string(tissue.response->name()) },
            { "vertices", tissue.response->surface().vertices.rows() }, { "force_gain", options.tissue.force_gain },
            { "depth_mm", options.plan.depth_mm }, { "notes", tissue.notes } };
        if (options.tissue.model == "fem") {
            outcome.document["element"] = options.tissue.element;
            outcome.document["fingertip"] = options.tissue.fingertip;
        }
        if (pressure != nullptr)
            outcome.document["pressure"] = pressure->source();
        for (const std::string& note : tissue.notes)
            outcome.text += note + "\n";
        if (options.tissue.force_gain != 1.0)
            outcome.text
                += "force gain on: all forces are multiplied by " + std::to_string(options.tissue.force_gain) + "\n";
    }

    bool is_case(const std::string& path)
    {
        try {
            static_cast<void>(planner::read_case(path, { .verify_checksums = false }));
            return true;
        } catch (const Error&) {
            return false;
        }
    }

    /// Reads the given scene, or makes one from a case's structure. Adds notes to `notes`.
    datasets::PalpationScene scene_of(const PalpateOptions& options, std::vector<std::string>& notes, const Job& job)
    {
        if (datasets::is_palpation_scene(options.scene)) {
            if (!options.structure.empty())
                throw InputError("needs a case, but this is a palpation scene", "--structure");
            return datasets::read_palpation_scene(options.scene);
        }
        if (options.structure.empty() && !is_case(options.scene))
            return datasets::read_palpation_scene(options.scene); // fails with the error in the file
        planner::Patient patient(open_case(options.scene), job);
        if (options.structure.empty())
            throw InputError("is a case: name the structure to palpate with --structure; there are "
                    + planner::names_of(patient.planned_case().label_table),
                options.scene);
        planner::PalpableRequest request;
        request.structure = split(options.structure, '+');
        planner::Palpable made = planner::make_palpable(patient, request, job);
        notes = std::move(made.notes);
        return std::move(made.scene);
    }

    using Hands = std::array<haptics::HandModel, 2>; // right and left

    std::optional<Hands> hands_of(const PalpateOptions& options)
    {
        if (options.hand.empty())
            return {};
        const auto hand = [&](bool left) {
            return options.hand == "built-in" ? haptics::make_hand(left) : haptics::read_hand(options.hand, left);
        };
        return Hands { hand(false), hand(true) };
    }

    /// Refuses wrong options before the long work. Real devices are opened later, when everything is ready.
    void refuse_early(const PalpateOptions& options)
    {
        std::vector<std::string> here;
        for (const std::string& name : options.devices)
            if (!is_live_hand(name))
                here.push_back(name);
        static_cast<void>(HandDevices(here, press_path(options.plan)));
        for (const fs::path& file : { fs::path(options.out), fs::path(options.plot), fs::path(options.record) })
            if (file.has_parent_path() && !fs::is_directory(file.parent_path()))
                throw IoError("the folder of this file does not exist", file.string());
    }

    Outcome palpate(PalpateOptions options, const Job& job)
    {
        const std::optional<Hands> hands = hands_of(options);
        refuse_early(options);
        job.report("read scene", 0.0);
        std::vector<std::string> notes;
        const datasets::PalpationScene scene = scene_of(options, notes, job);
        const std::vector<Press> list = presses(scene, options);
        if (!options.record.empty() && list.size() > 1)
            throw InputError("only one press can be recorded: name the press with --press", "--record");
        options.tissue.fingers = list.front().sites.size();
        // Checks the devices before the tissue is made.
        static_cast<void>(one_per_finger(options.devices, list.front()));
        options.tissue.radius_mm = options.plan.radius_mm;
        options.tissue.depth_mm = options.plan.depth_mm;
        planner::ChosenTissue tissue = make_tissue(scene, options.tissue, job);
        tissue.notes.insert(tissue.notes.begin(), notes.begin(), notes.end());
        std::unique_ptr<haptics::PulsePressure> pressure;
        if (datasets::has_inner_wall(scene.body))
            pressure = std::make_unique<haptics::PulsePressure>(planner::pulse_of(scene, options.tissue));
        Outcome outcome;
        describe_tissue(options, scene, tissue, pressure.get(), outcome);
        const double servo_gain = options.tissue.model == "fem" ? 1.0 : options.tissue.force_gain;
        const bool free = is_live(options)
            || std::any_of(options.devices.begin(), options.devices.end(),
                [](const std::string& name) { return name.find("replay:") != std::string::npos; });
        Json documents = Json::array();
        std::vector<PressLog> logs;
        for (std::size_t i = 0; i < list.size() && !job.cancelled(); ++i) {
            logs.push_back(
                run_press(list[i], *tissue.response, options.devices, options.plan, pressure.get(), servo_gain, job));
            documents.push_back(document_of(logs.back(), options.plan, free, outcome.text));
            if (!scene.organs.empty())
                documents.back()["organs"] = organs_moved(logs.back(), scene, *tissue.response, outcome.text);
            outcome.exit_code = logs.back().fault.empty() ? outcome.exit_code : 1;
        }
        // A cancelled run with a live device keeps its results, because a person has felt the tissue.
        if (job.cancelled() && !is_live(options))
            throw SolverError("cancelled", scene.name);
        outcome.document["presses"] = documents;
        write_files(options, scene, list, logs, *tissue.response, hands ? &*hands : nullptr, outcome, job);
        return outcome;
    }

    void add_tissue_options(CLI::App* command, PalpateOptions& options)
    {
        planner::TissueChoice& tissue = options.tissue;
        command
            ->add_option("--model", tissue.model,
                "Tissue model: fem (condensed finite elements), springs (along the edges of the mesh) or spheres "
                "(solid organs)")
            ->check(CLI::IsMember(planner::tissue_models()))
            ->capture_default_str();
        command
            ->add_option("--element", tissue.element,
                "Finite element of fem: p1 (four nodes, too stiff), locking-free or p2 (ten nodes)")
            ->check(CLI::IsMember({ "p1", "locking-free", "p2" }))
            ->capture_default_str();
        command
            ->add_option("--fingertip", tissue.fingertip,
                "Fingertip on fem: pad (soft, only pushes), sphere (rigid, only pushes) or held (its rim may pull, as "
                "in Nakao et al. 2006)")
            ->check(CLI::IsMember({ "pad", "sphere", "held" }))
            ->capture_default_str();
        command
            ->add_option("--calibration", tissue.calibration,
                "Factor of the stiffness of springs (default: measured against ten-node elements)")
            ->check(in_range(1e-3, 1e3));
        command->add_option("--spheres", tissue.spheres, "Number of spheres that fill the (first) organ")
            ->check(CLI::Range(10, 100000))
            ->capture_default_str();
        command->add_option("--gain", tissue.force_gain, "Factor of every force; the plot states the factor")
            ->check(in_range(0.01, 100.0))
            ->capture_default_str();
        command->add_option(
            "--pressure", tissue.pressure_csv, "CSV file with the blood pressure of one beat: time_s,pressure_mmHg");
        command
            ->add_option("--heart-rate", tissue.heart_rate_per_min,
                "Heart rate, beats per minute (default: the rate of the scene)")
            ->check(in_range(20.0, 300.0));
    }

    void add_motion_options(CLI::App* command, PalpateOptions& options)
    {
        command
            ->add_option("--device", options.devices,
                std::string(kDeviceHelp) + "; give one device for all fingers, or one device per finger")
            ->capture_default_str();
        command->add_option("--depth", options.plan.depth_mm, "Depth to which the fingertip presses, mm")
            ->check(in_range(0.01, 40.0))
            ->capture_default_str();
        command->add_option("--radius", options.plan.radius_mm, "Radius of a fingertip, mm")
            ->check(in_range(1.0, 20.0))
            ->capture_default_str();
        command->add_option("--seconds", options.plan.seconds, "Time that the fingertip stays down, s")
            ->check(in_range(0.1, 3600.0))
            ->capture_default_str();
        command->add_option("--times", options.plan.times, "Number of times that the fingertip comes down")
            ->check(CLI::Range(1, 100))
            ->capture_default_str();
    }

} // namespace

void add_palpate_command(Commands& commands)
{
    auto options = std::make_shared<PalpateOptions>();
    CLI::App* command = commands.app.add_subcommand("palpate",
        "Press on tissue with simulated, recorded or real hands; write the forces over time (CSV), a plot and a view");
    command->footer(
        "Example: retractor palpate aorta/aorta.json --press normal,sclerotic --out forces.csv\n"
        "         retractor palpate aorta/aorta.json --pinch normal --device simulated --out pinch.csv\n"
        "         retractor palpate liver/liver.json --model spheres --press right-lobe --times 2 --radius 8 "
        "--depth 12 --seconds 0.5\n"
        "         retractor palpate aorta/aorta.json --press normal --device touch --seconds 60");
    command
        ->add_option("scene", options->scene,
            "Scene file (retractor phantom aorta, retractor palpable), or a case with --structure")
        ->required();
    command->add_option("--structure", options->structure,
        "Label of the case to palpate, or NAME+NAME (retractor palpable has more options)");
    CLI::Option* press = command->add_option("--press", options->press,
        "Sites to press: NAME,NAME one after the other, NAME+NAME together (default: all sites except those that end "
        "in -opposite)");
    command
        ->add_option(
            "--pinch", options->pinch, "Sites to pinch with two fingers; the second finger presses at NAME-opposite")
        ->excludes(press);
    add_motion_options(command, *options);
    add_tissue_options(command, *options);
    command->add_option("--out", options->out, "CSV file for the forces")->capture_default_str();
    command->add_option("--plot", options->plot, "PNG file for the plot (default: beside the CSV file)");
    command->add_option("--record", options->record,
        "File for the motion of the devices, which --device replay:FILE can play (binary, or CSV when the name ends in "
        ".csv)");
    command->add_option("--hand", options->hand,
        "Hand at the fingertips in the picture: built-in, or an OBJ file (see docs/user/palpation.md)");
    command
        ->add_option("--replay-at", options->plan.replay_at,
            "Place where replay:FILE is played: recorded (where the recording was made) or site (at the pressed site); "
            "default: recorded for a mouse, site for other devices")
        ->transform(CLI::Transformer(
            std::map<std::string, ReplayAt> { { "recorded", ReplayAt::recorded }, { "site", ReplayAt::site } }));
    commands.on(command, [options](const Job& job) { return palpate(*options, job); });
}

} // namespace retractor::ui::cli
