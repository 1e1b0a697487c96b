#include "planner/measures/ranking.h"

#include "planner/measures/rupture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {
namespace ranking_test {

    Candidate candidate(double seen, double seen_bar = 0.0, double incision_mm = 165.0)
    {
        Candidate made;
        made.field.mechanics_status = "converged";
        made.field.seen_best_eye = seen;
        made.field.incision_length_mm = incision_mm;
        made.field.coaxiality_deg = 60.0;
        made.field.opening_width_mm = 40.0;
        made.field.error = ErrorBars {
            .message = {}, .seen_best_eye = seen_bar, .hook_forces_N = {}, .hook_moved_mm = {}, .energy = {}
        };
        return made;
    }

    Weights only(std::string_view key)
    {
        Weights weights {};
        for (std::size_t n = 0; n < kCriteria; ++n)
            weights[n] = criteria()[n].key == key ? 1.0 : 0.0;
        return weights;
    }

    TEST(Ranking, AScoreIsTheWeightedMeanOfTheShares)
    {
        Candidate one = candidate(0.4, 0.1); // shares: 0.4, 0, 0, 0.5, 1, 1, 1
        EXPECT_DOUBLE_EQ(score_of(one, only("seen")).points, 40.0);
        EXPECT_DOUBLE_EQ(score_of(one, only("seen")).bar.value(), 10.0);
        EXPECT_DOUBLE_EQ(score_of(one, only("incision")).points, 50.0);
        // Weights 3, 2, 1, 1, 2, 2, 1, and the sum 12.
        EXPECT_NEAR(score_of(one, default_weights()).points, 100.0 * (3 * 0.4 + 0.5 + 2 + 2 + 1) / 12.0, 1e-12);
        EXPECT_NEAR(score_of(one, default_weights()).bar.value(), 100.0 * (3 + 2) * 0.1 / 12.0, 1e-12)
            << "what instruments reach is at least as uncertain as what is seen";
        one.field.hook_force_N = kRuptureForceN;
        EXPECT_DOUBLE_EQ(score_of(one, only("force")).points, 50.0);
        one.field.force_moments = ForceMoments { .peak_N = 2.0 * kRuptureForceN };
        EXPECT_DOUBLE_EQ(score_of(one, only("force")).points, 0.0) << "the force at the last turn counts";
        one.field.at_risk = { { .name = "internal_thoracic_artery", .distance_mm = 15.0 } };
        one.field.steel_at_risk = { { .name = "heart", .distance_mm = 5.0, .from = "blade 1" } };
        EXPECT_DOUBLE_EQ(score_of(one, only("risk")).points, 25.0) << "the nearest of all";
        one.field.at_risk.push_back({ .name = "mammary_artery_left", .distance_mm = 0.0, .is_assumed = true });
        EXPECT_DOUBLE_EQ(score_of(one, only("risk")).points, 25.0) << "an assumed place earns and costs nothing";
        EXPECT_EQ(crisis_check(one).front(), "The left mammary artery (assumed place) may be cut.");
        one.field.bones = { { .name = "rib_left_4", .utilisation = 0.25 } };
        EXPECT_DOUBLE_EQ(score_of(one, only("bone")).points, 75.0);
        one.divided_bones = { "sternum" };
        EXPECT_DOUBLE_EQ(score_of(one, only("bone")).points, 0.0);
    }

    TEST(Ranking, WhatShowsTooLittleHasNoHighScoreWhateverItSpares)
    {
        const Candidate spares_all = candidate(0.08, 0.0, 60.0);
        Candidate sternotomy = candidate(0.35, 0.0, 210.0);
        sternotomy.divided_bones = { "sternum" };
        EXPECT_GT(score_of(sternotomy, default_weights()).points, score_of(spares_all, default_weights()).points);
        EXPECT_EQ(score_of(candidate(0.0), default_weights()).points, 0.0);
        EXPECT_EQ(score_of(candidate(kEnoughSeen), default_weights()).factor, 1.0);
        EXPECT_DOUBLE_EQ(score_of(candidate(0.5 * kEnoughSeen), default_weights()).factor, 0.5);
        EXPECT_DOUBLE_EQ(score_of(candidate(0.0, 0.0, 165.0), only("incision")).points, 50.0)
            << "who gives what is seen no weight is not overruled";
        // Half of what is enough is seen, give or take a tenth of it: the bar of the mean, and that of the factor.
        const Score at_half = score_of(candidate(0.125, 0.0125), only("seen"));
        EXPECT_NEAR(at_half.points, 0.5 * 12.5, 1e-12);
        EXPECT_NEAR(at_half.bar.value(), 0.5 * 1.25 + 0.05 * 12.5, 1e-12);
    }

    TEST(Ranking, WhatIsNotKnownOrNotThereEarnsNothing)
    {
        Candidate unknown = candidate(0.5);
        unknown.field.bones_message = "the tissue far from the lips was computed as linear";
        EXPECT_DOUBLE_EQ(score_of(unknown, only("bone")).bar.value(), 100.0) << "all or nothing";
        Candidate resected = candidate(0.5);
        resected.field.removed = { { .what = "rib_left_5 between -10 and 10 mm", .label = "rib_left_5" } };
        EXPECT_DOUBLE_EQ(score_of(resected, only("bone")).points, 0.0);
        EXPECT_EQ(crisis_text(resected), "Rib 5 on the left is removed in part.");
        Candidate blind = candidate(0.0);
        blind.field.coaxiality_deg = 0.0;
        EXPECT_DOUBLE_EQ(score_of(blind, only("angle")).points, 0.0) << "nothing is seen, straight or not";
        Candidate failed = candidate(0.9);
        failed.field.inverted_elements = 3;
        failed.field.bones = { { .name = "rib_left_4", .utilisation = 1.2, .opening_at_limit_mm = 38.0 } };
        EXPECT_TRUE(ranked(std::vector { failed }, default_weights()).empty());
        EXPECT_EQ(crisis_text(failed), "Nothing found.") << "what a failed plan foretells is nothing";
        // The bar of the force grows with the force at the last turn.
        Candidate turned = candidate(0.5);
        turned.field.hook_force_N = 50.0;
        turned.field.error->hook_force_N = 5.0;
        turned.field.force_moments = ForceMoments { .peak_N = 100.0 };
        EXPECT_NEAR(score_of(turned, only("force")).bar.value(), 100.0 * 10.0 / (2.0 * kRuptureForceN), 1e-9);
    }

