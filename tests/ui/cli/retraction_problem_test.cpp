#include "ui/cli/retraction_problem.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

namespace retractor {
namespace {

    TEST(RetractionProblem, ForcesAreJudgedByTheNearerEndOfWhatWasMeasured)
    {
        constexpr MeasuredForces range { 100.0, 150.0, 400.0, "" };
        EXPECT_EQ(outside(100.0, range), 0.0);
        EXPECT_EQ(outside(399.0, range), 0.0);
        EXPECT_DOUBLE_EQ(outside(50.0, range), 1.0); // half the least
        EXPECT_DOUBLE_EQ(outside(800.0, range), 1.0); // twice the most
        for (const double none : { 0.0, -200.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_TRUE(std::isnan(outside(none, range))) << none;
    }

    TEST(RetractionProblem, StopsWhenCancelled)
    {
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(retraction_problem().run({}, job).empty());
    }

} // namespace
} // namespace retractor
