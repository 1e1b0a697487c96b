#include "ui/cli/commands.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/neighbour_approaches.h"
#include "planner/case/case_io.h"
#include "planner/case/draft_case.h"
#include "planner/case/patient.h"
#include "planner/decision/decisions.h"
#include "planner/plan/saved/saved_plan.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/plan/comparison_text.h"
#include "ui/cli/plan/field_table.h"
#include "ui/cli/plan/saved_plans.h"
#include "ui/results/field_files.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    struct CompareOptions {
        std::string case_file, approach;
        std::vector<std::string> weights;
        bool neighbours = false;
        bool draft = false;
        bool keep = false;
    };

    ComparedField compared(
        planner::Patient& patient, planner::FieldMetrics metrics, const planner::Approach& approach, std::string name)
    {
        return { .candidate
            = { .field = std::move(metrics), .divided_bones = planner::divided_bones(*patient.labels(), approach) },
            .name = std::move(name) };
    }

    // ---- approaches of the case ------------------------------------------------------------------------------------

    Outcome compare_saved(const planner::Case& planned_case, const CompareOptions& options,
        const planner::Weights& weights, const Job& job)
    {
        planner::Patient patient(planned_case, job);
        std::vector<ComparedField> fields;
        std::vector<std::string> unplanned;
        for (const planner::Approach& approach : planned_case.approaches) {
            std::string why;
            try {
                if (auto saved = planner::read_saved_plan(planned_case, approach.name)) {
                    fields.push_back(
                        compared(patient, std::move(saved->field.metrics), approach, planner::spoken_name(approach)));
                    continue;
                }
            } catch (const Error& error) {
                why = std::string(" (") + error.what() + ")";
            }
            unplanned.push_back(approach.name + why);
        }
        if (fields.size() < 2)
            throw InputError("a comparison needs two planned approaches, and the case has "
                    + std::to_string(fields.size())
                    + (unplanned.empty() ? "" : " (not planned: " + joined(unplanned) + ")")
                    + ": plan them with retractor plan, without options that change the plan",
                options.case_file);
        Outcome outcome { .document = comparison_document(fields, weights),
            .text = comparison_text(fields, weights, Marks::leader) };
        outcome.document["not_planned"] = unplanned;
        try {
            if (const std::string chosen = planner::holding_choice(planned_case); !chosen.empty()) {
                outcome.document["chosen"] = chosen;
                outcome.text += chosen + "\n";
            }
        } catch (const Error& error) { // a damaged record does not hold the comparison back
            outcome.text += std::string("caution: the team's choice cannot be read: ") + error.what() + "\n";
        }
        if (!unplanned.empty())
            outcome.text += "not planned: " + joined(unplanned) + "\n";
        return outcome;
    }

    // ---- neighbours ------------------------------------------------------------------------------------------------

    /// An approach with its neighbours, planned.
    struct PlannedNeighbours {
        planner::Case group; ///< with the approach and its neighbours only
        std::vector<ComparedField> fields; ///< the approach first
        std::vector<std::string> missing; ///< "one space higher: reason"
        bool approach_is_first = false; ///< the approach itself has numbers
        std::string remarks; ///< on saved plans
        int exit_code = 0;
    };

    PlannedNeighbours planned_neighbours(
        planner::Case group, const planner::Approach& approach, bool draft, const Job& job)
    {
        PlannedNeighbours planned;
        group.approaches = { approach };
        std::vector<std::string> names { planner::spoken_name(approach) };
        {
            planner::Patient patient(group, job);
            for (planner::NeighbourApproach& neighbour : planner::neighbours_of(patient, approach)) {
                if (!neighbour.approach) {
                    planned.missing.push_back(neighbour.where + ": " + neighbour.refused);
                    continue;
                }
                names.push_back(neighbour.where + " (" + neighbour.approach->name + ")");
                planner::add_approach(group, std::move(*neighbour.approach));
            }
        }
        planned.group = group;
        if (group.approaches.size() < 2)
            return planned;
        if (draft)
            planner::make_draft(group);
        const planner::PlanChecks checks { .error_bars = !draft, .draft = draft, .find_region = !draft };
        planner::check_plan(group, checks);
        planner::Patient patient(group, job);
        const DrawnFields drawn = saved_or_planned(patient, job, checks);
        std::vector<planner::PlannedField> made;
        for (std::size_t n = 0; n < drawn.fields.size(); ++n) {
            const planner::PlannedField& field = drawn.fields[n];
            if (planner::is_measured(field))
                planned.fields.push_back(compared(patient, field.metrics, group.approaches[n], names[n]));
            else
                planned.missing.push_back(names[n] + ": " + field.message);
            if (!drawn.saved.contains(field.approach.name))
                made.push_back(field);
        }
        planned.approach_is_first = planner::is_measured(drawn.fields.front());
        planned.exit_code = exit_code_of(drawn.fields);
        planned.remarks = drawn.remarks + save_plans(group, group, made);
        return planned;
    }

    /// Adds the neighbours to the case file, where the names are free. @returns their names
    std::vector<std::string> keep_neighbours(planner::Case& planned_case, const planner::Case& group)
    {
        std::vector<std::string> kept;
        for (std::size_t n = 1; n < group.approaches.size(); ++n)
            if (const planner::Approach& approach = group.approaches[n];
                planner::free_approach_name(planned_case, approach.name) == approach.name) {
                planner::add_approach(planned_case, approach);
                kept.push_back(approach.name);
            }
        return kept;
    }

    Outcome compare_neighbours(
        const planner::Case& in_file, const CompareOptions& options, const planner::Weights& weights, const Job& job)
    {
        Outcome outcome;
        outcome.document["neighbours"] = Json::array();
        std::vector<planner::Case> groups;
        for (const planner::Approach& approach : in_file.approaches) {
            if (!options.approach.empty() && approach.name != options.approach)
                continue;
            const PlannedNeighbours planned = planned_neighbours(in_file, approach, options.draft, job);
            refuse_if_cancelled(job);
            Json group = planned.fields.size() > 1 ? comparison_document(planned.fields, weights) : Json::object();
            group["of"] = approach.name;
            group["missing"] = planned.missing;
            outcome.text += "Beside " + planner::spoken_name(approach) + ":\n";
            if (planned.fields.size() > 1)
                outcome.text += comparison_text(
                    planned.fields, weights, planned.approach_is_first ? Marks::against_first : Marks::leader);
            else if (planned.missing.empty())
                outcome.text += "This approach has no neighbours.\n";
            for (const std::string& missing : planned.missing)
                outcome.text += "missing: " + missing + "\n";
            outcome.text += planned.remarks + "\n";
            outcome.exit_code = std::max(outcome.exit_code, planned.exit_code);
            outcome.document["neighbours"].push_back(std::move(group));
            groups.push_back(planned.group);
        }
        if (options.keep) {
            planner::Case present = open_case(options.case_file); // the window may have changed it meanwhile
            std::vector<std::string> kept;
            for (const planner::Case& group : groups)
                for (std::string& name : keep_neighbours(present, group))
                    kept.push_back(std::move(name));
            planner::write_case(present);
            outcome.document["kept"] = kept;
            outcome.text
                += kept.empty() ? "no approach was added to the case\n" : "added to the case: " + joined(kept) + "\n";
        }
        return outcome;
    }

    Outcome compare(const CompareOptions& options, const Job& job)
    {
        const planner::Weights weights = parse_weights(options.weights);
        const planner::Case planned_case = open_case(options.case_file);
        if (!options.neighbours) {
            if (options.draft || options.keep || !options.approach.empty())
                throw InputError("this option needs --neighbours",
                    options.draft      ? "--draft"
                        : options.keep ? "--keep"
                                       : "--approach");
            return compare_saved(planned_case, options, weights, job);
        }
        if (planned_case.approaches.empty())
            throw InputError("the case has no approach yet: add one with retractor approach add",
                options.case_file + "#/approaches");
        if (!options.approach.empty())
            static_cast<void>(planner::find_approach(planned_case, options.approach)); // refuses an unknown name
        return compare_neighbours(planned_case, options, weights, job);
    }

    std::string criteria_help()
    {
        std::string text = "The score of an approach, 0 to 100 points, is the weighted mean of:\n";
        for (const planner::Criterion& criterion : planner::criteria())
            text += formatted("  %-12s %s (weight %s)\n", criterion.key, criterion.meaning,
                formatted("%g", criterion.weight).c_str());
        return text;
    }

} // namespace

