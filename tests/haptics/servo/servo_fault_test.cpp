#include "haptics/servo/servo_fault.h"

#include <gtest/gtest.h>

namespace retractor::haptics {
namespace servo_fault_test {

    constexpr double kStep = 1e-3;

    TEST(FaultLatch, RampsUpDownAndUpAgain)
    {
        FaultLatch latch({ .ramp_down_s = 0.1, .ramp_up_s = 0.5 });
        double gain = 0.0, last = 0.0;
        for (int i = 0; i < 500; ++i) {
            gain = latch.gain(kStep);
            EXPECT_NEAR(gain - last, kStep / 0.5, 1e-12);
            last = gain;
        }
        EXPECT_NEAR(gain, 1.0, 1e-12);
        latch.latch({ .kind = FaultKind::jump, .device = 1, .tick = 7, .time_s = 0.5, .value = 140.0 });
        latch.latch({ .kind = FaultKind::lost });
        EXPECT_EQ(latch.fault().kind, FaultKind::jump) << "the first reason is kept";
        for (int i = 0; i < 101; ++i)
            gain = latch.gain(kStep);
        EXPECT_EQ(gain, 0.0);
        latch.rearm();
        EXPECT_NEAR(latch.gain(kStep), kStep / 0.5, 1e-12);
    }

    TEST(FaultLatch, SaysWhatHappenedWhereAndWhen)
    {
        EXPECT_EQ(describe({}), "");
        EXPECT_EQ(describe({ .kind = FaultKind::jump, .device = 1, .tick = 2041, .time_s = 2.041, .value = 140.2 }),
            "device 1 jumped by 140 mm in one tick (tick 2041, 2.041 s)");
        EXPECT_EQ(describe({ .kind = FaultKind::late, .tick = 3, .time_s = 0.05, .value = 0.032 }),
            "a tick came 0.032 s after the one before (tick 3, 0.050 s)");
        EXPECT_EQ(describe({ .kind = FaultKind::silent, .device = 2, .tick = 9, .value = 0.021 }),
            "device 2 has been silent for 0.021 s (tick 9, 0.000 s)");
        for (const FaultKind kind : { FaultKind::let_go, FaultKind::bad_position, FaultKind::over_limit,
                 FaultKind::lost, FaultKind::bad_force })
            EXPECT_GT(describe({ .kind = kind }).size(), std::string(" (tick 0, 0.000 s)").size());
    }

} // namespace servo_fault_test
} // namespace retractor::haptics
