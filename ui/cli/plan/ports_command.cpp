#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/staged_results.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/patient.h"
#include "planner/ports/port_search.h"
#include "ui/plan_scene/case_picture.h"
#include "ui/plan_scene/port_picture.h"
#include "ui/scene/vtk/offscreen.h"
#include "ui/scene/vtk/render.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>

namespace retractor::ui::cli {

namespace {

    constexpr std::size_t kMostProposals = 20;

    struct PortsOptions {
        std::string case_file, target, side, spaces, out;
        std::vector<std::string> retracted;
        planner::Optics optics {};
        planner::PortSizes sizes {};
        int count = 3;
    };

    planner::TargetSpec target_of(const PortsOptions& options, planner::Patient& patient)
    {
        if (!options.target.empty()) {
            planner::TargetSpec target = parse_target(options.target);
            if (target.is_sphere())
                return target;
            const mesh::LabelInfo* info = mesh::find_label(patient.planned_case().label_table, target.label);
            if (info == nullptr || mesh::is_wall(*info))
                throw InputError(info == nullptr ? "there is no label \"" + target.label + "\""
                                                 : "\"" + target.label + "\" is a part of the wall",
                    "--target " + options.target);
            return target;
        }
        if (const auto target = default_target(patient))
            return *target;
        throw InputError("the case has no label of role target: name one", "--target");
    }

    /// The side that is asked for, or that on which the target lies.
    bool is_left(const PortsOptions& options, const planner::TargetSpec& target, planner::Patient& patient)
    {
        if (!options.side.empty())
            return options.side == "left";
        const planner::AnatomicalFrame frame = patient.frame();
        return (patient.target(target)->vertices.colwise().mean().transpose() - frame.origin).dot(frame.left) > 0.0;
    }

    void check_in_body(const planner::TargetSpec& target, planner::Patient& patient)
    {
        if (target.is_sphere() && mesh::label_at(*patient.labels(), target.centre) == 0)
            throw InputError("the sphere's centre lies outside the body", "--target");
    }

    Json point(const Vec3& at) { return { at.x(), at.y(), at.z() }; }

    Json port_document(const planner::Port& port)
    {
        return { { "place", planner::place_in_words(port) }, { "space", port.space },
            { "side", port.left ? "left" : "right" }, { "angle_deg", port.angle_deg }, { "skin_mm", point(port.skin) },
            { "wall_mm", port.wall_mm } };
    }

    Json plan_document(const planner::PortPlan& plan)
    {
        Json document { { "points", plan.points }, { "seen", plan.seen }, { "worked_on", plan.worked_on },
            { "scope", port_document(plan.scope) }, { "tip_mm", point(plan.view.tip) },
            { "view", point(plan.view.view) }, { "insertion_mm", plan.view.insertion_mm },
            { "tip_to_target_mm", plan.view.to_target_mm }, { "between_instruments_deg", plan.between_deg },
            { "nearest_shafts_mm", plan.nearest_shafts_mm }, { "instruments", Json::array() } };
        for (std::size_t n = 0; n < plan.instruments.size(); ++n) {
            Json port = port_document(plan.instruments.at(n));
            port["working_length_mm"] = plan.working_length_mm.at(n);
            port["from_view_deg"] = plan.from_view_deg.at(n);
            document["instruments"].push_back(std::move(port));
        }
        return document;
    }

    std::string plan_text(const planner::PortPlan& plan, std::size_t number)
    {
        std::string text
            = formatted("%zu. %3.0f points  the scope sees %.0f %% of the target, both instruments work on "
                        "%.0f %%\n",
                number, plan.points, 100.0 * plan.seen, 100.0 * plan.worked_on);
        text += "   scope:      " + planner::place_in_words(plan.scope)
            + formatted(
                "; %.0f mm deep, its lens %.0f mm from the target\n", plan.view.insertion_mm, plan.view.to_target_mm);
        for (std::size_t n = 0; n < plan.instruments.size(); ++n)
            text += "   instrument: " + planner::place_in_words(plan.instruments.at(n))
                + formatted("; %.0f mm to the target, %.0f degrees from the view\n", plan.working_length_mm.at(n),
                    plan.from_view_deg.at(n));
        return text
            + formatted("   between the instruments %.0f degrees; the nearest shafts keep %.0f mm\n", plan.between_deg,
                plan.nearest_shafts_mm);
    }

