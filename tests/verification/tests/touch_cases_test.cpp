#include "tests/verification/cli/touch_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace retractor::verification {
namespace touch_cases_test {

    TEST(TouchCases, EndInARightAnswerOrInARefusalThatSaysWhy)
    {
        const std::vector<StabilityRow> rows = run_stability(touch_cases(), Job {});
        for (const StabilityRow& row : rows)
            EXPECT_TRUE(row.passed()) << row.problem << ", " << row.model << ": " << outcome_name(row.outcome)
                                      << ", error " << row.error << " (bound " << row.bound << ") " << row.reason;
        // Each kind of tissue runs the cases of the list of extreme cases.
        for (const std::string name :
            { "device jumps by 100 mm in one tick", "device stops answering", "device reports a place of NaN" })
            EXPECT_EQ(std::count_if(rows.begin(), rows.end(),
                          [&](const StabilityRow& row) {
                              return row.problem == name && row.outcome == StabilityOutcome::refused;
                          }),
                3)
                << name;
    }

} // namespace touch_cases_test
} // namespace retractor::verification
