#include "haptics/device/tick_timer.h"

#include "tests/support/haptics/tick_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace retractor::haptics {
namespace tick_timer_test {

    using test_support::MeasuredTicks;
    using test_support::TickHistogram;

    constexpr double kBin = 1.13; // a twentieth of a decade

    TEST(TickHistogram, KnowsMeanAndLargestExactlyAndPercentilesToABin)
    {
        TickHistogram histogram;
        for (int i = 1; i <= 1000; ++i)
            histogram.add(1e-6 * i);
        EXPECT_EQ(histogram.count(), 1000u);
        EXPECT_NEAR(histogram.mean_s(), 500.5e-6, 1e-12);
        EXPECT_DOUBLE_EQ(histogram.max_s(), 1e-3);
        for (const double share : { 0.01, 0.5, 0.9, 0.999 }) {
            EXPECT_GE(histogram.percentile_s(share), 1e-3 * share * (1 - 1e-12));
            EXPECT_LE(histogram.percentile_s(share), 1e-3 * share * kBin);
        }
        EXPECT_DOUBLE_EQ(histogram.percentile_s(1.0), 1e-3);
    }

    TEST(TickHistogram, EveryValueLiesInItsBin)
    {
        for (const double value : { 0.0, 3e-8, 1e-7, 2.2e-6, 1e-3, 0.9, 5.0, 1e3 }) {
            TickHistogram histogram;
            histogram.add(value);
            const auto bins = histogram.bins();
            ASSERT_EQ(bins.size(), 1u) << value;
            EXPECT_EQ(bins.front().count, 1u);
            EXPECT_LE(bins.front().low_s, value * (1 + 1e-9));
            EXPECT_GE(bins.front().high_s, std::min(value, 10.0) * (1 - 1e-9));
        }
        EXPECT_TRUE(TickHistogram().bins().empty());
        EXPECT_EQ(TickHistogram().percentile_s(0.5), 0.0);
    }

    TEST(TickTimer, CountsPeriodsInWhichNothingBegan)
    {
        // A period so short that every real tick misses some, and one so long that none does.
        TickTimer hasty(1e-9), patient(10.0);
        for (TickTimer* timer : { &hasty, &patient }) {
            EXPECT_EQ(timer->begin(), timer == &hasty ? 1e-9 : 10.0);
            EXPECT_GT(timer->begin(), 0.0);
            EXPECT_EQ(timer->times().ticks, 2u);
        }
        EXPECT_GT(hasty.times().missed, 1u);
        EXPECT_EQ(patient.times().missed, 0u);
    }

    TEST(MeasuredTicks, LeavesOutThePeriodBeforeTheFirstTick)
    {
        struct Nothing : Ticked {
            void tick(double, double) noexcept override { }
        };
        Nothing nothing;
        MeasuredTicks measured(nothing);
        measured.tick(0.0, 1e-3);
        measured.tick(2e-3, 2e-3);
        EXPECT_EQ(measured.periods.count(), 1u);
        EXPECT_DOUBLE_EQ(measured.periods.max_s(), 2e-3);
        EXPECT_DOUBLE_EQ(measured.jitter.max_s(), 1e-3);
        EXPECT_EQ(measured.compute.count(), 2u);
    }

} // namespace tick_timer_test
} // namespace retractor::haptics
