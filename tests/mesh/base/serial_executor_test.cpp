#include "mesh/base/serial_executor.h"
#include "tests/support/wait_until.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <vector>

namespace retractor {
namespace serial_executor_test {

    using Clock = std::chrono::steady_clock;

    /// Keeps an executor's thread in a task until it is released.
    class Gate {
    public:
        explicit Gate(SerialExecutor& executor)
        {
            executor.post([entered = entered_, open = open_.get_future().share()](const Job&) {
                entered->set_value();
                open.wait();
            });
            entered_->get_future().wait();
        }
        void release() { open_.set_value(); }

    private:
        std::shared_ptr<std::promise<void>> entered_ = std::make_shared<std::promise<void>>();
        std::promise<void> open_;
    };

    void wait_for(const SerialExecutor& executor)
    {
        ASSERT_TRUE(test_support::wait_until([&] { return executor.idle(); }));
    }

    TEST(SerialExecutor, RunsTasksInOrderOnOneOtherThread)
    {
        std::vector<int> order;
        std::promise<std::thread::id> last;
        SerialExecutor executor;
        for (int i = 0; i < 100; ++i)
            executor.post([&order, i](const Job&) { order.push_back(i); });
        executor.post([&last](const Job&) { last.set_value(std::this_thread::get_id()); });
        EXPECT_NE(last.get_future().get(), std::this_thread::get_id());
        EXPECT_EQ(order.size(), 100U);
        EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
    }

    TEST(SerialExecutor, IsIdleWhenNothingWaitsOrRuns)
    {
        SerialExecutor executor;
        EXPECT_TRUE(executor.idle());
        Gate gate(executor);
        EXPECT_FALSE(executor.idle()) << "a task runs";
        EXPECT_FALSE(executor.task_waits());
        executor.post([](const Job&) {});
        EXPECT_TRUE(executor.task_waits());
        gate.release();
        wait_for(executor);
        EXPECT_FALSE(executor.task_waits());
    }

    TEST(SerialExecutor, ATaskMayPostAnother)
    {
        std::promise<void> second;
        SerialExecutor executor;
        executor.post([&](const Job&) { executor.post([&](const Job&) { second.set_value(); }); });
        second.get_future().wait();
    }

    TEST(SerialExecutor, OfTasksWithOneKeyTheNewestRunsInItsPlace)
    {
        std::vector<int> run;
        SerialExecutor executor;
        Gate gate(executor);
        const auto note = [&run](int number) { return [&run, number](const Job&) { run.push_back(number); }; };
        executor.post_latest("a", note(1));
        executor.post_latest("b", note(2));
        executor.post(note(3));
        executor.post(note(4)); // no key: it replaces nothing
        executor.post_latest("a", note(5));
        gate.release();
        wait_for(executor);
        EXPECT_EQ(run, (std::vector<int> { 2, 3, 4, 5 }));
        executor.post_latest("a", note(6));
        wait_for(executor);
        EXPECT_EQ(run.back(), 6) << "what has run is replaced by nothing";
    }

    TEST(SerialExecutor, CancelsWhatRunsAndWaitsAndNothingLater)
    {
        std::promise<void> begun;
        std::atomic<bool> waiting_cancelled { false }, later_cancelled { true };
        SerialExecutor executor;
        executor.post([&](const Job& job) {
            begun.set_value();
            while (!job.cancelled())
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        });
        executor.post([&](const Job& job) { waiting_cancelled = job.cancelled(); });
        begun.get_future().wait();
        executor.cancel();
        executor.post([&](const Job& job) { later_cancelled = job.cancelled(); });
        wait_for(executor); // else the first task runs for ever
        EXPECT_TRUE(waiting_cancelled);
        EXPECT_FALSE(later_cancelled);
    }

    TEST(SerialExecutor, CancellingNothingCancelsNoLaterTask)
    {
        std::atomic<bool> cancelled { true };
        SerialExecutor executor;
        executor.cancel();
        executor.post([&](const Job& job) { cancelled = job.cancelled(); });
        wait_for(executor);
        EXPECT_FALSE(cancelled);
    }

    TEST(SerialExecutor, TellsTheProgressOfTheTaskThatRuns)
    {
        std::atomic<int> told { 0 };
        SerialExecutor executor({ .on_progress = [&] { ++told; } });
        executor.post([](const Job& job) { job.report("mesh", 0.25); });
        wait_for(executor);
        EXPECT_EQ(executor.progress().stage, "mesh");
        EXPECT_EQ(executor.progress().fraction, 0.25);
        EXPECT_EQ(told, 1);
        Gate gate(executor);
        EXPECT_EQ(executor.progress().stage, "") << "another task has begun";
        gate.release();
    }

    TEST(SerialExecutor, DestructionWaitsForTheRunningTaskAndDropsTheOthers)
    {
        std::promise<void> begun;
        std::atomic<bool> ended = false, second = false;
        {
            SerialExecutor executor;
            executor.post([&](const Job& job) {
                begun.set_value();
                while (!job.cancelled())
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
                ended = true;
            });
            executor.post([&](const Job&) { second = true; });
            begun.get_future().wait();
        }
        EXPECT_TRUE(ended);
        EXPECT_FALSE(second);
    }

    TEST(SerialExecutor, DestructionRunsWaitingTasksWhereThatIsAskedFor)
    {
        std::vector<bool> cancelled;
        {
            std::promise<void> begun;
            SerialExecutor executor({ .when_destroyed = WaitingTasks::run });
            executor.post([&](const Job& job) {
                begun.set_value();
                while (!job.cancelled())
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            });
            for (int i = 0; i < 3; ++i)
                executor.post([&](const Job& job) { cancelled.push_back(job.cancelled()); });
            begun.get_future().wait();
        }
        EXPECT_EQ(cancelled, (std::vector<bool> { true, true, true }));
    }

    TEST(SerialExecutor, TheStepRunsAfterTasksThatWaitedTogetherAndWhenItAskedTo)
    {
        std::vector<char> run; // of the executor's thread until it is idle
        int steps_wanted = 0;
        SerialExecutor executor({ .step = [&]() -> std::optional<Clock::time_point> {
            run.push_back('s');
            if (steps_wanted == 0)
                return {};
            --steps_wanted;
            return Clock::now();
        } });
        const auto task = [&](const Job&) { run.push_back('t'); };
        {
            Gate gate(executor);
            executor.post(task);
            executor.post(task);
            executor.post([&](const Job&) { steps_wanted = 2; });
            gate.release();
            wait_for(executor);
        }
        // One step after the gate, one after the tasks that waited behind it, and two more that were asked for.
        EXPECT_EQ(run, (std::vector<char> { 's', 't', 't', 's', 's', 's' }));
    }

    TEST(SerialExecutor, ATaskComesBeforeAStepThatIsDueLater)
    {
        std::promise<void> ran;
        std::atomic<int> steps { 0 };
        SerialExecutor executor({ .step = [&]() -> std::optional<Clock::time_point> {
            ++steps;
            return Clock::now() + std::chrono::hours(1);
        } });
        executor.post([](const Job&) {});
        ASSERT_TRUE(test_support::wait_until([&] { return steps > 0; }));
        EXPECT_FALSE(executor.idle()) << "the step wants to run again";
        executor.post([&](const Job&) { ran.set_value(); });
        ran.get_future().wait(); // and not for an hour
    }

} // namespace serial_executor_test
} // namespace retractor
