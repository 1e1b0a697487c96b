#include "ui/cli/batch/sample_plans.h"

#include "mesh/base/each_on_threads.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/draft_case.h"
#include "planner/plan/plan.h"
#include "ui/cli/batch/batch_folder.h"
#include "ui/cli/batch/job_failure.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/run_program.h"
#include "ui/cli/plan/field_table.h"
#include "ui/results/field_files.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    /// Fewer samples are not worth an opening of their own to begin at.
    constexpr std::size_t kLeastOfProcess = 4;

    /// Drafts in a part of the wall, or not from one opening, have other numbers; earlier versions made them.
    std::vector<std::string> inputs_of_plans(const std::vector<BatchJob>& jobs)
    {
        std::vector<std::string> inputs = inputs_of(jobs);
        for (std::string& text : inputs)
            text += " from the opening of the case in the region that was found";
        return inputs;
    }

    /// The plans that have no status, in parts of one approach: twice as many parts as processes, so that none waits
    /// long for the others.
    std::vector<std::vector<std::size_t>> parts_of(const std::vector<BatchRow>& rows, std::size_t processes)
    {
        std::map<std::string, std::vector<std::size_t>> of_approach;
        for (std::size_t n = 0; n < rows.size(); ++n)
            if (!rows[n].status)
                of_approach[rows[n].job.approach].push_back(n);
        std::vector<std::vector<std::size_t>> parts;
        for (const auto& [name, open] : of_approach) {
            const std::size_t wanted = (2 * processes + of_approach.size() - 1) / of_approach.size(),
                              most = std::max<std::size_t>(open.size() / kLeastOfProcess, 1),
                              count = std::min(wanted, most);
            for (std::size_t p = 0; p < count; ++p)
                parts.emplace_back(open.begin() + static_cast<std::ptrdiff_t>(p * open.size() / count),
                    open.begin() + static_cast<std::ptrdiff_t>((p + 1) * open.size() / count));
        }
        return parts;
    }

    /// The rows while their processes run.
    class Rows {
    public:
        Rows(BatchRun& run, std::vector<std::string> inputs, const fs::path& folder, const Job& job)
            : run_(run)
            , inputs_(std::move(inputs))
            , folder_(folder)
            , job_(job)
            , open_(run.rows.size() - run.skipped)
        {
        }

        /// Takes over what a process has written by now. @returns the rows of the part that have no end yet
        std::vector<std::size_t> take_ended(std::span<const std::size_t> part)
        {
            const std::scoped_lock lock(mutex_);
            std::vector<std::size_t> left;
            const std::size_t before = ended_;
            for (const std::size_t n : part) {
                BatchRow& row = run_.rows[n];
                if (!row.status) {
                    std::optional<JobStatus> status = read_job_status(jobs_folder() / row.job.name);
                    if (!status || status->state == JobStatus::State::running) {
                        left.push_back(n);
                        continue;
                    }
                    take(row, *std::move(status));
                }
            }
            if (ended_ > before)
                report();
            return left;
        }

        /// Writes that a plan has no answer.
        void fail(std::size_t n, const JobFailure& failure)
        {
            const std::scoped_lock lock(mutex_);
            BatchRow& row = run_.rows[n];
            JobStatus status { .state = JobStatus::State::failed,
                .inputs = inputs_[n],
                .reason = failure.reason,
                .lasting = failure.lasting };
            make_folder(jobs_folder() / row.job.name);
            write_job_status(jobs_folder() / row.job.name, status);
            take(row, std::move(status));
            report();
        }

    private:
        fs::path jobs_folder() const { return folder_ / "jobs"; }

        void take(BatchRow& row, JobStatus status)
        {
            row.status = std::move(status);
            read_numbers(row, jobs_folder());
            ++ended_;
        }

        void report()
        {
            write_batch_summary(folder_, jobs_folder(), run_.rows);
            job_.report("jobs", static_cast<double>(ended_) / static_cast<double>(open_));
        }

        std::mutex mutex_;
        BatchRun& run_;
        std::vector<std::string> inputs_;
        const fs::path& folder_;
        const Job& job_;
        std::size_t open_, ended_ = 0;
    };

    /// Largest memory of this process until now.
    double peak_bytes()
    {
        rusage use {};
        ::getrusage(RUSAGE_SELF, &use);
        return 1024.0 * static_cast<double>(use.ru_maxrss); // Linux counts kilobytes
    }

    JobStatus status_of(const Json& printed, int exit_code)
    {
        JobStatus status { .state = JobStatus::State::done, .inputs = {} };
        if (exit_code != 0) {
            const JobFailure failure = failure_in(printed, exit_code);
            status.state = JobStatus::State::failed;
            status.reason = failure.reason;
            status.lasting = failure.lasting;
        }
        return status;
    }

} // namespace

