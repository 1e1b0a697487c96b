#include "mesh/base/serial_executor.h"

#include "mesh/base/assert.h"

#include <string_view>
#include <utility>

namespace retractor {

SerialExecutor::SerialExecutor(SerialExecutorOptions options)
    : options_(std::move(options))
    , thread_([this] { run(); })
{
}

SerialExecutor::~SerialExecutor()
{
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        cancelled_.store(true);
        if (options_.when_destroyed == WaitingTasks::dropped)
            waiting_.clear();
        note_waiting();
    }
    wake_.notify_one();
    thread_.join();
}

/// @pre mutex_ is held
void SerialExecutor::note_waiting() { task_waits_.store(ending_ || !waiting_.empty()); }

void SerialExecutor::post(Task task) { post_latest({}, std::move(task)); }

void SerialExecutor::post_latest(std::string key, Task task)
{
    {
        const std::lock_guard lock(mutex_);
        if (ending_ && options_.when_destroyed == WaitingTasks::dropped)
            return;
        if (!key.empty())
            std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.key == key; });
        waiting_.push_back({ .task = std::move(task), .key = std::move(key) });
        note_waiting();
    }
    wake_.notify_one();
}

void SerialExecutor::cancel()
{
    const std::lock_guard lock(mutex_);
    cancelled_.store(true); // the next task resets the flag
    for (Waiting& waiting : waiting_)
        waiting.cancelled = true;
}

bool SerialExecutor::idle() const
{
    const std::lock_guard lock(mutex_);
    return !busy_ && waiting_.empty();
}

SerialExecutor::Progress SerialExecutor::progress() const
{
    const std::lock_guard lock(mutex_);
    return progress_;
}

/// Runs the next waiting task. @pre the lock is held; the lock is held again afterwards
/// @return false when no task waited
bool SerialExecutor::run_next(std::unique_lock<std::mutex>& lock)
{
    RETRACTOR_ASSERT(lock.owns_lock());
    if (waiting_.empty())
        return false;
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    note_waiting();
    cancelled_.store(next.cancelled || ending_);
    progress_ = {};
    lock.unlock();
    Job job;
    job.cancel = &cancelled_;
    job.on_progress = [this](std::string_view stage, double fraction) {
        {
            const std::lock_guard progress_lock(mutex_);
            progress_ = { std::string(stage), fraction };
        }
        if (options_.on_progress)
            options_.on_progress();
    };
    next.task(job);
    next.task = nullptr; // destroys the task's captured values while the lock is free
    lock.lock();
    return true;
}

void SerialExecutor::run()
{
    std::optional<std::chrono::steady_clock::time_point> next_step;
    std::unique_lock lock(mutex_);
    while (true) {
        busy_ = next_step.has_value();
        const auto called = [this] { return ending_ || !waiting_.empty(); };
        if (next_step)
            wake_.wait_until(lock, *next_step, called);
        else
            wake_.wait(lock, called);
        busy_ = true;
        for (std::size_t together = waiting_.size(); together > 0 && run_next(lock); --together) { }
        if (ending_) {
            while (run_next(lock)) { }
            return;
        }
        if (options_.step) {
            lock.unlock();
            next_step = options_.step();
            lock.lock();
        }
    }
}

} // namespace retractor