    TEST(Ranking, ValuesBeyondTheirLimitsCountAsTheLimits)
    {
        EXPECT_DOUBLE_EQ(score_of(candidate(0.5, 0.0, 10.0), only("incision")).points, 100.0);
        EXPECT_DOUBLE_EQ(score_of(candidate(0.5, 0.0, 900.0), only("incision")).points, 0.0);
        EXPECT_DOUBLE_EQ(score_of(candidate(0.95, 0.2), only("seen")).bar.value(), 20.0)
            << "downwards the bar is whole";
    }

    TEST(Ranking, TheOrderOfTwoDoesNotHangOnAThird)
    {
        const std::vector<Candidate> two { candidate(0.3), candidate(0.5) };
        const std::vector<Candidate> three { candidate(0.3), candidate(0.5), candidate(1.0) };
        const auto of_two = ranked(two, default_weights()), of_three = ranked(three, default_weights());
        ASSERT_EQ(of_three.size(), 3U);
        EXPECT_EQ(of_two[0].index, 1U);
        EXPECT_EQ(of_three[1].index, 1U);
        EXPECT_EQ(of_two[0].score.points, of_three[1].score.points);
    }

    TEST(Ranking, ALeadWithinBothBarsIsSaid)
    {
        const std::vector<Candidate> close { candidate(0.5, 0.06), candidate(0.4, 0.06) };
        EXPECT_TRUE(ranked(close, only("seen"))[1].within_error);
        const std::vector<Candidate> apart { candidate(0.5, 0.04), candidate(0.4, 0.04) };
        EXPECT_FALSE(ranked(apart, only("seen"))[1].within_error);
        EXPECT_FALSE(ranked(apart, only("seen"))[0].within_error) << "nobody leads the first";
        std::vector<Candidate> drafts { candidate(0.9), candidate(0.1) };
        drafts[1].field.error.reset();
        EXPECT_FALSE(score_of(drafts[1], only("seen")).bar);
        EXPECT_TRUE(ranked(drafts, only("seen"))[1].within_error) << "how sure it is, is not known";
    }

    TEST(Ranking, AFieldThatAnotherBeatsInEverythingIsNamed)
    {
        // The third sees less than the first, and its incision is longer; the second has the shortest.
        const std::vector<Candidate> all { candidate(0.6, 0.0, 100.0), candidate(0.3, 0.0, 50.0),
            candidate(0.5, 0.0, 120.0) };
        for (const RankedField& each : ranked(all, default_weights()))
            EXPECT_EQ(each.dominated_by, each.index == 2 ? std::optional<std::size_t>(0) : std::nullopt) << each.index;
        // What has no weight does not save it.
        EXPECT_EQ(ranked(all, only("seen")).back().dominated_by, 0U);
        const std::vector<Candidate> same { candidate(0.6), candidate(0.6) };
        for (const RankedField& each : ranked(same, default_weights()))
            EXPECT_FALSE(each.dominated_by) << "equal fields do not beat each other";
    }

    TEST(Ranking, WhatWasNotSolvedIsNotRanked)
    {
        std::vector<Candidate> both { candidate(0.9), candidate(0.1) };
        both[0].field.mechanics_status = "not converged";
        const auto order = ranked(both, default_weights());
        ASSERT_EQ(order.size(), 1U);
        EXPECT_EQ(order[0].index, 1U);
        EXPECT_TRUE(ranked({}, default_weights()).empty());
    }

    TEST(CrisisCheck, NamesWhatIsNearWhatBreaksAndWhatIsHeldAside)
    {
        EXPECT_TRUE(crisis_check(candidate(0.5)).empty());
        Candidate one = candidate(0.5);
        one.field.at_risk
            = { { .name = "internal_thoracic_artery", .distance_mm = 4.0 }, { .name = "heart", .distance_mm = 30.0 } };
        one.field.steel_at_risk = { { .name = "lung_left", .distance_mm = 0.0, .from = "blade 1" } };
        one.field.bones = { { .name = "rib_left_4", .utilisation = 1.2, .opening_at_limit_mm = 38.0 } };
        one.field.retracted = { "lung_left", "pericardium" };
        one.field.at_risk.push_back({ .name = "aorta", .distance_mm = 0.0 });
        one.divided_bones = { "sternum" };
        const std::vector<std::string> expected { "The aorta is cut.", "The left lung lies against the blade 1.",
            "The internal thoracic artery lies 4.0 mm from the blade that cuts.", "The sternum is sawn through.",
            "Rib 4 on the left would break from 38 mm on.", "Held aside for this view: left lung, pericardium." };
        EXPECT_EQ(crisis_check(one), expected);
    }

} // namespace ranking_test
} // namespace retractor::planner
