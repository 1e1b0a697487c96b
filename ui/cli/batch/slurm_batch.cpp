#include "ui/cli/batch/slurm_batch.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/text_format.h"
#include "ui/cli/batch/batch_folder.h"
#include "ui/cli/batch/job_status.h"
#include "ui/cli/batch/slurm.h"
#include "ui/cli/framework/out_folder.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <thread>
#include <utility>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr std::chrono::seconds kAskAgain { 5 }; ///< interval of the questions to the cluster's controller
    constexpr std::size_t kLargestArray = 1000; ///< Slurm's own limit, unless a cluster sets another
    constexpr int kMostSubmissions = 3; ///< of one job
    /// A task without a result is lost this long after its end: files of another machine may be seen a minute late.
    constexpr std::chrono::seconds kLostAfter { 60 };

    std::string in_quotes(const std::string& text)
    {
        std::string quoted = "'";
        for (const char c : text)
            quoted += c == '\'' ? std::string(R"('\'')") : std::string(1, c);
        return quoted + "'";
    }

    /// Name of a folder's arrays, without their number. @pre the folder exists
    std::string array_name(const fs::path& folder)
    {
        std::uint64_t hash = 14695981039346656037ULL; // FNV-1a
        for (const char c : fs::canonical(folder).string())
            hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
        return formatted("retractor-%016llx-", static_cast<unsigned long long>(hash));
    }

    /// Why a task that ended in this state has no result. Empty: its job may be submitted again.
    std::string reason_of(const std::string& state)
    {
        if (state == "CANCELLED")
            return "cancelled in the cluster's queue";
        if (state == "TIMEOUT" || state == "DEADLINE")
            return "took longer than the cluster allows";
        if (state == "OUT_OF_MEMORY")
            return "needed more memory than the cluster gave it";
        return {};
    }

    class Follower {
    public:
        Follower(std::vector<BatchRow>& rows, const std::vector<std::string>& inputs, const fs::path& sweep,
            const fs::path& folder, const BatchSettings& settings, const std::vector<std::string>& sbatch,
            const Job& job)
            : rows_(rows)
            , inputs_(inputs)
            , sweep_(sweep)
            , folder_(folder)
            , settings_(settings)
            , sbatch_(sbatch)
            , job_(job)
            , stop_([&job] { return job.cancelled(); })
            , name_(array_name(folder))
            , watched_(rows.size())
            , open_(count_open())
        {
            for (std::size_t n = 0; n < rows.size(); ++n)
                row_of_[rows[n].job.name] = n;
            make_folder(slurm_folder());
        }

        /// Follows until all jobs have ended, or the job is cancelled.
        void follow()
        {
            const std::size_t at_first = open_;
            for (;;) {
                const SlurmQueue queue = ask_queue(stop_); // before the statuses are read
                if (queue.answered)
                    take_states(queue.tasks);
                take_statuses();
                const bool answers = queue.answered && (job_.cancelled() || submit_again(without_task()));
                job_.report(answers ? "jobs" : "jobs; the cluster's controller does not answer " + queue.said,
                    1.0 - static_cast<double>(open_) / static_cast<double>(std::max<std::size_t>(1, at_first)));
                if (open_ == 0 || !wait())
                    return;
            }
        }

    private:
        struct Watched { ///< what is known of a job's last task
            int submissions = 0;
            int array = -1; ///< number of the task's array
            std::string state {};
            std::optional<std::chrono::steady_clock::time_point> ended {}; ///< when its end was seen
        };

        fs::path slurm_folder() const { return folder_ / "slurm"; }
        fs::path jobs_folder() const { return folder_ / "jobs"; }
        fs::path list_of(int array) const { return slurm_folder() / (name_ + std::to_string(array) + ".txt"); }

        std::size_t count_open() const
        {
            return static_cast<std::size_t>(
                std::ranges::count_if(rows_, [](const BatchRow& row) { return !row.status.has_value(); }));
        }

        /// @returns false when the job is cancelled
        bool wait() const
        {
            const auto end = std::chrono::steady_clock::now() + kAskAgain;
            while (std::chrono::steady_clock::now() < end) {
                if (job_.cancelled())
                    return false;
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            }
            return true;
        }

        const std::vector<std::string>& jobs_of(int array)
        {
            std::vector<std::string>& names = lists_[array];
            if (names.empty()) {
                std::ifstream in(list_of(array));
                for (std::string line; std::getline(in, line);)
                    names.push_back(line);
            }
            return names;
        }

        /// Takes the states of this folder's tasks. Of several tasks of one job the last array's counts.
        void take_states(const std::vector<SlurmTask>& tasks)
        {
            for (Watched& watched : watched_)
                watched.state.clear();
            for (const bool alone : { false, true })
                for (const SlurmTask& task : tasks) {
                    int array = 0;
                    const char* const end = task.array.data() + task.array.size();
                    if (task.number.has_value() != alone || !task.array.starts_with(name_)
                        || std::from_chars(task.array.data() + name_.size(), end, array).ptr != end)
                        continue;
                    last_array_ = std::max(last_array_, array);
                    const std::vector<std::string>& names = jobs_of(array);
                    for (std::size_t n = 0; n < names.size(); ++n)
                        if (n == task.number.value_or(n))
                            take_state(names[n], array, task.state);
                }
        }

        void take_state(const std::string& name, int array, const std::string& state)
        {
            const auto row = row_of_.find(name);
            if (row == row_of_.end() || array < watched_[row->second].array)
                return;
            Watched& watched = watched_[row->second];
            watched.array = array;
            watched.state = state;
            if (!is_active(state))
                return;
            watched.submissions = std::max(watched.submissions, 1); // perhaps by an earlier call
            watched.ended.reset();
        }

        /// Takes the results that have come. A submission removes earlier results of its jobs.
        void take_statuses()
        {
            bool changed = false;
            for (std::size_t n = 0; n < rows_.size(); ++n) {
                if (rows_[n].status)
                    continue;
                std::optional<JobStatus> status = read_job_status(jobs_folder() / rows_[n].job.name);
                const bool submitted = watched_[n].submissions > 0;
                if (!status || status->state == JobStatus::State::running)
                    continue;
                if (submitted && status->inputs != inputs_[n]) {
                    status->state = JobStatus::State::failed;
                    status->reason = "the case or its options were changed while the batch ran";
                    status->lasting = false;
                } else if (!submitted && (settings_.retry || !is_end(*status, inputs_[n]))) {
                    continue;
                }
                end(n, *status);
                changed = true;
            }
            if (changed)
                write_batch_summary(folder_, jobs_folder(), rows_);
        }

        void end(std::size_t n, const JobStatus& status)
        {
            rows_[n].status = status;
            read_numbers(rows_[n], jobs_folder());
            --open_;
        }

        /// The open jobs that need a task in the queue. This function ends the jobs that get no further task.
        std::vector<std::size_t> without_task()
        {
            std::vector<std::size_t> without;
            for (std::size_t n = 0; n < rows_.size(); ++n) {
                Watched& watched = watched_[n];
                if (rows_[n].status || (!watched.state.empty() && is_active(watched.state)))
                    continue;
                std::string reason = watched.submissions > 0 ? reason_of(watched.state) : std::string();
                const auto now = std::chrono::steady_clock::now();
                if (watched.submissions > 0 && reason.empty() && now - watched.ended.value_or(now) < kLostAfter) {
                    watched.ended = watched.ended.value_or(now);
                    continue;
                }
                if (reason.empty() && watched.submissions >= kMostSubmissions)
                    reason = formatted("ended %d times in the cluster without an answer; %s has what it printed",
                        kMostSubmissions, slurm_folder().c_str());
                if (reason.empty()) {
                    without.push_back(n);
                    continue;
                }
                const JobStatus status {
                    .state = JobStatus::State::failed, .inputs = inputs_[n], .reason = reason, .lasting = false
                };
                make_folder(jobs_folder() / rows_[n].job.name);
                write_job_status(jobs_folder() / rows_[n].job.name, status);
                end(n, status);
                write_batch_summary(folder_, jobs_folder(), rows_);
            }
            return without;
        }

        /// @returns false when the cluster's controller did not answer
        bool submit_again(std::span<const std::size_t> jobs)
        {
            for (; !jobs.empty(); jobs = jobs.subspan(std::min(jobs.size(), kLargestArray)))
                if (!submit_array(jobs.first(std::min(jobs.size(), kLargestArray))))
                    return false;
            return true;
        }

        bool submit_array(std::span<const std::size_t> jobs)
        {
            // An array of a folder by this name that was deleted may still be in the queue.
            int array = last_array_ + 1;
            while (fs::exists(list_of(array)))
                ++array;
            last_array_ = array;
            std::string list;
            for (const std::size_t n : jobs) {
                fs::remove(jobs_folder() / rows_[n].job.name / "status.json"); // of an earlier run
                list += rows_[n].job.name + "\n";
            }
            const std::string name = name_ + std::to_string(array);
            const fs::path script = slurm_folder() / (name + ".sh");
            write_file_atomically(script,
                "#!/bin/sh\nname=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" " + in_quotes(list_of(array).string())
                    + ")\n[ -n \"$name\" ] || exit 1\nexec " + in_quotes(fs::read_symlink("/proc/self/exe").string())
                    + " --json batch " + in_quotes(sweep_.string()) + " --out " + in_quotes(folder_.string())
                    + " --limit " + formatted("%.17g", settings_.limit_s) + " --job \"$name\"\n");
            write_file_atomically(list_of(array), list);
            // The list stays where sbatch fails: the controller may have taken the array.
            const SlurmArray tasks { .name = name,
                .script = script,
                .logs = slurm_folder(),
                .tasks = jobs.size(),
                .at_a_time = settings_.processes,
                .options = sbatch_ };
            if (!submit(tasks, stop_))
                return false;
            for (const std::size_t n : jobs) {
                Watched& watched = watched_[n];
                watched = { .submissions = watched.submissions + 1, .array = array, .state = "PENDING" };
            }
            return true;
        }

        std::vector<BatchRow>& rows_;
        const std::vector<std::string>& inputs_;
        const fs::path& sweep_;
        const fs::path& folder_;
        const BatchSettings& settings_;
        const std::vector<std::string>& sbatch_;
        const Job& job_;
        std::function<bool()> stop_; ///< for the programs of Slurm
        std::string name_;
        std::vector<Watched> watched_; ///< per row
        std::size_t open_; ///< rows without a status
        int last_array_ = -1; ///< largest number of an array that is known
        std::map<std::string, std::size_t> row_of_; ///< by the job's name
        std::map<int, std::vector<std::string>> lists_; ///< names of the jobs of each array
    };

} // namespace

BatchRun run_slurm_batch(const std::vector<BatchJob>& jobs, const fs::path& sweep, const fs::path& folder,
    const BatchSettings& settings, const std::vector<std::string>& sbatch, const Job& job)
{
    make_folder(folder);
    const FolderLock lock(folder);
    make_folder(folder / "jobs");
    const std::vector<std::string> inputs = inputs_of(jobs);
    BatchRun run { .rows = rows_of(jobs, inputs, folder / "jobs", settings.retry) };
    run.skipped = static_cast<std::size_t>(
        std::ranges::count_if(run.rows, [](const BatchRow& row) { return row.status.has_value(); }));
    const Stopwatch watch;
    if (run.skipped < run.rows.size())
        Follower(run.rows, inputs, sweep, folder, settings, sbatch, job).follow();
    write_batch_summary(folder, folder / "jobs", run.rows);
    run.seconds = watch.seconds();
    return run;
}

} // namespace retractor::ui::cli
