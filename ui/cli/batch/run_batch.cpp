#include "ui/cli/batch/run_batch.h"

#include "mesh/base/each_on_threads.h"
#include "mesh/base/error.h"
#include "ui/cli/batch/batch_folder.h"
#include "ui/cli/batch/job_failure.h"
#include "ui/cli/batch/job_status.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/run_program.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    /// Runs one job in a folder of its own, which is emptied first. @returns its status; running: it was cancelled
    JobStatus run_job(const BatchJob& job, const std::string& inputs, const fs::path& folder, double limit_s,
        const std::function<bool()>& stop)
    {
        fs::remove_all(folder);
        make_folder(folder);
        JobStatus status { .inputs = inputs };
        write_job_status(folder, status);
        // Each process has one thread, so that as many run at once as there are cores.
        // The program by this name is the one that runs here, also where a new version has taken its place.
        std::vector<std::string> words { "/proc/self/exe", "--json", "--threads", "1", "plan", job.case_file.string(),
            "--approach", job.approach, "--out", folder.string() };
        words.insert(words.end(), job.options.begin(), job.options.end());
        const Stopwatch watch;
        const ProgramRun run = run_program(words, std::chrono::milliseconds(std::llround(1000.0 * limit_s)), {}, stop);
        if (run.stopped)
            return status;
        status.seconds = watch.seconds();
        status.peak_bytes = run.peak_bytes;
        if (run.exit_code == 0 && !numbers_in(folder).is_null()) {
            status.state = JobStatus::State::done;
        } else {
            const JobFailure failure
                = run.exit_code == 0 ? JobFailure { "the program gave no numbers" } : failure_of(run, limit_s);
            status.state = JobStatus::State::failed;
            status.reason = failure.reason;
            status.lasting = failure.lasting;
        }
        status.disk_bytes = size_of(folder);
        write_job_status(folder, status);
        return status;
    }

    /// Runs what has no status yet, several at a time. The summary is written after every job.
    void run_rows(std::vector<BatchRow>& rows, const std::vector<std::string>& inputs, const fs::path& folder,
        const fs::path& jobs_folder, const BatchSettings& settings, const Job& job)
    {
        std::vector<std::size_t> open;
        for (std::size_t n = 0; n < rows.size(); ++n)
            if (!rows[n].status)
                open.push_back(n);
        std::mutex mutex; // of the rows and the summary
        std::size_t ended = 0;
        std::atomic<bool> broken { false }; ///< a full disk concerns all jobs
        job.report("jobs", 0.0);
        const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
        each_on_threads(open.size(), settings.processes > 0 ? settings.processes : cores, job, [&](std::size_t i) {
            BatchRow& row = rows[open[i]];
            try {
                const BatchJob one = row.job;
                const JobStatus status = run_job(one, inputs[open[i]], jobs_folder / one.name, settings.limit_s,
                    [&] { return job.cancelled() || broken.load(); });
                if (status.state == JobStatus::State::running)
                    return; // stopped
                const std::scoped_lock lock(mutex);
                row.status = status;
                read_numbers(row, jobs_folder);
                write_batch_summary(folder, jobs_folder, rows);
                job.report("jobs", static_cast<double>(++ended) / static_cast<double>(open.size()));
            } catch (...) {
                broken.store(true);
                throw;
            }
        });
    }

} // namespace

BatchRun run_batch(
    const std::vector<BatchJob>& jobs, const fs::path& folder, const BatchSettings& settings, const Job& job)
{
    const fs::path jobs_folder = folder / "jobs";
    make_folder(folder);
    const FolderLock lock(folder);
    make_folder(jobs_folder);
    const std::vector<std::string> inputs = inputs_of(jobs);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
    BatchRun run { .rows = rows_of(jobs, inputs, jobs_folder, settings.retry) };
    run.skipped = static_cast<std::size_t>(
        std::ranges::count_if(run.rows, [](const BatchRow& row) { return row.status.has_value(); }));
    const Stopwatch watch;
    run_rows(run.rows, inputs, folder, jobs_folder, settings, job);
    write_batch_summary(folder, jobs_folder, run.rows);
    run.seconds = watch.seconds();
    return run;
}

BatchRow run_batch_job(const std::vector<BatchJob>& jobs, const std::string& name, const fs::path& folder,
    const BatchSettings& settings, const Job& job)
{
    const auto named = std::ranges::find(jobs, name, &BatchJob::name);
    if (named == jobs.end())
        throw InputError("the sweep has no job with this name", name);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
    const fs::path jobs_folder = folder / "jobs";
    const std::string inputs = inputs_of({ *named }).front();
    BatchRow row { .job = *named, .status = read_job_status(jobs_folder / name) };
    const bool again = row.status && row.status->state == JobStatus::State::failed && settings.retry;
    if (!row.status || again || !is_end(*row.status, inputs))
        row.status = run_job(*named, inputs, jobs_folder / name, settings.limit_s, [&] { return job.cancelled(); });
    if (row.status->state == JobStatus::State::running)
        row.status.reset();
    read_numbers(row, jobs_folder);
    return row;
}

} // namespace retractor::ui::cli
