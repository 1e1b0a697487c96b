#include "haptics/device/tick_thread.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <atomic>

namespace retractor::haptics {
namespace tick_thread_test {

    struct Counter : Ticked {
        std::atomic<int> ticks { 0 };
        std::atomic<bool> backwards { false };
        double last = -1.0;
        void tick(double time_s, double step_s) noexcept override
        {
            if (!(time_s > last) || !(step_s > 0.0))
                backwards = true;
            last = time_s;
            ++ticks;
        }
    };

    TEST(TickThread, RunsUntilItIsStoppedAndCanRunAgain)
    {
        Counter counter;
        TickThread thread({ .period_s = 1e-4 });
        for (int round = 1; round <= 2; ++round) {
            counter.last = -1.0;
            const int before = counter.ticks;
            thread.start(counter);
            while (counter.ticks < before + 50)
                std::this_thread::yield();
            thread.stop();
            const int ticks = counter.ticks;
            EXPECT_EQ(thread.times().ticks, static_cast<std::uint64_t>(counter.ticks - before))
                << "run " << round << " counts from zero";
            std::this_thread::yield();
            EXPECT_EQ(counter.ticks, ticks);
        }
        EXPECT_FALSE(counter.backwards);
        thread.stop();
    }

    TEST(TickThread, SaysWhetherItHasRealTimePriority)
    {
        Counter counter;
        TickThread ordinary({ .priority = 0 });
        ordinary.start(counter);
        EXPECT_FALSE(ordinary.is_realtime());
        EXPECT_EQ(ordinary.realtime_note(), "SCHED_FIFO was not asked for");
        EXPECT_EQ(test_support::message_of([&] { ordinary.start(counter); }), "the tick thread runs already");
        ordinary.stop(); // a counter is for one thread
        counter.last = -1.0;
        TickThread best;
        best.start(counter);
        EXPECT_TRUE(best.is_realtime() || best.realtime_note().find("SCHED_FIFO") != std::string::npos);
        EXPECT_EQ(test_support::message_of([] { TickThread thread({ .period_s = 0.0 }); }),
            "period_s: the period must be positive");
    }

} // namespace tick_thread_test
} // namespace retractor::haptics
