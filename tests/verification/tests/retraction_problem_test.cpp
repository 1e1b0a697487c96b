#include "tests/verification/cli/retraction_problem.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <string>

namespace retractor::verification {
namespace retraction_problem_test {

    TEST(RetractionProblem, ForcesAreJudgedByTheNearerEndOfWhatWasMeasured)
    {
        constexpr MeasuredForces range { 100.0, 150.0, 400.0, "" };
        EXPECT_EQ(outside(100.0, range), 0.0);
        EXPECT_EQ(outside(399.0, range), 0.0);
        EXPECT_DOUBLE_EQ(outside(50.0, range), 1.0); // half the lower end
        EXPECT_DOUBLE_EQ(outside(800.0, range), 1.0); // twice the upper end
        for (const double none : { 0.0, -200.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_TRUE(std::isnan(outside(none, range))) << none;
    }

    TEST(RetractionProblem, TheNoteSaysWhereAForceLiesAndHowFarItMay)
    {
        constexpr MeasuredForces range { 100.0, 150.0, 400.0, "someone" };
        const std::string above = beside(500.0, range);
        EXPECT_NE(above.find("ABOVE: 1.25 times the largest measured"), std::string::npos) << above;
        EXPECT_NE(above.find("a factor of 2 outside, 50 to 800 N"), std::string::npos) << above;
        EXPECT_NE(beside(80.0, range).find("BELOW: the smallest measured is 1.25 times that"), std::string::npos);
        EXPECT_NE(beside(200.0, range).find("200 N, within what was measured; measured 100 to 400 N (someone)"),
            std::string::npos);
    }

    TEST(RetractionProblem, StopsWhenCancelled)
    {
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(retraction_problem().run({}, job).empty());
    }

} // namespace retraction_problem_test
} // namespace retractor::verification
