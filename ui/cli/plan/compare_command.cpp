#include "ui/cli/commands.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/comparison.h"
#include "planner/measures/verdict.h"
#include "planner/plan/saved/saved_plan.h"
#include "ui/cli/framework/open_case.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui::cli {

namespace {

    struct Compared {
        std::vector<planner::FieldMetrics> fields; ///< of the planned approaches
        std::vector<std::string> names; ///< as surgeons say them
        std::vector<std::string> unplanned;
    };

    Compared saved_fields(const planner::Case& planned_case)
    {
        Compared compared;
        for (const planner::Approach& approach : planned_case.approaches) {
            std::optional<planner::SavedPlan> saved;
            std::string why;
            try {
                saved = planner::read_saved_plan(planned_case, approach.name);
            } catch (const Error& error) {
                why = std::string(" (") + error.what() + ")";
            }
            if (!saved) {
                compared.unplanned.push_back(approach.name + why);
                continue;
            }
            compared.fields.push_back(std::move(saved->field.metrics));
            compared.names.push_back(planner::spoken_name(approach));
        }
        return compared;
    }

    std::string cell(const planner::ComparedMeasure& measure, std::size_t n)
    {
        const planner::ComparedNumber& number = measure.numbers[n];
        std::string text = planner::metric_text(*measure.metric, number.value);
        if (number.bar)
            text += " +- " + planner::metric_number(*measure.metric, *number.bar);
        return measure.leader == n ? text + " *" : text;
    }

    /// Characters on the screen, of UTF-8.
    std::size_t width_of(const std::string& text)
    {
        return static_cast<std::size_t>(std::count_if(
            text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
    }

    std::string padded(const std::string& text, std::size_t width)
    {
        return text + std::string(std::max(width, width_of(text)) - width_of(text), ' ');
    }

    std::string table(const std::vector<planner::ComparedMeasure>& measures, std::size_t fields)
    {
        std::vector<std::vector<std::string>> rows { { "" } };
        for (std::size_t n = 0; n < fields; ++n)
            rows.front().push_back(planner::compared_letter(n));
        for (const planner::ComparedMeasure& measure : measures) {
            rows.push_back({ measure.metric->caption });
            for (std::size_t n = 0; n < fields; ++n)
                rows.back().push_back(cell(measure, n));
        }
        std::vector<std::size_t> widths(fields + 1, 0);
        for (const auto& row : rows)
            for (std::size_t c = 0; c < row.size(); ++c)
                widths[c] = std::max(widths[c], width_of(row[c]));
        std::string text;
        for (const auto& row : rows) {
            std::string line;
            for (std::size_t c = 0; c < row.size(); ++c)
                line += padded(row[c], widths[c]) + "  ";
            text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
        }
        return text;
    }

    Outcome compare(const std::string& case_file, const Job&)
    {
        const planner::Case planned_case = open_case(case_file);
        const Compared compared = saved_fields(planned_case);
        if (compared.fields.size() < 2)
            throw InputError("a comparison needs two planned approaches, and the case has "
                    + std::to_string(compared.fields.size())
                    + (compared.unplanned.empty() ? "" : " (not planned: " + joined(compared.unplanned) + ")")
                    + ": plan them with retractor plan, without options that change the plan",
                case_file);
        const std::vector<planner::ComparedMeasure> measures = planner::compared_measures(compared.fields);
        Outcome outcome;
        outcome.document["approaches"] = Json::array();
        for (std::size_t n = 0; n < compared.fields.size(); ++n) {
            const planner::Verdict verdict = planner::verdict_of(compared.fields[n]);
            outcome.text += planner::compared_letter(n) + "  " + compared.names[n] + ":";
            for (const std::string& sentence : verdict.sentences)
                outcome.text += " " + sentence;
            outcome.text += "\n";
            outcome.document["approaches"].push_back({ { "name", compared.fields[n].name },
                { "light", planner::to_string(verdict.light) }, { "sentences", verdict.sentences } });
        }
        outcome.text += "\n" + table(measures, compared.fields.size())
            + "* better than every other by more than both errors together\n";
        const bool one_target = planner::have_one_target(compared.fields);
        if (!one_target)
            outcome.text += std::string(planner::kDifferentTargets) + "\n";
        if (!compared.unplanned.empty())
            outcome.text += "not planned: " + joined(compared.unplanned) + "\n";
        outcome.document["one_target"] = one_target;
        outcome.document["not_planned"] = compared.unplanned;
        for (const planner::ComparedMeasure& measure : measures) {
            Json row { { "key", measure.metric->key }, { "values", Json::array() }, { "bars", Json::array() } };
            for (const planner::ComparedNumber& number : measure.numbers) {
                row["values"].push_back(number.value);
                row["bars"].push_back(number.bar ? Json(*number.bar) : Json());
            }
            row["leader"] = measure.leader ? Json(compared.fields[*measure.leader].name) : Json();
            outcome.document["measures"].push_back(row);
        }
        return outcome;
    }

} // namespace

void add_compare_command(Commands& commands)
{
    auto case_file = std::make_shared<std::string>();
    CLI::App* command = commands.app.add_subcommand(
        "compare", "Compare the planned approaches of a case: verdicts, numbers with their errors, and what leads");
    command->footer("Example: retractor compare C/case.json    (after retractor plan C/case.json --out D)");
    command->add_option("case", *case_file, "case.json")->required()->check(CLI::ExistingPath);
    commands.on(command, [case_file](const Job& job) { return compare(*case_file, job); });
}

} // namespace retractor::ui::cli
