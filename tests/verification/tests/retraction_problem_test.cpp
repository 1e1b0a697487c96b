#include "tests/verification/cli/retraction_problem.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <string>

namespace retractor::verification {
namespace retraction_problem_test {

    TEST(RetractionProblem, TheWholeIntervalDecides)
    {
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        constexpr double kNoBar = std::numeric_limits<double>::infinity();
        const auto verdict = [](double force, double bar) {
            return measured_verdict(force, { .least = 100.0, .most = 400.0, .bar = bar });
        };
        EXPECT_EQ(verdict(200.0, 50.0), "inside");
        EXPECT_EQ(verdict(120.0, 20.0), "inside") << "the ends belong to the range";
        EXPECT_EQ(verdict(120.0, 30.0), "undecided");
        EXPECT_EQ(verdict(560.0, 329.0), "undecided");
        EXPECT_EQ(verdict(250.0, 500.0), "undecided") << "a bar wider than the range";
        EXPECT_EQ(verdict(560.0, 100.0), "outside");
        EXPECT_EQ(verdict(60.0, 20.0), "outside");
        EXPECT_EQ(verdict(200.0, kNoBar), "undecided");
        EXPECT_EQ(verdict(kNone, 10.0), "undecided");
    }

    TEST(RetractionProblem, TheNoteGivesTheForceItsBarAndTheRange)
    {
        constexpr MeasuredForces range { 100.0, 150.0, 400.0, "someone" };
        EXPECT_EQ(beside(500.0, 20.0, range), "500 +- 20 N; measured 100 to 400 N (someone)");
        EXPECT_EQ(beside(80.0, std::numeric_limits<double>::infinity(), range),
            "80 (without a bar) N; measured 100 to 400 N (someone)");
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
