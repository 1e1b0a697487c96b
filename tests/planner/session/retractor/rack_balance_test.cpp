#include "planner/session/retractor/rack_balance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::planner {
namespace rack_balance_test {

    /// Two lips as springs: the blades are 20 mm apart.
    struct Lips {
        double first_N_per_mm = 1.0, second_N_per_mm = 1.0, second_hardening = 0.0;
        double opening_mm = 20.0;

        std::pair<double, double> forces(double shift_mm) const
        {
            const double first = 0.5 * opening_mm + shift_mm, second = 0.5 * opening_mm - shift_mm;
            return { first_N_per_mm * first, second_N_per_mm * second * (1.0 + second_hardening * second) };
        }
    };

    int steps_to_rest(RackBalance& balance, const Lips& lips)
    {
        for (int i = 0; i < 20; ++i) {
            const auto [first, second] = lips.forces(balance.shift_mm());
            if (!balance.step(first, second))
                return i;
        }
        return 20;
    }

    TEST(RackBalance, LinearLipsNeedTwoSteps)
    {
        RackBalance balance;
        const Lips lips { .first_N_per_mm = 1.0, .second_N_per_mm = 3.0 };
        EXPECT_EQ(steps_to_rest(balance, lips), 2);
        EXPECT_NEAR(balance.shift_mm(), 5.0, 1e-9); // 1 * 15 = 3 * 5
        // Opened further, the shift is known.
        balance.open(20.0, 40.0);
        EXPECT_EQ(steps_to_rest(balance, { .first_N_per_mm = 1.0, .second_N_per_mm = 3.0, .opening_mm = 40.0 }), 0);
        EXPECT_NEAR(balance.shift_mm(), 10.0, 1e-9);
    }

    TEST(RackBalance, HardeningLipsComeToRestToo)
    {
        RackBalance balance;
        const Lips lips { .first_N_per_mm = 1.0, .second_N_per_mm = 2.0, .second_hardening = 0.05 };
        EXPECT_LE(steps_to_rest(balance, lips), 6);
        const auto [first, second] = lips.forces(balance.shift_mm());
        EXPECT_NEAR(first, second, RackBalance::kTolerance * std::max(first, second));
    }

    TEST(RackBalance, NothingToBalanceMovesNothing)
    {
        RackBalance balance;
        EXPECT_FALSE(balance.step(0.01, 0.0));
        EXPECT_FALSE(balance.step(std::numeric_limits<double>::quiet_NaN(), 1.0));
        EXPECT_FALSE(balance.step(100.0, 99.0));
        EXPECT_EQ(balance.shift_mm(), 0.0);
    }

} // namespace rack_balance_test
} // namespace retractor::planner
