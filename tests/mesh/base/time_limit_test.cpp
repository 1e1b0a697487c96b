#include "mesh/base/time_limit.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace retractor {
namespace time_limit_test {

    constexpr double kPatienceS = 20.0; // longer than any machine takes to notice

    bool is_cancelled_in_time(const Job& job)
    {
        const Stopwatch watch;
        while (!job.cancelled() && watch.seconds() < kPatienceS)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return job.cancelled();
    }

    TEST(TimeLimit, CancelsThePartWhenTheTimeIsUp)
    {
        constexpr double kShortS = 0.05;
        const Job whole;
        const Stopwatch watch;
        const TimeLimit limit(whole, kShortS);
        EXPECT_TRUE(is_cancelled_in_time(limit.job()));
        EXPECT_GE(watch.seconds(), kShortS);
        EXPECT_TRUE(limit.is_over());
        EXPECT_FALSE(whole.cancelled());
        const TimeLimit none(whole, 0.0);
        EXPECT_TRUE(is_cancelled_in_time(none.job()));
        EXPECT_TRUE(none.is_over());
    }

    TEST(TimeLimit, CanBeginAgain)
    {
        constexpr double kFirstS = 1.0, kShortS = 0.05;
        const Job whole;
        TimeLimit longer(whole, kFirstS);
        longer.restart(1e3);
        TimeLimit shorter(whole, 1e3);
        shorter.restart(kShortS);
        EXPECT_TRUE(is_cancelled_in_time(shorter.job()));
        std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * kFirstS));
        EXPECT_FALSE(longer.job().cancelled());
    }

    TEST(TimeLimit, CancelsThePartWithTheWholeJob)
    {
        std::atomic<bool> cancel { false };
        const Job whole { .on_progress = {}, .cancel = &cancel };
        const TimeLimit limit(whole, 1e3);
        EXPECT_FALSE(limit.job().cancelled());
        cancel = true;
        EXPECT_TRUE(is_cancelled_in_time(limit.job()));
        EXPECT_FALSE(limit.is_over());
    }

    TEST(TimeLimit, EndsWithItsPartAndReportsForTheWholeJob)
    {
        std::string told;
        const Job whole { .on_progress = [&](std::string_view stage, double) { told = stage; } };
        const Stopwatch watch;
        {
            const TimeLimit limit(whole, 1e3);
            limit.job().report("opening", 0.5);
            EXPECT_FALSE(limit.job().cancelled());
        }
        EXPECT_LT(watch.seconds(), kPatienceS);
        EXPECT_EQ(told, "opening");
    }

} // namespace time_limit_test
} // namespace retractor
