#pragma once
// One thread that runs tasks one after another, in the order in which they were posted. The threads that post tasks
// never wait for one. Between tasks the same thread may run a step of its own, such as the next frame of a motion.
//
// Any thread may call post(), post_latest(), cancel(), progress() and idle(), also from within a task. The constructor
// and the destructor belong to one owner, which is not the executor's thread.
//
// Tasks, the step and on_progress run on the executor's thread, one at a time, so that data which only they touch needs
// no lock. A task that computes with several threads may report its progress from any of its threads.
//
// A task, the step and on_progress must not throw (std::terminate), and must not wait for a task that was posted later.

#include "mesh/base/job.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace retractor {

/// What happens to tasks that still wait when an executor is destroyed.
enum class WaitingTasks {
    dropped,
    run, ///< each gets a Job that is cancelled
};

struct SerialExecutorOptions {
    /// Runs after the waiting tasks have run, and runs again at the time that it returned unless a task is posted
    /// before that time. When it returns nothing, it runs again only after further tasks. It runs neither before the
    /// first task nor while the executor is being destroyed. May be empty.
    std::function<std::optional<std::chrono::steady_clock::time_point>()> step {};
    /// Runs after a task has reported progress; progress() already returns the new value. May be empty.
    std::function<void()> on_progress {};
    WaitingTasks when_destroyed = WaitingTasks::dropped; ///< fate of waiting tasks
};

class SerialExecutor {
public:
    /// The Job of a task reports to progress(). cancel() and the destructor cancel the Job.
    using Task = std::function<void(const Job&)>;

    /// Progress of the running task, or of the last task when no task runs.
    struct Progress {
        std::string stage; ///< name of the stage; empty before the first report
        double fraction = 0.0; ///< finished fraction of the stage, 0 to 1
    };

    explicit SerialExecutor(SerialExecutorOptions options = {});
    /// Cancels the running task, drops or runs the waiting tasks as the options say, and joins the thread.
    ~SerialExecutor();
    SerialExecutor(const SerialExecutor&) = delete;
    SerialExecutor& operator=(const SerialExecutor&) = delete;

    void post(Task task);
    /// Posts a task and drops a waiting task with the same key: only the newest task such as "draw the hook there"
    /// counts.
    void post_latest(std::string key, Task task);

    /// Cancels the Jobs of the running task and of all tasks that wait now. Later tasks are not affected.
    void cancel();

    /// True while a task waits or the executor is being destroyed. A Job whose `cancel` points here makes way for the
    /// next task. The reference is valid as long as the executor lives.
    const std::atomic<bool>& task_waits() const { return task_waits_; }
    /// True when no task waits or runs and the step has not asked to run again.
    bool idle() const;
    Progress progress() const;

private:
    struct Waiting {
        Task task;
        std::string key {}; ///< key given to post_latest(); empty for post()
        bool cancelled = false;
    };
    void run();
    bool run_next(std::unique_lock<std::mutex>& lock);
    void note_waiting();

    const SerialExecutorOptions options_;
    mutable std::mutex mutex_; ///< guards all members below except the atomics and the thread
    std::condition_variable wake_;
    std::deque<Waiting> waiting_;
    bool busy_ = false; ///< a task or the step runs, or the step has asked to run again
    bool ending_ = false;
    Progress progress_;
    std::atomic<bool> task_waits_ { false };
    std::atomic<bool> cancelled_ { false }; ///< the running task is cancelled
    std::thread thread_; ///< declared last, because the thread uses all other members
};

} // namespace retractor
