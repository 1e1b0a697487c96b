#pragma once
// One thread that runs tasks one after another, in the order in which they were posted. The threads that post tasks
// never wait for one. Between tasks the same thread may run a step of its own, such as the next frame of a motion.
//
// Who calls: post(), post_latest(), cancel(), progress() and idle() may be called from any thread, also from a task.
// The constructor and the destructor belong to one owner, which is not the executor's thread.
// On which thread: tasks, the step and on_progress run on the executor's thread, one at a time, so that what only they
// touch needs no lock. (A task that computes with several threads may report its progress from any of these.)
// What may not happen: a task, the step and on_progress do not throw (std::terminate), and none of them waits for a
// task that was posted later.

#include "mesh/base/job.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
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
    run, ///< with a Job that is cancelled
};

struct SerialExecutorOptions {
    /// Runs after the tasks that waited together have run, and again at the time that it returned if no task was posted
    /// before. Nothing: it runs only after further tasks. It does not run before the first task, nor once the executor
    /// is being destroyed. May be empty.
    std::function<std::optional<std::chrono::steady_clock::time_point>()> step {};
    /// Runs when a task has reported its progress; progress() tells it already. May be empty.
    std::function<void()> on_progress {};
    WaitingTasks when_destroyed = WaitingTasks::dropped;
};

class SerialExecutor {
public:
    /// The Job reports to progress(); it is cancelled by cancel() and by the executor's destruction.
    using Task = std::function<void(const Job&)>;

    /// How far the task that runs is; of the last task when none runs.
    struct Progress {
        std::string stage; ///< empty: the task has reported nothing yet
        double fraction = 0.0; ///< of the stage, 0 to 1
    };

    explicit SerialExecutor(SerialExecutorOptions options = {});
    /// Cancels the task that runs, drops or runs those that wait, as the options say, and joins the thread.
    ~SerialExecutor();
    SerialExecutor(const SerialExecutor&) = delete;
    SerialExecutor& operator=(const SerialExecutor&) = delete;

    void post(Task task);
    /// Drops a waiting task with the same key, if there is one: of tasks such as "draw the hook there" only the newest
    /// counts.
    void post_latest(std::string key, Task task);

    /// Asks the task that runs, and all that wait now, to stop: their Jobs are cancelled. Tasks that are posted later
    /// are not affected.
    void cancel();

    /// A task waits, or the executor is being destroyed. A Job whose `cancel` points here makes way for the next task;
    /// valid as long as the executor.
    const std::atomic<bool>& task_waits() const { return task_waits_; }
    /// No task waits or runs, and the step does not want to run again by itself.
    bool idle() const;
    Progress progress() const;

private:
    struct Waiting {
        Task task;
        std::string key {}; ///< of post_latest(); empty: none
        bool cancelled = false;
    };
    void run();
    bool run_next(std::unique_lock<std::mutex>& lock);
    void note_waiting();

    const SerialExecutorOptions options_;
    mutable std::mutex mutex_; ///< of all that follows, but for the atomics and the thread
    std::condition_variable wake_;
    std::deque<Waiting> waiting_;
    bool busy_ = false; ///< a task or the step runs, or the step wants to run again
    bool ending_ = false;
    Progress progress_;
    std::atomic<bool> task_waits_ { false };
    std::atomic<bool> cancelled_ { false }; ///< the task that runs is
    std::thread thread_; ///< last: it uses all of the above
};

} // namespace retractor
