#include "ui/cli/commands.h"

#include "datasets/tables/csv_reader.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/metric_table.h"
#include "planner/uncertainty/stiffness_samples.h"
#include "ui/cli/batch/run_batch.h"
#include "ui/cli/batch/sample_plans.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct SensitivityOptions {
        std::string case_file, out;
        int samples = 32;
        unsigned seed = 0;
        bool draft = false;
        BatchSettings settings;
        std::vector<std::size_t> plans; ///< a process plans only these, and writes no summary
    };

    /// Measures of the table in the text; the file has all.
    constexpr std::array kShown { "seen_best_eye", "opening_area_mm2", "opening_width_mm", "hook_force_N" };

    /// The jobs, sample by sample; the first is the case as it is.
    std::vector<SamplePlan> plans_of(const planner::Case& planned_case,
        const std::vector<planner::StiffnessFactors>& samples, const SensitivityOptions& options)
    {
        std::vector<SamplePlan> plans;
        for (std::size_t n = 0; n < samples.size(); ++n)
            for (const planner::Approach& approach : planned_case.approaches) {
                const std::string variant = n == 0 ? "as_planned" : formatted("sample_%03zu", n);
                BatchJob job { .name = variant + "-" + approach.name,
                    .case_file = fs::absolute(planned_case.file()),
                    .approach = approach.name,
                    .variant = variant,
                    .options = {} };
                if (options.draft)
                    job.options.emplace_back("--draft");
                if (!samples[n].empty())
                    job.options.insert(job.options.end(), { "--stiffness", planner::stiffness_text(samples[n]) });
                plans.push_back({ .job = std::move(job), .factors = samples[n] });
            }
        return plans;
    }

    BatchRun run_plans(
        const std::vector<SamplePlan>& plans, const fs::path& folder, const SensitivityOptions& options, const Job& job)
    {
        const auto words = [&](std::span<const std::size_t> chosen) {
            // The program by this name is the one that runs here, also where a new version has taken its place.
            std::vector<std::string> all { "/proc/self/exe", "--json", "--threads", "1", "sensitivity",
                fs::absolute(options.case_file).string(), "--out", folder.string(), "--samples",
                std::to_string(options.samples), "--seed", std::to_string(options.seed) };
            if (options.draft)
                all.push_back("--draft");
            all.push_back("--plans");
            for (const std::size_t plan : chosen)
                all.push_back(std::to_string(plan));
            return all;
        };
        return run_sample_plans(plans, folder, options.settings, words, job);
    }

    /// What a process does for the command that started it.
    Outcome plan_chosen(
        const std::vector<SamplePlan>& plans, const fs::path& folder, const SensitivityOptions& options, const Job& job)
    {
        std::vector<SamplePlan> chosen;
        for (const std::size_t plan : options.plans) {
            if (plan >= plans.size())
                throw InputError("there is no plan with this number", "--plans " + std::to_string(plan));
            chosen.push_back(plans[plan]);
        }
        plan_samples_here(chosen, options.draft, folder, job);
        refuse_if_cancelled(job);
        return {};
    }

    std::optional<double> number_in(const Json& numbers, const std::string& key)
    {
        if (!numbers.is_object() || !numbers.contains(key) || !numbers[key].is_number())
            return std::nullopt;
        return numbers[key].get<double>();
    }

    bool is_done(const BatchRow& row) { return row.status && row.status->state == JobStatus::State::done; }

    /// The numbers of one measure of one approach over the samples, without the plan with the case's own values.
    std::vector<double> values_of(
        const std::vector<BatchRow>& rows, std::size_t approach, std::size_t approaches, const std::string& key)
    {
        std::vector<double> values;
        for (std::size_t r = approaches + approach; r < rows.size(); r += approaches)
            if (is_done(rows[r]))
                if (const std::optional<double> value = number_in(rows[r].numbers, key))
                    values.push_back(*value);
        return values;
    }

    Json spread_document(const planner::Spread& spread)
    {
        return { { "median", spread.median }, { "p5", spread.low }, { "p95", spread.high },
            { "samples", spread.count } };
    }

    std::string samples_csv(const std::vector<BatchRow>& rows, const std::vector<planner::StiffnessFactors>& samples,
        std::size_t approaches, const std::vector<std::string>& names)
    {
        std::string csv = "sample,approach,state,score";
        for (const planner::MetricField& metric : planner::metric_fields())
            csv += std::string(",") + metric.key;
        for (const std::string& name : names)
            csv += "," + datasets::csv_quoted("stiffness of " + name);
        csv += "\n";
        for (std::size_t r = 0; r < rows.size(); ++r) {
            const BatchRow& row = rows[r];
            csv += row.job.variant + "," + datasets::csv_quoted(row.job.approach) + ","
                + (row.status ? to_string(row.status->state) : "not begun");
            const auto cell = [&](const std::string& key) {
                const std::optional<double> value = is_done(row) ? number_in(row.numbers, key) : std::nullopt;
                csv += "," + (value ? formatted("%.9g", *value) : std::string());
            };
            cell("score");
            for (const planner::MetricField& metric : planner::metric_fields())
                cell(metric.key);
            const planner::StiffnessFactors& factors = samples[r / approaches];
            for (const std::string& name : names)
                csv += formatted(",%.6g", factors.contains(name) ? factors.find(name)->second : 1.0);
            csv += "\n";
        }
        return csv;
    }

    planner::Survival survival_in(const std::vector<BatchRow>& rows, std::size_t approaches)
    {
        std::vector<std::vector<std::optional<double>>> scores(rows.size() / approaches);
        for (std::size_t r = 0; r < rows.size(); ++r)
            scores[r / approaches].push_back(is_done(rows[r]) ? number_in(rows[r].numbers, "score") : std::nullopt);
        return planner::survival_of(scores.front(), std::span(scores).subspan(1));
    }

    /// What came of the samples, as text and document.
    Outcome outcome_of(const BatchRun& run, const planner::Case& planned_case, const SensitivityOptions& options)
    {
        const std::size_t approaches = planned_case.approaches.size();
        Outcome outcome;
        outcome.document["samples"] = options.samples;
        outcome.document["seed"] = options.seed;
        outcome.document["draft"] = options.draft;
        outcome.document["approaches"] = Json::array();
        std::size_t failed = 0, missing = 0; // missing: the same command plans them
        std::string reasons;
        for (const BatchRow& row : run.rows) {
            const bool failed_by_chance
                = row.status && row.status->state == JobStatus::State::failed && !row.status->lasting;
            missing += !row.status || failed_by_chance ? 1 : 0;
            if (!row.status || is_done(row))
                continue;
            ++failed;
            constexpr std::size_t kMostReasons = 5;
            if (failed <= kMostReasons)
                reasons += "no numbers: " + row.job.name + ": " + row.status->reason + "\n";
        }
        for (std::size_t a = 0; a < approaches; ++a) {
            Json measures = Json::object();
            outcome.text += planner::spoken_name(planned_case.approaches[a]) + "\n";
            const auto put = [&](const std::string& key, const auto& text, const char* caption, bool shown) {
                const std::optional<planner::Spread> spread
                    = planner::spread_of(values_of(run.rows, a, approaches, key));
                if (!spread)
                    return;
                measures[key] = spread_document(*spread);
                const std::optional<double> own
                    = is_done(run.rows[a]) ? number_in(run.rows[a].numbers, key) : std::nullopt;
                if (own)
                    measures[key]["as_planned"] = *own;
                if (shown)
                    outcome.text += formatted("  %-28s %9s, nine of ten between %s and %s (%zu %s); as planned %s\n",
                        caption, text(spread->median).c_str(), text(spread->low).c_str(), text(spread->high).c_str(),
                        spread->count, spread->count == 1 ? "sample" : "samples",
                        own ? text(*own).c_str() : "no numbers");
            };
            for (const planner::MetricField& metric : planner::metric_fields())
                put(
                    metric.key, [&](double value) { return planner::metric_text(metric, value); }, metric.caption,
                    std::ranges::find(kShown, std::string_view(metric.key)) != kShown.end());
            put(
                "score", [](double value) { return formatted("%.0f", value); }, "Score, points of 100", true);
            outcome.document["approaches"].push_back(
                { { "name", planned_case.approaches[a].name }, { "measures", std::move(measures) } });
        }
        const planner::Survival survival = survival_in(run.rows, approaches);
        outcome.document["ranking"] = { { "samples", survival.samples }, { "same_leader", survival.same_leader },
            { "same_order", survival.same_order } };
        if (approaches > 1)
            outcome.text += survival.samples == 0
                ? std::string("The order of the approaches is not known: no sample, or not the case as it is, has a "
                              "score of every approach.\n")
                : formatted(
                    "The approach with the highest score stays the same in %zu of %zu samples, the whole order in "
                    "%zu.\n",
                    survival.same_leader, survival.samples, survival.same_order);
        outcome.document["failed"] = failed;
        outcome.document["not_begun"] = missing;
        outcome.document["seconds"] = run.seconds;
        outcome.text += reasons
            + (failed > 0
                    ? formatted("%zu of %zu plans have no numbers that can be used; they are left out above, which "
                                "may make the intervals too narrow\n",
                        failed, run.rows.size())
                    : std::string())
            + (missing > 0 ? formatted("%zu plans are missing: the same command goes on\n", missing) : std::string())
            + formatted("%.0f s, %zu plans of earlier runs\n", run.seconds, run.skipped);
        outcome.exit_code = missing > 0 || failed == run.rows.size() ? 1 : 0;
        return outcome;
    }

    Outcome sensitivity(const SensitivityOptions& options, const Job& job)
    {
        const planner::Case planned_case = open_case(options.case_file);
        if (planned_case.approaches.empty())
            throw InputError("the case has no approach yet: add one with retractor approach add",
                options.case_file + "#/approaches");
        std::vector<planner::StiffnessFactors> samples
            = planner::sample_stiffness(planned_case, options.samples, options.seed);
        planner::check_stiffness_factors(planned_case, samples.front()); // refuses what no plan would take
        samples.insert(samples.begin(), planner::StiffnessFactors {});
        const fs::path folder = fs::absolute(options.out);
        const std::vector<SamplePlan> plans = plans_of(planned_case, samples, options);
        if (!options.plans.empty())
            return plan_chosen(plans, folder, options, job);
        const BatchRun run = run_plans(plans, folder, options, job);
        Outcome outcome = outcome_of(run, planned_case, options);
        write_file_atomically(folder / "sensitivity.json", outcome.document.dump(2) + "\n");
        write_file_atomically(folder / "sensitivity.csv",
            samples_csv(run.rows, samples, planned_case.approaches.size(), planner::stiffness_names(planned_case)));
        outcome.text += "wrote " + (folder / "sensitivity.json").string() + ", sensitivity.csv and summary.html\n";
        return outcome;
    }

} // namespace