BatchRun run_sample_plans(const std::vector<SamplePlan>& plans, const fs::path& folder, const BatchSettings& settings,
    const std::function<std::vector<std::string>(std::span<const std::size_t>)>& words, const Job& job)
{
    const fs::path jobs_folder = folder / "jobs";
    make_folder(folder);
    const FolderLock lock(folder);
    make_folder(jobs_folder);
    std::vector<BatchJob> jobs;
    for (const SamplePlan& plan : plans)
        jobs.push_back(plan.job);
    const std::vector<std::string> inputs = inputs_of_plans(jobs);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
    BatchRun run { .rows = rows_of(jobs, inputs, jobs_folder, settings.retry) };
    run.skipped = static_cast<std::size_t>(
        std::ranges::count_if(run.rows, [](const BatchRow& row) { return row.status.has_value(); }));
    for (const BatchRow& row : run.rows)
        if (!row.status)
            fs::remove_all(jobs_folder / row.job.name); // an earlier status would be taken for the new one
    const Stopwatch watch;
    const int processes = settings.processes > 0 ? settings.processes
                                                 : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const std::vector<std::vector<std::size_t>> parts = parts_of(run.rows, static_cast<std::size_t>(processes));
    Rows rows(run, inputs, folder, job);
    job.report("jobs", 0.0);
    std::atomic<bool> broken { false }; ///< a full disk concerns all processes
    const auto plan_part = [&](std::vector<std::size_t> left) {
        bool opened = false; ///< a plan of this part has ended, so their common opening exists
        bool ended_none = false; ///< the last process of this part
        while (!left.empty() && !job.cancelled() && !broken.load()) {
            const std::size_t before = left.size();
            Stopwatch since_last;
            bool too_long = false;
            std::exception_ptr failure;
            const auto stop = [&] {
                try {
                    const std::size_t open = left.size();
                    left = rows.take_ended(left);
                    if (left.size() < open)
                        since_last = Stopwatch();
                } catch (...) { // the process must still be ended
                    failure = std::current_exception();
                    broken.store(true);
                }
                too_long = since_last.seconds() > settings.limit_s;
                return too_long || job.cancelled() || broken.load();
            };
            constexpr std::chrono::hours kForever { 24 * 365 }; // each plan has its own limit
            const ProgramRun process = run_program(words(left), kForever, {}, stop);
            if (failure)
                std::rethrow_exception(failure);
            const std::size_t at_end = left.size();
            left = rows.take_ended(left);
            opened = opened || left.size() < before;
            if (left.empty() || (process.stopped && !too_long))
                break;
            if (too_long && left.size() < at_end)
                continue; // it ended just in time
            // The process ended in the first of the rest. Before any plan has ended, mesh, cut or opening may fail,
            // which all share: bad input says so, and so do two processes.
            constexpr int kBadInput = 2;
            const bool bad_input = !opened && process.exit_code == kBadInput;
            const bool all_fail = bad_input || (!opened && ended_none);
            ended_none = left.size() == before;
            JobFailure reason = too_long ? JobFailure { "took longer than " + in_words(settings.limit_s) + " s" }
                                         : failure_of(process, settings.limit_s);
            const std::size_t failed = all_fail ? left.size() : 1;
            for (std::size_t n = 0; n < failed; ++n) {
                rows.fail(left[n], reason);
                reason.lasting = reason.lasting && bad_input; // the others were not tried
            }
            left.erase(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(failed));
        }
    };
    each_on_threads(parts.size(), processes, job, [&](std::size_t p) {
        try {
            plan_part(parts[p]);
        } catch (...) {
            broken.store(true); // the other processes end, too
            throw;
        }
    });
    write_batch_summary(folder, jobs_folder, run.rows);
    run.seconds = watch.seconds();
    return run;
}

void plan_samples_here(const std::vector<SamplePlan>& plans, bool draft, const fs::path& folder, const Job& job)
{
    if (plans.empty())
        return;
    const BatchJob& first = plans.front().job;
    planner::Case planned_case = open_case(first.case_file.string());
    planned_case.approaches = { planner::find_approach(planned_case, first.approach) };
    if (draft)
        planner::make_draft(planned_case);
    planner::Patient patient(std::move(planned_case), job);
    std::vector<BatchJob> jobs;
    std::vector<planner::StiffnessFactors> samples;
    for (const SamplePlan& plan : plans) {
        jobs.push_back(plan.job);
        samples.push_back(plan.factors);
    }
    const std::vector<std::string> inputs = inputs_of_plans(jobs);
    Stopwatch watch;
    planner::plan_samples(patient, patient.planned_case().approaches.front(), samples,
        [&](std::size_t s, planner::PlanAttempt planned) {
            const fs::path out = folder / "jobs" / jobs[s].name;
            make_folder(out);
            Json printed;
            int exit_code = 0;
            if (planned.failure.empty()) {
                const std::vector<planner::PlannedField> fields { std::move(planned.field) };
                planner::Provenance computed = provenance_now(patient.planned_case());
                computed.stiffness = planner::stiffness_text(samples[s]);
                printed = write_metrics(out, computed, patient, fields);
                exit_code = exit_code_of(fields);
            } else {
                constexpr int kBadInput = 2; // the same again would fail in the same way
                printed["error"] = planned.failure;
                exit_code = kBadInput;
            }
            JobStatus status = status_of(printed, exit_code);
            status.inputs = inputs[s];
            status.seconds = watch.seconds();
            watch = Stopwatch();
            status.peak_bytes = peak_bytes();
            status.disk_bytes = size_of(out);
            write_job_status(out, status);
        },
        job, { .error_bars = false, .draft = draft, .find_region = true });
}

} // namespace retractor::ui::cli
