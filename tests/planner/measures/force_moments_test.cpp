#include "planner/measures/force_moments.h"

#include "planner/measures/metrics.h"
#include "planner/measures/rupture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>

namespace retractor::planner {
namespace force_moments_test {

    constexpr double kRoundOff = 1e-12; ///< relative, of sums with some ten terms

    /// Two opposite hooks, each moved by half of the opening.
    FieldMetrics opened(double opening_mm, double force_N)
    {
        FieldMetrics field;
        field.name = "median";
        for (const int side : { 1, -1 })
            field.hooks.push_back({ .name = side > 0 ? "left" : "right",
                .side = side,
                .force_N = force_N,
                .moved_mm = 0.5 * opening_mm,
                .asked_mm = 0.5 * opening_mm });
        field.hook_force_N = force_N;
        return field;
    }

    ForceMoments moments_of(const FieldMetrics& field, const OpeningProtocol& protocol = {})
    {
        return compute_force_moments(field, protocol).value();
    }

    TEST(ForceMoments, ThePlansForceIsThatAtTheLastTurnOfASlowOpening)
    {
        for (const double opening : { 5.0, 40.0, 75.0 })
            EXPECT_NEAR(moments_of(opened(opening, 260.0)).peak_N, 260.0, kRoundOff * 260.0) << opening;
        EXPECT_EQ(compute_force_moments(opened(60.0, 260.0), {})->protocol, moments_of(opened(60.0, 260.0)).protocol);
    }

    TEST(ForceMoments, OneTurnIsAStep)
    {
        const ForceMoments moments = moments_of(opened(7.0, 100.0));
        EXPECT_EQ(moments.opened_in_s, 0.0);
        EXPECT_NEAR(moments.held_N, 100.0 * (0.05 + 0.30 * std::exp(-20.0) + 0.65 * std::exp(-2.0)), kRoundOff * 100.0);
    }

    TEST(ForceMoments, TheCrankStepsAreAGeometricSum)
    {
        // n equal steps with a wait w: each term is g (1 - q^n) / (n (1 - q)), q = exp(-w / tau).
        const OpeningProtocol protocol { .wait_s = 25.0 };
        const int n = step_count(protocol, 60.0);
        ASSERT_EQ(n, 9);
        double share = chest_wall_relaxation().long_term;
        for (const PronyTerm& term : chest_wall_relaxation().terms) {
            const double q = std::exp(-protocol.wait_s / term.time_s);
            share += term.share * (1.0 - std::pow(q, n)) / (n * (1.0 - q));
        }
        EXPECT_NEAR(last_turn_share(chest_wall_relaxation(), protocol, 60.0), share, kRoundOff);
    }

    TEST(ForceMoments, OfManySmallStepsAreThoseOfARamp)
    {
        // Steps at the beginnings of equal intervals: the rectangle rule, whose error is at most one step of the force.
        const OpeningProtocol protocol { .turn_mm = 1.0, .turns_per_step = 0.05, .wait_s = 0.1 };
        const double ramp_s = opening_time(protocol, 60.0);
        EXPECT_NEAR(last_turn_share(chest_wall_relaxation(), protocol, 60.0),
            ramp_force(chest_wall_relaxation(), 1.0, ramp_s, ramp_s), 1.0 / step_count(protocol, 60.0));
    }

    TEST(ForceMoments, TheForceIsLargestAtTheLastTurnAndLargerTheFasterTheCrank)
    {
        const OpeningProtocol protocol { .wait_s = 40.0 };
        const auto steps = crank_steps(protocol, 60.0, 1.0);
        for (std::size_t k = 1; k < steps.size(); ++k)
            EXPECT_GT(stepped_force(chest_wall_relaxation(), steps, steps[k].at_s),
                stepped_force(chest_wall_relaxation(), steps, steps[k - 1].at_s));
        double last = moments_of(opened(60.0, 260.0), { .wait_s = 0.0 }).peak_N;
        for (const double wait_s : { 5.0, 10.0, 40.0, 3600.0 }) {
            const ForceMoments moments = moments_of(opened(60.0, 260.0), { .wait_s = wait_s });
            EXPECT_LT(moments.peak_N, last) << wait_s;
            EXPECT_LT(moments.held_N, moments.peak_N);
            EXPECT_LE(moments.held_least_N, moments.held_N);
            EXPECT_GE(moments.held_most_N, moments.held_N);
            last = moments.peak_N;
        }
        // Held at once, nothing has relaxed.
        const ForceMoments at_once = moments_of(opened(60.0, 260.0), { .hold_s = 0.0 });
        EXPECT_EQ(at_once.held_N, at_once.peak_N);
    }

