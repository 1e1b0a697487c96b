#include "mesh/base/text_format.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"

#include "fem/statics/driven_opening.h"
#include "mesh/base/error.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "ui/cli/framework/open_case.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace retractor::ui::cli {

namespace {

    constexpr double kLongestMm = 2000.0; // length of an incision or a depth; longer than any patient

    struct ApproachOptions {
        std::string case_file, name, template_name, target, hooks = "4", loose = "held";
        std::vector<std::string> points, retracted, ablations;
        double length_mm = 0.0, depth_mm = 0.0, opening_mm = 0.0;
        std::optional<double> edge_mm, coarse_mm, region_mm;
        planner::HookPull pull {};
        bool right = false, opening_given = false;
    };

    Json approach_document(const planner::Approach& approach)
    {
        Json ablations = Json::array();
        for (const planner::AblationSpec& ablation : approach.ablations)
            ablations.push_back(Json::parse(planner::ablation_to_json(ablation)));
        return { { "name", approach.name }, { "template", approach.template_name },
            { "incision_length_mm", planner::incision_length(approach) }, { "depth_mm", approach.depth_mm },
            { "hooks", approach.hooks.size() }, { "retracted", approach.retracted }, { "ablations", ablations },
            { "loose_pieces", to_string(approach.loose_pieces) }, { "rationale", approach.rationale } };
    }

    std::string approach_line(const planner::Approach& approach)
    {
        std::string text
            = formatted("%-18s %-16s incision %4.0f mm, depth %3.0f mm, %zu hooks, target %s\n", approach.name.c_str(),
                approach.template_name.c_str(), planner::incision_length(approach), approach.depth_mm,
                approach.hooks.size(), approach.target.is_sphere() ? "sphere" : approach.target.label.c_str());
        for (const planner::AblationSpec& ablation : approach.ablations)
            text += "  takes out " + planner::ablation_text(ablation, planner::incision_length(approach)) + "\n";
        if (!approach.ablations.empty() || approach.loose_pieces != planner::LoosePieces::held)
            text += "  loose pieces are " + std::string(to_string(approach.loose_pieces)) + "\n";
        return text;
    }

    void check_ablated_label(const mesh::LabelTable& table, const std::string& label, const std::string& where)
    {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        if (label.empty() || (info != nullptr && info->role == mesh::Role::wall))
            return;
        std::string known;
        for (const mesh::LabelInfo& other : table)
            if (other.role == mesh::Role::wall)
                known += (known.empty() ? "" : ", ") + other.name;
        throw InputError((info != nullptr ? "only tissue of the wall can be removed, and \"" + label + "\" is none"
                                          : "there is no label \"" + label + "\"")
                + "; the wall has: " + (known.empty() ? "none" : known),
            where);
    }

    std::vector<planner::AblationSpec> parse_ablations(const ApproachOptions& options, const mesh::LabelTable& table)
    {
        std::vector<planner::AblationSpec> ablations;
        for (const std::string& text : options.ablations) {
            ablations.push_back(parse_ablation(text));
            check_ablated_label(table, ablations.back().label, "--ablate " + text);
        }
        return ablations;
    }

    /// Checks that every ablation lies along the incision.
    void check_ablations_along(const ApproachOptions& options, const planner::Approach& approach)
    {
        const double length = planner::incision_length(approach);
        for (std::size_t n = 0; n < approach.ablations.size(); ++n) {
            const planner::AblationSpec& ablation = approach.ablations[n];
            if (ablation.along_from_mm.value_or(0.0) >= 0.0 && ablation.along_to_mm.value_or(length) <= length)
                continue;
            throw InputError(
                formatted("along the incision there is 0 to %.1f mm", length), "--ablate " + options.ablations[n]);
        }
    }

    planner::Approach approach_from_options(
        const ApproachOptions& options, planner::Patient& patient, std::string& remark)
    {
        planner::ApproachRequest request;
        request.name = options.name;
        request.target = parse_target(options.target);
        request.left = !options.right;
        request.length_mm = options.length_mm;
        request.sizing = patient.planned_case().sizing;
        request.sizing.corridor_edge_mm = options.edge_mm.value_or(request.sizing.corridor_edge_mm);
        request.sizing.coarse_edge_mm = options.coarse_mm.value_or(request.sizing.coarse_edge_mm);
        request.sizing.region_mm = options.region_mm.value_or(request.sizing.region_mm);
        if (options.points.empty()) {
            request.template_name = options.template_name;
            return planner::approach_from_template(*patient.labels(), *patient.anatomy(), request);
        }
        std::vector<Vec3> points;
        for (const std::string& text : options.points)
            points.push_back(parse_point(text, "--points"));
        const planner::PointsApproach by_points
            = planner::approach_from_points(*patient.labels(), points, request, options.depth_mm);
        double furthest = 0.0;
        for (const double moved : by_points.moved_mm)
            furthest = std::max(furthest, moved);
        remark = formatted("points were moved onto the skin by at most %.1f mm\n", furthest);
        return by_points.approach;
    }

