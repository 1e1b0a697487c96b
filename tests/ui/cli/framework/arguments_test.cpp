#include "ui/cli/framework/arguments.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

namespace retractor::ui::cli {
namespace arguments_test {

    constexpr planner::AccuracyGoal kOtherwise { .force = 0.3, .opening_mm = 1.25, .time_s = 900.0 };
    constexpr double kRoundOff = 1e-15; ///< of a hundredth

    TEST(Arguments, AnAccuracyIsAShareOfTheForceAndMillimetres)
    {
        const auto both = parse_accuracy("15%,2", kOtherwise);
        ASSERT_TRUE(both);
        EXPECT_NEAR(both->force, 0.15, kRoundOff);
        EXPECT_EQ(both->opening_mm, 2.0);
        EXPECT_EQ(both->time_s, 900.0);
        const auto force_alone = parse_accuracy("7.5%", kOtherwise);
        ASSERT_TRUE(force_alone);
        EXPECT_NEAR(force_alone->force, 0.075, kRoundOff);
        EXPECT_EQ(force_alone->opening_mm, 1.25);
        EXPECT_FALSE(parse_accuracy("none", kOtherwise));
    }

    TEST(Arguments, AnAccuracyThatIsNoneIsRefusedByItsOption)
    {
        for (const char* wrong : { "", "15", "0.15,2", "%", "15%,", "15%2", "15%,2,3", "15%,two", "15 %", "nan%",
                 "inf%", "None", "15%%", "15%,2%" })
            try {
                static_cast<void>(parse_accuracy(wrong, kOtherwise));
                ADD_FAILURE() << "not refused: \"" << wrong << "\"";
            } catch (const InputError& error) {
                EXPECT_EQ(error.where(), "--accuracy") << wrong;
            }
    }

} // namespace arguments_test
} // namespace retractor::ui::cli