    void write_results(const std::filesystem::path& folder, planner::Patient& patient,
        const planner::PortRequest& request, const planner::PortSearch& search, const Json& document, const Job& job)
    {
        constexpr int kWidth = 2000, kHeight = 1000;
        StagedResults staged(folder);
        OffscreenRenderer renderer(make_offscreen_context(), job);
        for (std::size_t n = 0; n < search.found.size(); ++n)
            write_png(staged.folder() / formatted("ports-%zu.png", n + 1),
                renderer.render(port_picture(patient, request, search.found[n], kWidth, kHeight)));
        write_file_atomically(staged.folder() / "ports.json", document.dump(2) + "\n");
        refuse_if_cancelled(job);
        staged.publish("ports.json");
        std::error_code code; // pictures of more proposals, from a run before
        for (std::size_t n = search.found.size() + 1; n <= kMostProposals; ++n)
            std::filesystem::remove(folder / formatted("ports-%zu.png", n), code);
    }

    Outcome ports(const PortsOptions& options, const Job& job)
    {
        const planner::Case planned_case = open_case(options.case_file);
        planner::Patient patient(planned_case, job);
        planner::PortRequest request { .target = target_of(options, patient),
            .optics = options.optics,
            .sizes = options.sizes,
            .aside = options.retracted };
        if (!options.spaces.empty())
            std::tie(request.highest_space, request.lowest_space) = parse_spaces(options.spaces);
        std::optional<OutFolder> folder;
        if (!options.out.empty())
            folder.emplace(options.out);
        check_in_body(request.target, patient);
        request.left = is_left(options, request.target, patient);
        const planner::PortSearch search
            = planner::find_ports(patient, request, static_cast<std::size_t>(options.count), job);
        refuse_if_cancelled(job);
        Outcome outcome { .document
            = { { "target", planner::target_name(request.target) }, { "side", request.left ? "left" : "right" },
                { "optics_deg", request.optics.tilt_deg }, { "tried", search.ports }, { "scopes", search.scopes },
                { "instruments", search.instruments }, { "seconds", search.seconds }, { "proposals", Json::array() } },
            .text = formatted("%zu places tried in %.0f s: a scope sees the target from %zu, an instrument reaches it "
                              "from %zu\n",
                search.ports, search.seconds, search.scopes, search.instruments) };
        for (std::size_t n = 0; n < search.found.size(); ++n) {
            outcome.document["proposals"].push_back(plan_document(search.found[n]));
            outcome.text += plan_text(search.found[n], n + 1);
        }
        if (search.found.empty()) {
            outcome.text += "No scope and two instruments of this side see and reach the target together with room for "
                            "their shafts. Try the other side, another target, or hold more organs aside.\n";
            outcome.exit_code = 1;
        } else
            outcome.text
                += "The chest is at rest, as in the CT; the lung of this side is held aside. Structures without "
                   "a label are not considered.\n";
        if (folder) {
            write_results(options.out, patient, request, search, outcome.document, job);
            outcome.text += "wrote " + options.out + "/ports.json"
                + (search.found.empty() ? "\n" : " and a picture of each proposal\n");
        }
        return outcome;
    }

} // namespace

void add_ports_command(Commands& commands)
{
    auto options = std::make_shared<PortsOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "ports", "Propose ports for thoracoscopy: a scope and two instruments through intercostal spaces of one side");
    command->footer(
        "Example: retractor ports C/case.json --target heart --side right --out P\n"
        "Example: retractor ports C/case.json --target \"annulus:heart:5,-20,140,15\" --optics 0 --spaces 3-6");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--target", options->target,
        "Label; SITE:LABEL:x,y,z,r; or x,y,z,r for a sphere, mm (default: the first label of role target)");
    command
        ->add_option(
            "--side", options->side, "Side of the ports, whose lung is held aside (default: the target's side)")
        ->check(CLI::IsMember({ "left", "right" }));
    command->add_option("--optics", options->optics.tilt_deg, "Angle of the scope's optics, degrees, such as 0 or 30")
        ->check(in_range(0.0, 60.0))
        ->capture_default_str();
    command->add_option("--field", options->optics.field_deg, "Full angle of the scope's view cone, degrees")
        ->check(in_range(1.0, 120.0))
        ->capture_default_str();
    command->add_option("--scope", options->sizes.scope_mm, "Diameter of the scope, mm")
        ->check(in_range(1.0, 20.0))
        ->capture_default_str();
    command->add_option("--shaft", options->sizes.shaft_mm, "Diameter of an instrument, mm")
        ->check(in_range(1.0, 20.0))
        ->capture_default_str();
    command->add_option("--spaces", options->spaces, "Intercostal spaces that are tried, such as 3-6 (default: 3-8)");
    command
        ->add_option("--retract", options->retracted,
            "Organs that are held aside besides the lung of this side, the pericardium and the fat of the mediastinum, "
            "separated by commas")
        ->delimiter(',');
    command->add_option("--count", options->count, "Number of proposals")
        ->check(CLI::Range(1, static_cast<int>(kMostProposals)))
        ->capture_default_str();
    command->add_option("--out", options->out, "Folder for ports.json and a picture of each proposal");
    commands.on(command, [options](const Job& job) { return ports(*options, job); });
}

} // namespace retractor::ui::cli