void add_compare_command(Commands& commands)
{
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command = commands.app.add_subcommand("compare",
        "Compare the planned approaches of a case: verdicts, what to think of first, numbers with their errors, and a "
        "ranking");
    command->footer(criteria_help()
        + "Example: retractor compare C/case.json    (after retractor plan C/case.json --out D)\n"
          "Example: retractor compare C/case.json --weights seen=5,incision=0\n"
          "Example: retractor compare C/case.json --neighbours --approach midcab --draft");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command
        ->add_option("--weights", options->weights,
            "CRITERION=NUMBER, separated by commas: weights of the score other than those below; 0 leaves out")
        ->delimiter(',');
    command->add_flag("--neighbours", options->neighbours,
        "Compare each approach with the same in the space above and below, and 20 mm along to either side. They are "
        "planned, on one mesh each, where no saved plan is at hand");
    command->add_option("--approach", options->approach, "With --neighbours: only of this approach (default: all)");
    command->add_flag("--draft", options->draft,
        "With --neighbours: a quick look, as retractor plan --draft; without error bars no approach leads");
    command->add_flag("--keep", options->keep,
        "With --neighbours: add the neighbours to the case, so that the window and other commands have them");
    commands.on(command, [options](const Job& job) { return compare(*options, job); });
}

} // namespace retractor::ui::cli