void add_sensitivity_command(Commands& commands)
{
    auto options = std::make_shared<SensitivityOptions>();
    CLI::App* command = commands.app.add_subcommand("sensitivity",
        "Plan a case with many values of tissue stiffness: how far the numbers and the ranking depend on what nobody "
        "has "
        "measured");
    command->footer("The stiffness of every tissue, of the joints between ribs and spine and of the bed of the "
                    "shoulder girdle varies "
                    "over its published range (Latin hypercube). Each plan begins where the wound is open with the "
                    "case's own values.\n"
                    "Example: retractor sensitivity C/case.json --out S    (the same again goes on after a break)\n"
                    "Example: retractor sensitivity C/case.json --out S --samples 64 --seed 1");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command
        ->add_option(
            "--out", options->out, "Folder for sensitivity.json, sensitivity.csv, summary.html and one folder per plan")
        ->required();
    command->add_option("--samples", options->samples, "Number of samples")
        ->check(in_range(1, 10000))
        ->capture_default_str();
    command->add_option("--seed", options->seed, "Other samples for each number")
        ->check(in_range(0.0, 1e6))
        ->capture_default_str();
    command->add_flag("--draft", options->draft,
        "Drafts: several times faster, with forces that are up to three times too large; some fail near the "
        "wound");
    command->add_option("--jobs", options->settings.processes, "Number of plans at a time (default: one per core)")
        ->check(CLI::Range(1, 256));
    command->add_flag("--retry", options->settings.retry, "Also do failed plans again");
    command->add_option("--plans", options->plans)->group({}); // not shown: for the processes of this command
    commands.on(command, [options](const Job& job) { return sensitivity(*options, job); });
}

} // namespace retractor::ui::cli
