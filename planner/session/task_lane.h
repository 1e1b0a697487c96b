#pragma once
// One thread that does tasks in the order they come, so that the window never waits for them.

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace retractor {

class TaskLane {
public:
    TaskLane();
    /// Drops what has not begun and waits for what has.
    ~TaskLane();
    TaskLane(const TaskLane&) = delete;
    TaskLane& operator=(const TaskLane&) = delete;

    /// @param task handles its own exceptions.
    void post(std::function<void()> task);

private:
    void run();

    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> tasks_;
    bool stop_ = false;
    std::thread thread_;
};

} // namespace retractor
