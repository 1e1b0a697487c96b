#include "tests/verification/cli/viscous_problem.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>

namespace retractor::verification {
namespace viscous_problem_test {

    TEST(ViscousProblem, ElementsCreepAndRelaxAsTheClosedFormsWithTheOrderOfTheStep)
    {
        std::map<std::string, std::vector<VerificationRow>> of;
        for (const VerificationRow& row : viscous_problem().run({}, Job {})) {
            EXPECT_TRUE(row.passed()) << row.problem << ": " << row.error << " > " << row.bound;
            of[row.problem].push_back(row);
        }
        ASSERT_EQ(of.size(), 4U);
        constexpr double kOff = 0.1; // tolerance of the order, at steps of a few thousandths of the shortest time
        for (const auto& [name, series] : of) {
            ASSERT_EQ(series.size(), 3U) << name;
            EXPECT_TRUE(std::isfinite(series.back().bound)) << name;
            if (name.find("held") != std::string::npos)
                continue; // this quantity is exact at any step
            for (std::size_t i = 1; i < series.size(); ++i)
                EXPECT_NEAR(series[i].order, 1.0, kOff) << name;
        }
    }

    TEST(ViscousProblem, StopsWhenCancelled)
    {
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(viscous_problem().run({}, job).empty());
    }

} // namespace viscous_problem_test
} // namespace retractor::verification
