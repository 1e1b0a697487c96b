#include "planner/measures/rupture.h"

#include <gtest/gtest.h>

namespace retractor::planner {
namespace rupture_test {

    /// Two opposite hooks, each moved by half of the opening.
    FieldMetrics opened(double opening_mm, double force_N)
    {
        FieldMetrics field;
        for (const int side : { 1, -1 })
            field.hooks.push_back({ .name = side > 0 ? "left" : "right",
                .side = side,
                .force_N = force_N,
                .moved_mm = 0.5 * opening_mm,
                .asked_mm = 0.5 * opening_mm });
        field.hook_force_N = force_N;
        return field;
    }

    TEST(Rupture, IsPossibleOnlyBeyondBothValues)
    {
        EXPECT_FALSE(may_rupture(opened(29.0, 400.0)));
        EXPECT_FALSE(may_rupture(opened(60.0, 120.0)));
        EXPECT_TRUE(may_rupture(opened(31.0, 125.0)));
        EXPECT_TRUE(rupture_text(opened(29.0, 400.0)).empty());
    }

    TEST(Rupture, IsThatOfRibSpreaders)
    {
        FieldMetrics field = opened(45.0, 203.0);
        field.force_moments = ForceMoments { .protocol = "fast", .is_fast = true };
        for (HookForce& hook : field.hooks)
            hook.bears_on = { "rib_left_4", "sternum" };
        EXPECT_FALSE(may_rupture(field)) << "the sternum is parted";
        EXPECT_EQ(fast_opening_text(field), "");
        field.hooks.front().bears_on = { "rib_left_5" };
        EXPECT_TRUE(may_rupture(field)) << "a space that begins at the sternum";
        EXPECT_NE(fast_opening_text(field), "");
    }

    TEST(Rupture, TheTextNamesOpeningForceAndSource)
    {
        const std::string text = rupture_text(opened(45.0, 203.0));
        for (const char* part : { "45.0 mm", "203 N", "30 mm", "122.5 N", "Chanoit 2019" })
            EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
    }

} // namespace rupture_test
} // namespace retractor::planner
