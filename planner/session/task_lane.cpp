#include "planner/session/task_lane.h"

#include <utility>

namespace retractor {

TaskLane::TaskLane()
    : thread_([this] { run(); })
{
}

TaskLane::~TaskLane()
{
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        tasks_.clear();
    }
    wake_.notify_one();
    thread_.join();
}

void TaskLane::post(std::function<void()> task)
{
    {
        const std::lock_guard lock(mutex_);
        tasks_.push_back(std::move(task));
    }
    wake_.notify_one();
}

void TaskLane::run()
{
    while (true) {
        std::function<void()> task;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return stop_ || !tasks_.empty(); });
            if (stop_)
                return;
            task = std::move(tasks_.front());
            tasks_.pop_front();
        }
        task();
    }
}

} // namespace retractor
