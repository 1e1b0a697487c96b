#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/case/case_io.h"
#include "planner/decision/decisions.h"
#include "planner/measures/provenance.h"
#include "planner/measures/verdict.h"
#include "planner/plan/saved/saved_plan.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

namespace retractor::ui::cli {

namespace {

    /// A case without its images: a decision needs none of them.
    planner::Case case_at(const std::string& path) { return planner::read_case(path, { .verify_checksums = false }); }

    // ---- choose ----------------------------------------------------------------------------------------------------

    struct ChooseOptions {
        std::string case_file, approach, by, why;
    };

    /// What the saved plan of an approach says, in its own sentences; empty: there is none.
    std::string plan_text(const planner::Case& planned_case, const std::string& approach)
    {
        try {
            if (const auto saved = planner::read_saved_plan(planned_case, approach)) {
                std::string text;
                for (const std::string& sentence : planner::verdict_of(saved->field.metrics).sentences)
                    text += (text.empty() ? "" : " ") + sentence;
                return text;
            }
        } catch (const Error&) { // a damaged plan: the choice stands without it
        }
        return {};
    }

    Json document_of(const planner::Choice& choice)
    {
        return { { "approach", choice.approach }, { "by", choice.by }, { "why", choice.why }, { "when", choice.when },
            { "plan", choice.plan } };
    }

    Outcome list_choices(const planner::Case& planned_case, const planner::Decisions& decisions)
    {
        Outcome outcome;
        outcome.document["choices"] = Json::array();
        for (const planner::Choice& choice : decisions.choices) {
            outcome.document["choices"].push_back(document_of(choice));
            outcome.text += planner::choice_sentence(choice, planner::chosen_name(planned_case, choice)) + "\n"
                + (choice.plan.empty() ? "  It was not planned then.\n" : "  Its plan then: " + choice.plan + "\n");
        }
        if (decisions.choices.empty())
            outcome.text = "no approach is chosen yet\n";
        else if (decisions.choices.size() > 1)
            outcome.text += "The last choice holds.\n";
        return outcome;
    }

    Outcome choose(const ChooseOptions& options)
    {
        const planner::Case planned_case = case_at(options.case_file);
        const std::filesystem::path file = planner::decisions_file(planned_case);
        planner::Decisions decisions = planner::read_decisions(file);
        if (options.approach.empty()) {
            if (!options.by.empty() || !options.why.empty())
                throw InputError("this option needs an approach", options.by.empty() ? "--why" : "--by");
            return list_choices(planned_case, decisions);
        }
        static_cast<void>(planner::find_approach(planned_case, options.approach)); // refuses an unknown name
        if (options.by.empty() || options.why.empty())
            throw InputError("say who chooses and why", options.by.empty() ? "--by" : "--why");
        planner::Choice choice { .approach = options.approach,
            .by = options.by,
            .why = options.why,
            .when = planner::utc_text(std::chrono::system_clock::now()),
            .plan = plan_text(planned_case, options.approach) };
        Outcome outcome { .document = document_of(choice),
            .text = planner::choice_sentence(choice, planner::chosen_name(planned_case, choice)) + "\n"
                + (choice.plan.empty() ? "caution: this approach has no plan that holds now\n"
                                       : "Its plan: " + choice.plan + "\n")
                + "wrote " + file.string() + "\n" };
        decisions.choices.push_back(std::move(choice));
        planner::write_decisions(file, decisions);
        return outcome;
    }

    // ---- questionnaire ---------------------------------------------------------------------------------------------

    struct QuestionnaireOptions {
        std::vector<std::string> cases;
        std::string by, note, sheet;
        std::vector<std::string> points;
    };

    std::string known_keys()
    {
        std::vector<std::string> keys;
        for (const planner::Question& question : planner::kQuestions)
            keys.emplace_back(question.key);
        return joined(keys);
    }

    /// @param texts "shape=4", one for each question
    planner::Answers parse_answers(const std::vector<std::string>& texts)
    {
        planner::Answers answers;
        for (const std::string& text : texts) {
            const std::string where = "--points " + text;
            const std::size_t equals = text.find('=');
            const auto found = std::ranges::find_if(planner::kQuestions,
                [&](const planner::Question& question) { return text.substr(0, equals) == question.key; });
            if (equals == std::string::npos || found == planner::kQuestions.end())
                throw InputError("an answer is QUESTION=POINTS; the questions are " + known_keys(), where);
            int& points = answers.points.at(static_cast<std::size_t>(found - planner::kQuestions.begin()));
            if (points != 0)
                throw InputError("this question is answered twice", where);
            const double number = parse_numbers(text.substr(equals + 1), 1, where).front();
            if (number != std::round(number) || number < planner::kLeastPoints || number > planner::kMostPoints)
                throw InputError(
                    formatted("an answer has %d to %d points", planner::kLeastPoints, planner::kMostPoints), where);
            points = static_cast<int>(number);
        }
        for (std::size_t q = 0; q < planner::kQuestions.size(); ++q)
            if (answers.points.at(q) == 0)
                throw InputError("an answer is missing: " + std::string(planner::kQuestions.at(q).key), "--points");
        return answers;
    }

