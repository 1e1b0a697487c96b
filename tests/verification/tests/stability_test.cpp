// The extreme cases of `retractor-verify --suite stability`: each is the case that its name says, and passes.

#include "mesh/base/error.h"
#include "tests/verification/framework/stability.h"
#include "tests/verification/problem_list.h"
#include "tests/verification/stability/stability_families.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::verification {
namespace stability_test {

    std::vector<StabilityRow> rows_of(const StabilityCase& c)
    {
        std::vector<StabilityRow> rows = run_stability({ c }, Job {});
        EXPECT_FALSE(rows.empty()) << c.name;
        for (const StabilityRow& row : rows) {
            EXPECT_TRUE(row.passed()) << row.problem << ", " << row.model << ": " << outcome_name(row.outcome)
                                      << ", residual " << row.residual << ", error " << row.error << " (bound "
                                      << row.bound << ") " << row.reason;
            if (row.outcome == StabilityOutcome::answered) {
                EXPECT_LE(row.residual, 1e-3) << row.problem << ", " << row.model; // the loosest tolerance in use
            }
        }
        return rows;
    }

    bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

    TEST(Stability, ExtremeCasesEndInARightAnswerOrInARefusalThatSaysWhy)
    {
        std::vector<StabilityCase> cases = stability_cases();
        for (const StabilityCase& own : { incompressible_case(), hundred_cuts_case(), far_hook_case() }) // tested below
            EXPECT_EQ(std::erase_if(cases, [&](const StabilityCase& c) { return c.name == own.name; }), 1U) << own.name;
        for (const StabilityCase& c : cases)
            (void)rows_of(c);
    }

    TEST(Stability, NearlyIncompressibleTheRightElementIsAtMostTwiceAsFarOff)
    {
        constexpr double kPromised = 2.0; // times the error of the mild case
        const std::vector<StabilityRow> rows = rows_of(incompressible_case());
        for (const std::string model : { "locking-free P1, linear" }) {
            std::vector<StabilityRow> series;
            std::copy_if(rows.begin(), rows.end(), std::back_inserter(series),
                [&](const StabilityRow& row) { return row.model == model; });
            ASSERT_EQ(series.size(), 3U) << model;
            EXPECT_TRUE(holds(series[0].problem, "mild"));
            for (const StabilityRow& row : series) {
                EXPECT_LE(row.error, kPromised * series[0].error) << row.problem;
            }
            EXPECT_TRUE(holds(series[1].problem, "0.4999"));
            EXPECT_TRUE(holds(series[2].problem, "0.49999"));
        }
        for (const StabilityRow& row : rows)
            if (row.model.starts_with("P2") && !holds(row.problem, "mild")) {
                EXPECT_TRUE(holds(row.reason, "not the element promised")) << row.problem;
            }
    }

    TEST(Stability, AHundredCutsInOnePlaceAreAHundred)
    {
        const std::vector<StabilityRow> rows = rows_of(hundred_cuts_case());
        int all_made = 0;
        for (const StabilityRow& row : rows) {
            EXPECT_TRUE(std::isfinite(row.error) && std::isfinite(row.bound)) << row.problem << ": nothing was judged";
            EXPECT_TRUE(holds(row.quantity, "displacement") || holds(row.quantity, "linear field")) << row.quantity;
            EXPECT_TRUE(std::isfinite(row.condition)) << row.problem;
            all_made += holds(row.reason, "100 of 100 cuts made") ? 1 : 0;
            if (holds(row.problem, "crossing") || holds(row.problem, "slices")) {
                EXPECT_EQ(row.outcome, StabilityOutcome::refused);
                EXPECT_TRUE(holds(row.reason, "element_limit")) << row.reason;
            }
        }
        EXPECT_EQ(all_made, 1) << "those from one line";
    }

    TEST(Stability, HooksPulledTooFarSayWhyFirstWhateverTheLaw)
    {
        const std::vector<StabilityRow> rows = rows_of(far_hook_case());
        EXPECT_EQ(rows.size(), 6U);
        for (const std::string model : { "P1, linear", "P1, corotational", "P1, neo-Hookean" })
            EXPECT_EQ(
                std::count_if(rows.begin(), rows.end(), [&](const StabilityRow& r) { return r.model == model; }), 2)
                << model;
        for (const StabilityRow& row : rows)
            if (row.outcome == StabilityOutcome::refused) {
                EXPECT_FALSE(row.reason.starts_with("converged")) << row.reason;
            }
    }

    TEST(Stability, ARefusalIsJudgedByWhatItMeasured)
    {
        const auto refusal = [](double error, double bound) {
            return expect_refusal("case", "model", "no", [=](StabilityRow& row) {
                row.unconditioned = Unconditioned::no_matrix;
                row.error = error;
                row.bound = bound;
                refuse(row, "no equilibrium");
            });
        };
        constexpr double kNone = std::numeric_limits<double>::infinity(),
                         kNan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_TRUE(refusal(0.05, 0.1).passed());
        EXPECT_FALSE(refusal(0.2, 0.1).passed()) << "it refused at the wrong place";
        EXPECT_FALSE(refusal(kNan, 0.1).passed()) << "it was to be measured";
        EXPECT_TRUE(refusal(kNan, kNone).passed());
        EXPECT_TRUE(refusal(0.2, kNone).passed());
    }

    TEST(Stability, WhereARefusalMayComeItMustBeTheOneNamed)
    {
        const auto ended = [](const std::string& reason) {
            return expect_answer_or_refusal("case", "model", "inside out", [=](StabilityRow& row) {
                row.unconditioned = Unconditioned::no_matrix;
                row.residual = row.error = 0.0;
                if (!reason.empty())
                    refuse(row, reason);
            });
        };
        EXPECT_TRUE(ended("").passed());
        EXPECT_TRUE(ended("2 elements inside out").passed());
        EXPECT_FALSE(ended("not converged").passed());
    }

} // namespace stability_test
} // namespace retractor::verification
