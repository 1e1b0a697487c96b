#include "haptics/training/trial_statistics.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

using namespace retractor;
using namespace retractor::haptics;

TEST(BoxNumbers, ofKnownValues)
{
    const std::array<double, 5> values { 5.0, 1.0, 4.0, 2.0, 3.0 };
    const BoxNumbers box = box_numbers(values);
    EXPECT_EQ(box.low, 1.0);
    EXPECT_EQ(box.lower_quartile, 2.0);
    EXPECT_EQ(box.median, 3.0);
    EXPECT_EQ(box.upper_quartile, 4.0);
    EXPECT_EQ(box.high, 5.0);
    EXPECT_DOUBLE_EQ(box_numbers(std::array { 1.0, 2.0, 3.0, 4.0 }).median, 2.5);
}

TEST(FTest, ofEqualAndOfDifferentSpreads)
{
    const std::array<double, 5> narrow { 1.0, 1.1, 0.9, 1.05, 0.95 };
    std::array<double, 5> wide {};
    for (std::size_t i = 0; i < 5; ++i)
        wide[i] = 5.0 + 10.0 * narrow[i];
    const FTest test = f_test(wide, narrow);
    EXPECT_NEAR(test.F, 100.0, 1e-9);
    // With 4 and 4 degrees of freedom the upper tail is 1 - x^2 (3 - 2 x), x = F / (F + 1).
    const double x = 100.0 / 101.0;
    EXPECT_NEAR(test.p, 2.0 * (1.0 - x * x * (3.0 - 2.0 * x)), 1e-12);
    EXPECT_NEAR(f_test(narrow, narrow).p, 1.0, 1e-12);
    EXPECT_NEAR(f_test(narrow, wide).p, test.p, 1e-12);
}

TEST(TTest, ofKnownSamples)
{
    // Differences 1, 2, 3: t = 2 / (1 / sqrt 3), two degrees of freedom: p = 1 - t / sqrt(2 + t^2).
    const TTest paired = paired_t_test(std::array { 2.0, 4.0, 6.0 }, std::array { 1.0, 2.0, 3.0 });
    const double t = 2.0 * std::sqrt(3.0);
    EXPECT_NEAR(paired.t, t, 1e-12);
    EXPECT_NEAR(paired.p, 1.0 - t / std::sqrt(2.0 + t * t), 1e-12);
}

TEST(TrialStatistics, refuseWhatSaysNothing)
{
    EXPECT_EQ(test_support::message_of([] {
        (void)f_test(std::array { 1.0 }, std::array { 1.0, 2.0 });
    }),
        "a sample of 1 is too small: 2 values are needed");
    EXPECT_EQ(test_support::message_of([] {
        (void)f_test(std::array { 1.0, 1.0 }, std::array { 1.0, 2.0 });
    }),
        "an F-test needs samples that vary");
    EXPECT_EQ(test_support::message_of([] {
        (void)paired_t_test(std::array { 1.0, 1.0 }, std::array { 1.0, 2.0, 3.0 });
    }),
        "a paired t-test needs two values of each person, got 2 and 3");
    EXPECT_EQ(
        test_support::message_of([] { (void)box_numbers(std::array { std::numeric_limits<double>::quiet_NaN() }); }),
        "a sample holds a value that is not finite");
}