    Outcome answer(const planner::Case& planned_case, const QuestionnaireOptions& options)
    {
        planner::Answers answers = parse_answers(options.points);
        answers.by = options.by;
        answers.note = options.note;
        answers.when = planner::utc_text(std::chrono::system_clock::now());
        const std::filesystem::path file = planner::decisions_file(planned_case);
        planner::Decisions decisions = planner::read_decisions(file);
        const bool again = std::ranges::any_of(
            decisions.answers, [&](const planner::Answers& earlier) { return earlier.by == answers.by; });
        decisions.answers.push_back(std::move(answers));
        planner::write_decisions(file, decisions);
        return { .document = { { "file", file.string() }, { "answers", decisions.answers.size() } },
            .text = (again ? options.by + " has answered before; the new answers count\n" : std::string()) + "wrote "
                + file.string() + "\n" };
    }

    Outcome summarise(const std::vector<planner::Case>& cases)
    {
        std::vector<std::vector<planner::Answers>> answers;
        for (const planner::Case& one : cases)
            answers.push_back(planner::read_decisions(planner::decisions_file(one)).answers);
        const auto summary = planner::summary_of(answers);
        Outcome outcome;
        outcome.document["cases"] = cases.size();
        outcome.document["questions"] = Json::array();
        outcome.text = formatted("%-20s %7s %5s %6s   %s\n", "", "answers", "mean", "range", "1 .. 5 points");
        for (std::size_t q = 0; q < summary.size(); ++q) {
            const planner::QuestionSummary& of = summary.at(q);
            const planner::Question& question = planner::kQuestions.at(q);
            Json row { { "question", question.key }, { "answers", of.answers }, { "count", of.count } };
            std::string counts;
            for (const int count : of.count)
                counts += formatted("%4d", count);
            if (of.answers > 0) {
                row["mean"] = of.mean;
                row["least"] = *of.least;
                row["most"] = *of.most;
                outcome.text += formatted("%-20s %7d %5.1f %2d - %d  %s\n", question.title, of.answers, of.mean,
                    *of.least, *of.most, counts.c_str());
            } else {
                outcome.text += formatted("%-20s %7d\n", question.title, 0);
            }
            outcome.document["questions"].push_back(std::move(row));
        }
        for (std::size_t n = 0; n < cases.size(); ++n)
            for (const planner::Answers& one : answers[n])
                if (!one.note.empty())
                    outcome.text += one.by + ", " + planner::folder_name(cases[n]) + ": " + one.note + "\n";
        return outcome;
    }

    Outcome questionnaire(const QuestionnaireOptions& options)
    {
        std::vector<planner::Case> cases;
        for (const std::string& path : options.cases)
            cases.push_back(case_at(path));
        const bool answers = !options.points.empty();
        if (answers == options.by.empty())
            throw InputError(answers ? "say who answers" : "this option needs --points", "--by");
        if (!options.note.empty() && !answers)
            throw InputError("this option needs --points", "--note");
        if ((answers || !options.sheet.empty()) && cases.size() != 1)
            throw InputError("this option needs one case, and there are " + std::to_string(cases.size()),
                answers ? "--points" : "--sheet");
        if (!options.sheet.empty()) {
            write_file_atomically(options.sheet, planner::sheet_html(cases[0], planner::holding_choice(cases[0])));
            if (!answers)
                return { .document = { { "sheet", options.sheet } }, .text = "wrote " + options.sheet + "\n" };
        }
        return answers ? answer(cases[0], options) : summarise(cases);
    }

    void add_choose_command(Commands& commands)
    {
        auto options = std::make_shared<ChooseOptions>();
        CLI::App* command = commands.app.add_subcommand(
            "choose", "Record which approach a team chose, by whom and why; without an approach: show the choices");
        command->footer(
            "The choice is written beside the case, as case.decisions.json, with the date and with what the plan "
            "said then. Reports that are written later show it.\n"
            "Example: retractor choose C/case.json intercostal_4 --by \"A. Suzuki\" --why \"widest view of the neck\"\n"
            "Example: retractor choose C/case.json");
        command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
        command->add_option("approach", options->approach, "Name of the approach that was chosen");
        command->add_option("--by", options->by, "Who chose: a person or a team, in your words");
        command->add_option("--why", options->why, "The reason, in a sentence");
        commands.on(command, [options](const Job&) { return choose(*options); });
    }

    void add_questionnaire_command(Commands& commands)
    {
        auto options = std::make_shared<QuestionnaireOptions>();
        CLI::App* command = commands.app.add_subcommand("questionnaire",
            "Six questions to surgeons on a planned field, 1 to 5 points each: record answers, print a sheet, sum up "
            "cases");
        std::string questions = "The questions (Nakao et al. 2006):\n";
        for (const planner::Question& question : planner::kQuestions)
            questions += formatted("  %-10s %s: %s\n", question.key, question.title, question.sentence);
        command->footer(questions
            + "Example: retractor questionnaire C/case.json --sheet sheet.html\n"
              "Example: retractor questionnaire C/case.json --by \"A. Suzuki\" --points "
              "shape=4,location=5,quality=3,planning=4,crisis=4,necessity=5\n"
              "Example: retractor questionnaire C1/case.json C2/case.json");
        command->add_option("cases", options->cases, "case.json; several cases are summed up")
            ->required()
            ->check(CLI::ExistingPath);
        command->add_option("--by", options->by, "With --points: who answers, in your words");
        command
            ->add_option(
                "--points", options->points, "QUESTION=POINTS, separated by commas: the answers to all six questions")
            ->delimiter(',');
        command->add_option("--note", options->note, "With --points: what else was said");
        command->add_option("--sheet", options->sheet, "Write a sheet to print and fill in, as HTML");
        commands.on(command, [options](const Job&) { return questionnaire(*options); });
    }

} // namespace

void add_decision_commands(Commands& commands)
{
    add_choose_command(commands);
    add_questionnaire_command(commands);
}

} // namespace retractor::ui::cli