    void check_hook_options(const ApproachOptions& options)
    {
        planner::check_pull(options.pull, "hooks: ");
        if (options.pull.force_N && options.opening_mm > 0.0)
            throw InputError("a hook that pulls with a force goes as far as that takes it: leave one of the two out",
                "--opening, --hook-force");
        if (!options.pull.force_N && !options.pull.prescribes() && !(options.opening_mm > 0.0))
            throw InputError("hooks that yield or grip softly are drawn somewhere: give --opening as well",
                options.pull.force_limit_N ? "--hook-limit" : "--hook-grip");
    }

    void add_hook_options(CLI::App& command, ApproachOptions& options)
    {
        command.add_option("--hook-force", options.pull.force_N,
            "Each hook pulls with this force (N) along its direction, however far that goes (instead of --opening)");
        command.add_option("--hook-limit", options.pull.force_limit_N,
            "Each hook yields where it would have to pull with more than this force (N)");
        command.add_option("--hook-grip", options.pull.grip_N_per_mm,
            "Each hook draws its lip through a grip of this stiffness (N/mm) (default: the lip follows completely)");
    }

    Outcome add(const ApproachOptions& options, const Job& job)
    {
        if (options.points.empty() == options.template_name.empty())
            throw InputError("give either --template or --points", "command line");
        planner::Case planned_case = open_case(options.case_file);
        check_hook_options(options);
        std::vector<planner::AblationSpec> ablations = parse_ablations(options, planned_case.label_table);
        planner::Patient patient(planned_case, job);
        Outcome outcome;
        planner::Approach approach = approach_from_options(options, patient, outcome.text);
        approach.ablations = std::move(ablations);
        approach.loose_pieces = planner::loose_pieces_from_string(options.loose).value();
        check_ablations_along(options, approach);
        const std::string name = approach.name;
        for (const std::string& organ : options.retracted)
            if (std::find(approach.retracted.begin(), approach.retracted.end(), organ) == approach.retracted.end())
                approach.retracted.push_back(organ);
        planner::add_approach(planned_case, std::move(approach));
        if (options.opening_mm > 0.0 || !options.pull.prescribes())
            planner::set_hooks(planned_case, name, options.hooks, options.opening_mm, options.pull);
        planner::write_case(planned_case);
        outcome.document = approach_document(planner::find_approach(planned_case, name));
        outcome.text += approach_line(planner::find_approach(planned_case, name));
        return outcome;
    }

    Outcome list(const std::string& case_file)
    {
        const planner::Case planned_case = open_case(case_file);
        Outcome outcome;
        outcome.document["approaches"] = Json::array();
        for (const planner::Approach& approach : planned_case.approaches) {
            outcome.document["approaches"].push_back(approach_document(approach));
            outcome.text += approach_line(approach);
        }
        if (planned_case.approaches.empty())
            outcome.text = "no approaches yet; see retractor approach add --help\n";
        return outcome;
    }

    Outcome remove(const std::string& case_file, const std::string& name)
    {
        planner::Case planned_case = open_case(case_file);
        planner::remove_approach(planned_case, name);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document["removed"] = name;
        return outcome;
    }

    Outcome change_hooks(const ApproachOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        check_hook_options(options);
        if (!options.pull.force_N && !options.opening_given)
            throw InputError("give --opening or --hook-force", "command line");
        planner::set_hooks(planned_case, options.name, options.hooks, options.opening_mm, options.pull);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document = approach_document(planner::find_approach(planned_case, options.name));
        outcome.text = approach_line(planner::find_approach(planned_case, options.name));
        return outcome;
    }

