#include "planner/measures/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace comparison_test {

    FieldMetrics field(double seen, double bar, double area_mm2 = 1000.0)
    {
        FieldMetrics made;
        made.target = "aneurysm";
        made.mechanics_status = "converged";
        made.seen_best_eye = seen;
        made.opening_area_mm2 = area_mm2;
        made.opening_width_mm = 40.0;
        made.error = ErrorBars { .message = {},
            .opening_width_mm = 4.0,
            .opening_area_mm2 = 100.0,
            .seen_best_eye = bar,
            .hook_forces_N = {},
            .hook_moved_mm = {},
            .energy = {} };
        return made;
    }

    const ComparedMeasure& measure(const std::vector<ComparedMeasure>& all, std::string_view key)
    {
        return *std::find_if(
            all.begin(), all.end(), [&](const ComparedMeasure& one) { return one.metric->key == key; });
    }

    TEST(Comparison, LeadsBeyondBothBarsOnly)
    {
        const auto leader = [](double first, double second, double bar) {
            return measure(compared_measures({ field(first, bar), field(second, bar) }), "seen_best_eye").leader;
        };
        EXPECT_EQ(leader(0.5, 0.3, 0.09), 0U);
        EXPECT_EQ(leader(0.3, 0.5, 0.09), 1U);
        EXPECT_FALSE(leader(0.5, 0.3, 0.11)) << "the bars touch";
        EXPECT_FALSE(leader(0.5, 0.5, 0.0));
    }

    TEST(Comparison, WithoutBarsOrSolutionNobodyLeads)
    {
        FieldMetrics unknown = field(0.9, 0.01);
        unknown.error.reset();
        EXPECT_FALSE(measure(compared_measures({ unknown, field(0.1, 0.01) }), "seen_best_eye").leader);
        FieldMetrics failed = field(0.9, 0.01);
        failed.mechanics_status = "not converged";
        const std::vector<FieldMetrics> three { failed, field(0.5, 0.01), field(0.1, 0.01) };
        EXPECT_EQ(measure(compared_measures(three), "seen_best_eye").leader, 1U) << "the failed one is no candidate";
        EXPECT_FALSE(measure(compared_measures({ failed, field(0.5, 0.01) }), "seen_best_eye").leader) << "alone";
        EXPECT_TRUE(compared_measures({}).front().numbers.empty());
    }

    TEST(Comparison, OfDifferentTargetsLeavesOutWhatIsSeen)
    {
        FieldMetrics other = field(0.1, 0.01, 3000.0);
        other.target = "clamp site on aorta";
        const std::vector<FieldMetrics> both { field(0.9, 0.01, 1000.0), other };
        EXPECT_FALSE(have_one_target(both));
        const auto measures = compared_measures(both);
        EXPECT_FALSE(measure(measures, "seen_best_eye").leader);
        EXPECT_EQ(measure(measures, "opening_area_mm2").leader, 1U);
        EXPECT_EQ(measure(measures, "seen_best_eye").numbers[1].value, 0.1) << "the numbers are shown";
        EXPECT_EQ(measure(measures, "seen_best_eye").numbers[1].bar, 0.01);
    }

    TEST(Comparison, SitesOfOneNameAtTwoPlacesAreTwoTargets)
    {
        std::vector<FieldMetrics> both { field(0.9, 0.01), field(0.1, 0.01) };
        for (FieldMetrics& one : both) {
            one.target = "anastomosis site on heart";
            one.target_spec = { .label = "heart", .centre = Vec3(1.0, 2.0, 3.0), .radius_mm = 8.0, .site = "annulus" };
        }
        EXPECT_TRUE(have_one_target(both));
        both.back().target_spec.centre.x() += 60.0;
        EXPECT_FALSE(have_one_target(both));
        EXPECT_FALSE(measure(compared_measures(both), "seen_best_eye").leader);
        both.back().target_spec = both.front().target_spec;
        both.back().target_spec.radius_mm = 20.0;
        EXPECT_FALSE(have_one_target(both));
    }

    FieldMetrics with_conditions(double seen, double higher, std::vector<LungSight> lungs)
    {
        FieldMetrics made = field(seen, 0.01);
        made.if_organs_shift = { { .shift_mm = 10.0, .seen_best_eye = higher } };
        made.if_lung_keeps = std::move(lungs);
        return made;
    }

    TEST(Comparison, SaysWhenAnotherApproachShowsMostUnderOtherConditions)
    {
        const FieldMetrics a = with_conditions(0.50, 0.20, { { 0.2, 0.60 }, { 0.5, 0.10 } });
        const FieldMetrics b = with_conditions(0.40, 0.30, {}); // no lung is held aside
        EXPECT_EQ(sight_order_sentences({ a, b }),
            (std::vector<std::string> { "With the organs 10 mm nearer to the head, B shows most (30 %), not A (20 %).",
                "With lungs of 50 % of their volume, B shows most (40 %), not A (10 %)." }));
        const FieldMetrics far_behind = with_conditions(0.05, 0.02, {});
        EXPECT_EQ(sight_order_sentences({ a, far_behind }),
            (std::vector<std::string> {
                "A shows most also when patient, organs or lungs lie otherwise: from 10 % with lungs of 50 % "
                "of their volume to 60 % with lungs of 20 % of their volume." }));
        const FieldMetrics as_good = with_conditions(0.45, 0.205, {}); // within the error of the samples
        EXPECT_EQ(sight_order_sentences({ a, as_good }).size(), 1U) << "the lungs alone";
    }

    TEST(Comparison, ComparesBothSidesWithTheirOwnSideUp)
    {
        FieldMetrics left = field(0.50, 0.01), right = field(0.40, 0.01);
        left.if_turned = { { 0.0, 0.10 }, { 30.0, 0.45 } };
        right.if_turned = { { 0.0, 0.30 }, { -30.0, 0.35 } };
        EXPECT_EQ(sight_order_sentences({ left, right }),
            (std::vector<std::string> { "With the patient supine, B shows most (30 %), not A (10 %)." }));
    }

    TEST(Comparison, SaysNothingOfConditionsThatWereNotMeasuredOrCannotBeCompared)
    {
        const FieldMetrics a = with_conditions(0.50, 0.20, {});
        EXPECT_TRUE(sight_order_sentences({ a, with_conditions(0.495, 0.1, {}) }).empty()) << "none leads";
        EXPECT_TRUE(sight_order_sentences({ with_conditions(0, 0, {}), with_conditions(0, 0, {}) }).empty());
        EXPECT_TRUE(sight_order_sentences({ a }).empty());
        EXPECT_TRUE(sight_order_sentences({ a, field(0.4, 0.01) }).empty()) << "B was not measured";
        EXPECT_TRUE(sight_order_sentences({ field(0.5, 0.01), field(0.4, 0.01) }).empty());
        FieldMetrics other = with_conditions(0.4, 0.3, {});
        other.target = "coronary";
        EXPECT_TRUE(sight_order_sentences({ a, other }).empty());
        FieldMetrics failed = with_conditions(0.9, 0.9, {});
        failed.mechanics_status = "not converged";
        const FieldMetrics b = with_conditions(0.4, 0.3, {});
        EXPECT_EQ(sight_order_sentences({ failed, a, b }).front(),
            "With the organs 10 mm nearer to the head, C shows most (30 %), not B (20 %).");
    }

} // namespace comparison_test
} // namespace retractor::planner
