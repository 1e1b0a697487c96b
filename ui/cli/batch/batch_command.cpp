#include "ui/cli/commands.h"

#include "mesh/base/text_format.h"
#include "ui/cli/batch/run_batch.h"
#include "ui/cli/batch/slurm_batch.h"
#include "ui/cli/batch/sweep.h"
#include "ui/cli/framework/number_range.h"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct BatchOptions {
        std::string sweep, out;
        BatchSettings settings;
        bool slurm = false;
        std::string slurm_args; ///< options of sbatch, with blanks between them
        std::optional<std::string> one_job {}; ///< not set: all
    };

    Outcome outcome_of(const std::vector<BatchRow>& rows, std::size_t skipped, double seconds)
    {
        Outcome outcome { .document = { { "jobs", Json::array() } }, .text = {} };
        std::map<std::string, std::size_t> counts { { "done", 0 }, { "failed", 0 }, { "not begun", 0 } };
        double job_seconds = 0.0;
        std::string failed;
        for (const BatchRow& row : rows) {
            const std::string state = row.status ? to_string(row.status->state) : "not begun";
            ++counts[state];
            Json json { { "name", row.job.name }, { "state", state } };
            if (row.status) {
                job_seconds += row.status->seconds;
                json["seconds"] = row.status->seconds;
                if (row.status->state == JobStatus::State::failed) {
                    json["reason"] = row.status->reason;
                    failed += "failed: " + row.job.name + ": " + row.status->reason + "\n";
                }
            }
            outcome.document["jobs"].push_back(std::move(json));
        }
        const std::size_t ended = rows.size() - counts["not begun"];
        outcome.document["counts"] = counts;
        outcome.document["skipped"] = skipped;
        outcome.document["seconds"] = seconds;
        outcome.text = formatted("%zu jobs: %zu done, %zu failed, %zu not begun; %zu of them are of earlier runs\n",
                           rows.size(), counts["done"], counts["failed"], counts["not begun"], skipped)
            + failed
            + (ended > 0 ? formatted(
                   "%.0f s, %.1f s of one process per job\n", seconds, job_seconds / static_cast<double>(ended))
                         : std::string());
        if (counts["not begun"] > 0)
            outcome.text += "interrupted: the same command goes on\n";
        outcome.exit_code = counts["done"] == rows.size() ? 0 : 1;
        return outcome;
    }

    Outcome batch(const BatchOptions& options, const Job& job)
    {
        const fs::path folder = fs::absolute(options.out), sweep = fs::absolute(options.sweep);
        const std::vector<BatchJob> jobs = read_sweep(sweep);
        if (options.one_job) {
            const Stopwatch watch;
            const std::vector<BatchRow> rows { run_batch_job(jobs, *options.one_job, folder, options.settings, job) };
            return outcome_of(rows, 0, watch.seconds());
        }
        std::istringstream words(options.slurm_args);
        const std::vector<std::string> sbatch { std::istream_iterator<std::string>(words), {} };
        const BatchRun run = options.slurm ? run_slurm_batch(jobs, sweep, folder, options.settings, sbatch, job)
                                           : run_batch(jobs, folder, options.settings, job);
        Outcome outcome = outcome_of(run.rows, run.skipped, run.seconds);
        if (options.slurm && job.cancelled())
            outcome.text += "the jobs in the cluster's queue go on\n";
        outcome.text += "wrote " + (folder / "summary.html").string() + " and summary.csv\n";
        return outcome;
    }

} // namespace

void add_batch_command(Commands& commands)
{
    auto options = std::make_shared<BatchOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "batch", "Plan many cases, approaches and variants, several at a time; go on where an earlier run ended");
    command->footer(
        "A sweep is a JSON file: {\"cases\": [\"a/case.json\", \"b/case.json\"], \"approaches\": [\"median\"], "
        "\"variants\": {\"draft\": [\"--draft\"]}, \"render\": true}\n"
        "cases are found from the sweep's folder; approaches: all of a case unless given; variants: options of "
        "retractor plan; render: pictures and a report of each job unless false\n"
        "Example: retractor batch SWEEP.json --out B    (the same again goes on after a break)");
    command->add_option("sweep", options->sweep, "The sweep's JSON file")->required()->check(CLI::ExistingFile);
    command
        ->add_option("--out", options->out,
            "Folder for summary.html, summary.csv and one folder per job; jobs that it holds already are not done "
            "again")
        ->required();
    command->add_option("--jobs", options->settings.processes, "Number of jobs at a time (default: one per core)")
        ->check(CLI::Range(1, 256));
    command->add_option("--limit", options->settings.limit_s, "Time limit of one job, s")
        ->check(in_range(1.0, 1e6))
        ->capture_default_str();
    command->add_flag("--retry", options->settings.retry, "Also do failed jobs again");
    CLI::Option* slurm = command->add_flag("--slurm", options->slurm,
        "Let a Slurm cluster do the jobs, as an array in its queue, and follow them; --jobs is then the number at a "
        "time that is asked for (default: as many as the cluster gives)");
    command
        ->add_option("--slurm-args", options->slurm_args,
            "Further options of sbatch, with blanks between them: \"--partition=night --mem=4G\"")
        ->needs(slurm);
    command
        ->add_option("--job", options->one_job,
            "Do this one job of the sweep, and leave the summaries as they are; the tasks of a cluster do this")
        ->excludes(slurm);
    commands.on(command, [options](const Job& job) { return batch(*options, job); });
}

} // namespace retractor::ui::cli