    TEST(ForceMoments, AreNotApplicableWhereTheForceIsGiven)
    {
        FieldMetrics field = opened(60.0, 40.0);
        field.hooks[1].pull.force_N = 40.0;
        field.force_moments = compute_force_moments(field, {});
        EXPECT_NE(
            force_moments_text(field).find("not applicable: hook right pulls with a given force"), std::string::npos)
            << force_moments_text(field);
        const auto document = metrics_document({ field }).at("approaches").at(0).at("force_moments");
        EXPECT_TRUE(document.contains("message"));
        EXPECT_FALSE(document.contains("peak_N"));

        field = opened(60.0, 40.0);
        field.hooks[0].yielded = true;
        EXPECT_FALSE(moments_of(field).message.empty());
        field = opened(60.0, 40.0);
        field.hooks[0].pull.grip_N_per_mm = 5.0;
        EXPECT_FALSE(moments_of(field).message.empty());
        field = opened(60.0, 40.0);
        field.retractor = RetractorMetrics { .kind = "sternal", .asked_force_N = 40.0, .opening_mm = 60.0 };
        EXPECT_FALSE(moments_of(field).message.empty());

        EXPECT_FALSE(compute_force_moments({}, {})); // no hooks
        EXPECT_FALSE(compute_force_moments(opened(60.0, 0.0), {}));
        EXPECT_TRUE(force_moments_text(FieldMetrics {}).empty());
    }

    TEST(ForceMoments, TheTextAndTheDocumentNameTheMoments)
    {
        FieldMetrics field = opened(60.0, 260.0);
        field.force_moments = compute_force_moments(field, {});
        const std::string text = force_moments_text(field);
        for (const char* part : { "260 N at the last turn", "after 5 minutes", "between animals",
                 "half a turn of the crank (7 mm) every 10 s", "in 80 s" })
            EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
        const auto document = metrics_document({ field }).at("approaches").at(0).at("force_moments");
        EXPECT_EQ(document.at("peak_N").get<double>(), field.force_moments->peak_N);
        EXPECT_EQ(document.at("held_N").get<double>(), field.force_moments->held_N);
        EXPECT_EQ(document.at("opened_in_s").get<double>(), 80.0);
        EXPECT_EQ(document.at("held_for_s").get<double>(), 300.0);
        EXPECT_FALSE(document.at("faster_than_half_a_turn_in_10_s").get<bool>());
        EXPECT_NE(document.at("source").get<std::string>().find("Bolotin 2007"), std::string::npos);
    }

    TEST(ForceMoments, AFastCrankIsACaution)
    {
        FieldMetrics field = opened(60.0, 120.0);
        field.force_moments = compute_force_moments(field, {});
        EXPECT_TRUE(fast_opening_text(field).empty());
        EXPECT_FALSE(may_rupture(field)) << "120 N";
        field.force_moments = compute_force_moments(field, OpeningProtocol { .wait_s = 5.0 });
        EXPECT_NE(fast_opening_text(field).find("every 5 s"), std::string::npos) << fast_opening_text(field);
        EXPECT_TRUE(may_rupture(field)) << "faster, and so with more than 122.5 N";
        field.force_moments = compute_force_moments(field, OpeningProtocol { .wait_s = 60.0 });
        field.hook_force_N = 130.0;
        EXPECT_TRUE(may_rupture(field)) << "a slow opening takes no caution away";
    }

} // namespace force_moments_test
} // namespace retractor::planner
