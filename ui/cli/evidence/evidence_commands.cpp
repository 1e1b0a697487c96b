#include "ui/cli/commands.h"

#include "datasets/tables/csv_reader.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/evidence/association_rules.h"
#include "planner/evidence/complication_rule.h"
#include "planner/evidence/hospital_records.h"
#include "planner/evidence/person_items.h"
#include "planner/evidence/published_rules.h"
#include "planner/evidence/record_generator.h"
#include "ui/cli/evidence/rule_plot.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/out_folder.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    Json bad_rows_document(const datasets::BadRows& bad)
    {
        Json document { { "count", bad.count }, { "first", Json::array() } };
        for (const datasets::BadRow& row : bad.first)
            document["first"].push_back({ { "file", row.file }, { "line", row.line }, { "reason", row.reason } });
        return document;
    }

    std::string skipped_rows_text(const datasets::BadRows& bad)
    {
        return bad.count == 0 ? std::string()
                              : std::to_string(bad.count) + " wrong rows were left out:\n" + bad_rows_text(bad);
    }

    // ---- complications ---------------------------------------------------------------------------------------------

    struct ComplicationOptions {
        std::string data, rule = "shock-accounting", database;
        bool skip_bad = false;
    };

    std::string published_names()
    {
        std::vector<std::string> names;
        for (const planner::PublishedRule& published : planner::published_rules())
            names.emplace_back(published.name);
        return joined(names);
    }

    std::optional<std::string> published_rule(const std::string& name)
    {
        for (const planner::PublishedRule& published : planner::published_rules())
            if (published.name == name)
                return std::string(published.sql);
        return std::nullopt;
    }

    /// The text of a published rule, or of a file.
    std::string rule_text(const std::string& rule)
    {
        if (const std::optional<std::string> published = published_rule(rule))
            return *published;
        std::ifstream in(rule, std::ios::binary);
        if (!in || !fs::is_regular_file(rule))
            throw InputError("there is no such file, and no such rule; the published rules are " + published_names(),
                "--rule " + rule);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    /// "3 of 5 (60.0 %, 95 % interval 14.7 to 94.7 %)".
    std::string share_text(std::size_t successes, std::size_t trials, const planner::ShareInterval& interval)
    {
        if (trials == 0)
            return "none";
        return formatted("%zu of %zu (%.1f %%, 95 %% interval %.1f to %.1f %%)", successes, trials,
            100.0 * static_cast<double>(successes) / static_cast<double>(trials), 100.0 * interval.low,
            100.0 * interval.high);
    }

    Json share_document(std::size_t successes, std::size_t trials, const planner::ShareInterval& interval)
    {
        Json document { { "successes", successes }, { "trials", trials } };
        document["share"] = trials > 0 ? Json(static_cast<double>(successes) / static_cast<double>(trials)) : Json();
        document["interval_95"] = { interval.low, interval.high };
        return document;
    }

    void tell_judgement(const planner::RuleJudgement& judgement, Outcome& outcome)
    {
        const std::size_t judged = judgement.right + judgement.wrong,
                          complications = judgement.right + judgement.missed;
        outcome.document["precision"] = share_document(judgement.right, judged, judgement.precision);
        outcome.document["recall"] = share_document(judgement.right, complications, judgement.recall);
        outcome.document["unknown"] = judgement.unknown;
        outcome.text += "precision: " + share_text(judgement.right, judged, judgement.precision)
            + "\nrecall: " + share_text(judgement.right, complications, judgement.recall) + "\n";
        if (judgement.unknown > 0)
            outcome.text += std::to_string(judgement.unknown) + " found examinations are not in truth.csv\n";
    }

    Outcome outcome_of(const planner::RuleResult& result, const planner::LoadedRecords& loaded)
    {
        Outcome outcome;
        outcome.document["examinations_with_contrast"] = result.examinations;
        outcome.document["found_examinations"] = result.found.size();
        outcome.document["found_patients"] = result.patients;
        outcome.document["found"] = Json::array();
        outcome.text = formatted("%zu examinations with contrast medium, %zu found, of %zu patients\n",
            result.examinations, result.found.size(), result.patients);
        for (const planner::FoundExamination& found : result.found) {
            Json row { { "examination", found.examination }, { "patient", found.patient }, { "date", found.date } };
            row["complication"] = found.complication ? Json(*found.complication) : Json();
            outcome.document["found"].push_back(row);
            outcome.text += "  " + found.date + "  " + found.examination + "  " + found.patient
                + (!found.complication        ? ""
                        : *found.complication ? "  a complication"
                                              : "  no complication")
                + "\n";
        }
        outcome.text += "month    examinations  found\n";
        outcome.document["months"] = Json::array();
        for (const auto& [month, count] : result.months) {
            outcome.document["months"].push_back(
                { { "month", month }, { "examinations", count.examinations }, { "found", count.found } });
            outcome.text += formatted("%s  %12zu  %5zu\n", month.c_str(), count.examinations, count.found);
        }
        if (result.judgement)
            tell_judgement(*result.judgement, outcome);
        outcome.document["rows"] = loaded.rows;
        outcome.document["bad_rows"] = bad_rows_document(loaded.bad);
        outcome.text += skipped_rows_text(loaded.bad);
        return outcome;
    }

    Outcome find_complications(const ComplicationOptions& options, const Job& job)
    {
        const std::string rule = rule_text(options.rule);
        Outcome outcome;
        const auto find_in = [&](const fs::path& file) {
            const datasets::SqliteDatabase database = datasets::open_sqlite(file, "the database cannot be used");
            const planner::LoadedRecords loaded = planner::load_hospital_records(options.data, database,
                options.skip_bad ? planner::BadRowPolicy::skip : planner::BadRowPolicy::refuse, job);
            refuse_if_cancelled(job);
            outcome = outcome_of(planner::apply_rule(database, rule, loaded.has_truth, job), loaded);
            refuse_if_cancelled(job);
        };
        if (options.database.empty())
            find_in(":memory:");
        else
            write_file_atomically(options.database, find_in);
        return outcome;
    }

    void add_complications(CLI::App& evidence, Commands& commands)
    {
        auto options = std::make_shared<ComplicationOptions>();
        CLI::App* command = evidence.add_subcommand(
            "complications", "Find examinations with a complication in hospital records, by a rule");
        command->footer("Example: retractor evidence complications DATA --rule shock-orders --db records.sqlite");
        command
            ->add_option("data", options->data,
                "Folder with examinations.csv, administrations.csv, oxygen.csv, surgery.csv and, where the truth is "
                "known, truth.csv")
            ->required()
            ->check(CLI::ExistingDirectory);
        command
            ->add_option("--rule", options->rule,
                "shock-accounting, shock-orders, or a file with one SELECT statement that gives a column examination")
            ->capture_default_str();
        command->add_option("--db", options->database, "Keep the records as this SQLite file (default: in memory)");
        command->add_flag("--skip-bad", options->skip_bad, "Leave wrong rows out, and list them");
        commands.on(command, [options](const Job& job) { return find_complications(*options, job); });
    }

    void add_show_rule(CLI::App& evidence, Commands& commands)
    {
        auto rule = std::make_shared<std::string>();
        CLI::App* command
            = evidence.add_subcommand("show-rule", "Print a published rule, to be changed and used again");
        command->footer("Example: retractor evidence show-rule shock-orders > rule.sql");
        command->add_option("rule", *rule, "shock-accounting or shock-orders")->required();
        commands.on(command, [rule](const Job&) {
            const std::optional<std::string> sql = published_rule(*rule);
            if (!sql)
                throw InputError("the published rules are " + published_names(), "show-rule " + *rule);
            Outcome outcome;
            outcome.text = *sql;
            outcome.document = { { "rule", *rule }, { "sql", outcome.text } };
            return outcome;
        });
    }

    // ---- association rules -----------------------------------------------------------------------------------------

    struct RuleOptions {
        std::string data, out;
        planner::PersonTable described;
        planner::RuleThresholds thresholds;
    };

    std::string left_name(const planner::ItemTable& table, const planner::AssociationRule& rule)
    {
        std::vector<std::string> names;
        for (const std::size_t item : rule.left)
            names.push_back(table.items[item].name);
        return joined(names);
    }

    Json rules_document(const planner::ItemTable& table, const planner::FoundRules& found)
    {
        Json rules = Json::array();
        for (const planner::AssociationRule& rule : found.rules) {
            Json left = Json::array();
            for (const std::size_t item : rule.left)
                left.push_back(table.items[item].name);
            rules.push_back({ { "left", left }, { "right", table.items[rule.right].name }, { "n_left", rule.n_left },
                { "n_right", rule.n_right }, { "n_both", rule.n_both }, { "left_support", rule.left_support },
                { "right_support", rule.right_support }, { "support", rule.support }, { "confidence", rule.confidence },
                { "lift", rule.lift }, { "z", rule.z }, { "p", rule.p }, { "p_adjusted", rule.p_adjusted } });
        }
        return rules;
    }

    std::string rules_csv(const planner::ItemTable& table, const planner::FoundRules& found)
    {
        std::string csv = "left,right,left_support,right_support,support,confidence,lift,z,p,p_adjusted\n";
        for (const planner::AssociationRule& rule : found.rules)
            csv += datasets::csv_quoted(left_name(table, rule)) + ","
                + datasets::csv_quoted(table.items[rule.right].name)
                + formatted(",%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", rule.left_support, rule.right_support,
                    rule.support, rule.confidence, rule.lift, rule.z, rule.p, rule.p_adjusted);
        return csv;
    }

    std::string rules_table(const planner::ItemTable& table, const planner::FoundRules& found)
    {
        constexpr std::size_t kListed = 50;
        std::string text = "      support  confidence   lift       z       p  adjusted  rule\n";
        for (std::size_t n = 0; n < std::min(found.rules.size(), kListed); ++n) {
            const planner::AssociationRule& rule = found.rules[n];
            text += formatted("%4zu  %7.4f  %10.4f  %5.3f  %6.3f  %6.4f  %8.4f  ", n + 1, rule.support, rule.confidence,
                        rule.lift, rule.z, rule.p, rule.p_adjusted)
                + left_name(table, rule) + " -> " + table.items[rule.right].name + "\n";
        }
        if (found.rules.size() > kListed)
            text += "and " + std::to_string(found.rules.size() - kListed) + " others (--out writes all)\n";
        return text;
    }

    Outcome find_association_rules(const RuleOptions& options, const Job& job)
    {
        const planner::PersonItems items = planner::read_person_items(options.data, options.described, job);
        refuse_if_cancelled(job);
        const planner::FoundRules found = planner::find_rules(items.table, options.thresholds, job);
        refuse_if_cancelled(job);
        Outcome outcome;
        outcome.document = { { "records", items.records }, { "persons", items.table.persons },
            { "items", items.table.items.size() }, { "tested", found.tested },
            { "rules", rules_document(items.table, found) }, { "bad_rows", bad_rows_document(items.bad) } };
        outcome.text
            = formatted("%zu records of %zu persons, %zu items; %zu rules of %zu that were tested\n", items.records,
                  items.table.persons, items.table.items.size(), found.rules.size(), found.tested)
            + rules_table(items.table, found)
            + "A rule is a hypothesis, not a cause. p is adjusted for the rules that were tested (Benjamini, "
              "Hochberg).\n"
            + skipped_rows_text(items.bad);
        if (!options.out.empty()) {
            const fs::path folder = options.out;
            OutFolder made(folder);
            write_file_atomically(folder / "rules.csv", rules_csv(items.table, found));
            write_file_atomically(folder / "rules.json", outcome.document.dump(2) + "\n");
            write_file_atomically(folder / "rules.svg", rule_plot_svg(found.rules, options.thresholds));
            outcome.text += "written: rules.csv, rules.json and rules.svg in " + folder.string() + "\n";
        }
        return outcome;
    }

    void add_rules(CLI::App& evidence, Commands& commands)
    {
        auto options = std::make_shared<RuleOptions>();
        CLI::App* command = evidence.add_subcommand(
            "rules", "Find association rules between exposures and findings of persons: who has this, has that");
        command->footer("Example: retractor evidence rules records.csv --exposures A,B,C --out D\n"
                        "Example: retractor evidence rules findings.csv --most-left 2 --support 0.01");
        command->add_option("data", options->data, "CSV file: person, year, exposures (numbers), findings (0 or 1)")
            ->required()
            ->check(CLI::ExistingFile);
        command
            ->add_option("--exposures", options->described.exposures,
                "Columns with numbers, separated by commas; they become one item, high or low by thirds of the persons")
            ->delimiter(',');
        command->add_flag(
            "--separate", options->described.separate, "Each exposure is an item of its own as well, high or low");
        command->add_option("--person", options->described.person_column, "Column of the person")
            ->capture_default_str();
        command
            ->add_option("--year", options->described.year_column,
                "Column of the year; the earliest record of each person counts")
            ->capture_default_str();
        command->add_option("--support", options->thresholds.support, "Least support")
            ->check(in_range(0.0, 1.0))
            ->capture_default_str();
        command->add_option("--confidence", options->thresholds.confidence, "Least confidence")
            ->check(in_range(0.0, 1.0))
            ->capture_default_str();
        command->add_option("--lift", options->thresholds.lift, "Least lift")
            ->check(in_range(0.0, 1e9))
            ->capture_default_str();
        command->add_option("--most-left", options->thresholds.most_left, "Largest number of items on the left side")
            ->check(in_range(1, 8))
            ->capture_default_str();
        command->add_flag("--skip-bad", options->described.skip_bad, "Leave wrong rows out, and list them");
        command->add_option("--out", options->out, "Folder for rules.csv, rules.json and rules.svg");
        commands.on(command, [options](const Job& job) { return find_association_rules(*options, job); });
    }

    // ---- made-up records -------------------------------------------------------------------------------------------

    struct GenerateOptions {
        std::string kind, out;
        std::size_t examinations = planner::kPublishedExaminations, persons = 1'000'000, findings = 50;
        double share = 0.2;
        unsigned seed = 1;
    };

    Outcome generate(const GenerateOptions& options, const Job& job)
    {
        if (options.kind == "complications")
            planner::write_complication_records(options.out, options.examinations, options.seed);
        else if (options.kind == "exposures")
            planner::write_exposure_records(options.out, options.seed);
        else
            planner::write_random_findings(
                options.out, options.persons, options.findings, options.share, options.seed, job);
        refuse_if_cancelled(job);
        return { .document = { { "written", options.out } }, .text = options.out + ": made up, nobody's data\n" };
    }

    void add_generate(CLI::App& evidence, Commands& commands)
    {
        auto options = std::make_shared<GenerateOptions>();
        CLI::App* command
            = evidence.add_subcommand("generate", "Make up records with published counts, or many random ones");
        command->footer("Example: retractor evidence generate complications --out DATA\n"
                        "Example: retractor evidence generate exposures --out records.csv");
        command
            ->add_option("kind", options->kind,
                "complications (a folder), exposures (the 381 persons of the published rules), or findings (random)")
            ->required()
            ->check(CLI::IsMember({ "complications", "exposures", "findings" }));
        command->add_option("--out", options->out, "Folder or CSV file")->required();
        command->add_option("--examinations", options->examinations, "With contrast medium, of complications")
            ->check(in_range(5, 100000000))
            ->capture_default_str();
        command->add_option("--persons", options->persons, "Of findings")
            ->check(in_range(1, 100000000))
            ->capture_default_str();
        command->add_option("--findings", options->findings, "Number of findings")
            ->check(in_range(1, 10000))
            ->capture_default_str();
        command->add_option("--share", options->share, "Share of the persons with each finding")
            ->check(in_range(0.0, 1.0))
            ->capture_default_str();
        command->add_option("--seed", options->seed, "Seed of the random numbers")->capture_default_str();
        commands.on(command, [options](const Job& job) { return generate(*options, job); });
    }

} // namespace

void add_evidence_commands(Commands& commands)
{
    CLI::App* evidence = commands.app.add_subcommand(
        "evidence", "What happened to earlier patients: complications in hospital records, association rules");
    evidence->footer("Example: retractor evidence complications DATA --rule shock-accounting");
    evidence->require_subcommand(1);
    add_complications(*evidence, commands);
    add_show_rule(*evidence, commands);
    add_rules(*evidence, commands);
    add_generate(*evidence, commands);
}

} // namespace retractor::ui::cli