    void add_add_command(CLI::App& approach, Commands& commands, const std::shared_ptr<ApproachOptions>& options)
    {
        CLI::App* add_command
            = approach.add_subcommand("add", "Write an approach by template, or by points on the skin");
        add_command->footer(
            "Example: retractor approach add case.json --template intercostal:4 --target aneurysm --opening 50\n"
            "         retractor approach add case.json --name mine --points 40,-110,20 55,-100,10 --target "
            "20,-10,30,15\n"
            "         retractor approach add case.json --template intercostal:5 --target aneurysm --opening 50 "
            "--ablate rib_left_6:2,22:40,90 --loose removed");
        add_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
        add_command->add_option("--template", options->template_name, "median, intercostal:N, distal, midcab");
        add_command->add_option(
            "--points", options->points, "Points x,y,z (mm, LPS) on or near the skin, in cutting order");
        add_command->add_option("--target", options->target, "A label, or a sphere x,y,z,r")->required();
        add_command->add_option("--name", options->name, "Name of the approach (default: the template's)");
        add_command->add_option("--length", options->length_mm, "Length of the incision, mm (default: the template's)")
            ->check(in_range(0.0, kLongestMm));
        add_command
            ->add_option(
                "--depth", options->depth_mm, "With --points: depth of the cut, mm (default: through the wall)")
            ->check(in_range(0.0, kLongestMm));
        add_command
            ->add_option("--retract", options->retracted,
                "Organs held aside, NAME,..., besides the template's: they do not block the view")
            ->delimiter(',');
        add_command
            ->add_option("--ablate", options->ablations,
                "Taken out after the cut, in this order (repeatable): LABEL:FROM,TO[:ALONG_FROM,ALONG_TO], a segment "
                "of "
                "one "
                "label, mm across the incision (positive: left of the cutting direction, looking down on the skin) and "
                "along it (default: its ends), sawn through there; or ball:X,Y,Z,RADIUS[:LABEL], mm (default: all "
                "tissue)")
            ->allow_extra_args(false);
        add_command
            ->add_option("--loose", options->loose,
                "Pieces that cut and ablations leave without support: held (on a soft bed), removed, or rigid (they go "
                "with "
                "the tissue beside them)")
            ->capture_default_str()
            ->check(CLI::IsMember({ "held", "removed", "rigid" }));
        add_command->add_flag("--right", options->right, "Intercostal: on the patient's right");
        add_command->add_option("--hooks", options->hooks, "Hook template: 2, 4, 8 or blade")->capture_default_str();
        add_command
            ->add_option("--opening", options->opening_mm, "Distance between opposite hooks, mm; 0: no hooks yet")
            ->check(in_range(0.0, 2.0 * fem::kFarthestHookMm));
        add_hook_options(*add_command, *options);
        add_command->add_option(
            "--edge", options->edge_mm, "Mesh edges in the corridor round the incision, mm (default: the case's)");
        add_command->add_option("--coarse", options->coarse_mm, "Mesh edges far from it, mm (default: the case's)");
        add_command->add_option("--region", options->region_mm,
            "Mesh only this far round the incision, and the bones met to their ends, mm; 0: the whole wall");
        add_command->callback(
            [&commands, options] { commands.run = [options](const Job& job) { return add(*options, job); }; });
    }

} // namespace

void add_approach_commands(Commands& commands)
{
    CLI::App* approach = commands.app.add_subcommand("approach", "Add, list or remove the approaches of a case");
    approach->require_subcommand(1);
    auto options = std::make_shared<ApproachOptions>();
    add_add_command(*approach, commands, options);

    CLI::App* list_command = approach->add_subcommand("list", "List the approaches of a case");
    list_command->footer("Example: retractor approach list case.json");
    list_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    list_command->callback(
        [&commands, options] { commands.run = [options](const Job&) { return list(options->case_file); }; });

    CLI::App* remove_command = approach->add_subcommand("remove", "Remove an approach");
    remove_command->footer("Example: retractor approach remove case.json --name median");
    remove_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    remove_command->add_option("--name", options->name, "Name of the approach")->required();
    remove_command->callback([&commands, options] {
        commands.run = [options](const Job&) { return remove(options->case_file, options->name); };
    });
}

void add_hooks_command(Commands& commands)
{
    auto options = std::make_shared<ApproachOptions>();
    CLI::App* command = commands.app.add_subcommand("hooks", "Place hooks on both lips of an approach");
    command->footer("Example: retractor hooks case.json --approach median --template 4 --opening 60\n"
                    "Example: retractor hooks case.json --approach median --opening 60 --hook-limit 150");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--approach", options->name, "Name of the approach")->required();
    command->add_option("--template", options->hooks, "2, 4, 8 or blade")->capture_default_str();
    CLI::Option* opening = command->add_option("--opening", options->opening_mm, "Distance between opposite hooks, mm")
                               ->check(in_range(0.0, 2.0 * fem::kFarthestHookMm));
    add_hook_options(*command, *options);
    command->callback([&commands, options, opening] {
        options->opening_given = opening->count() > 0;
        commands.run = [options](const Job&) { return change_hooks(*options); };
    });
}

} // namespace retractor::ui::cli
