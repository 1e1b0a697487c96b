// Tests that the forces of a retractor by hand are matched to a plan where the wound is as planned, and nowhere else.

#include "planner/session/retractor/force_match.h"

#include "planner/session/surgery_session.h"
#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

namespace retractor::planner {
namespace force_match_test {

    const PlannedForce kPlan {
        .retractor = "finochietto", .opening_mm = 30.0, .force_N = 108.0, .low_N = 74.0, .high_N = 142.0
    };

    HookReport opened(double opening_mm, double force_N)
    {
        HookReport report;
        report.retractors.push_back(
            { .kind = "finochietto", .opening_mm = opening_mm, .blade_N = { force_N, force_N }, .force_N = force_N });
        report.hooks.resize(2);
        report.hooks[0].name = "planned left blade";
        report.hooks[1].name = "planned right blade";
        report.hooks[0].force_N = Vec3(0.0, 0.0, force_N);
        report.hooks[1].force_N = Vec3(0.0, 0.0, -force_N);
        report.side_N = { force_N, force_N };
        return report;
    }

    TEST(ForceMatch, IsFoundWhereTheRetractorIsAsPlanned)
    {
        EXPECT_DOUBLE_EQ(force_match(opened(30.0, 54.0), kPlan).value(), 2.0);
        EXPECT_DOUBLE_EQ(force_match(opened(30.4, 216.0), kPlan).value(), 0.5);
        EXPECT_FALSE(force_match(opened(25.0, 54.0), kPlan)) << "another opening";
        EXPECT_FALSE(force_match(opened(30.0, 0.0), kPlan));
        EXPECT_FALSE(force_match(opened(30.0, -54.0), kPlan)) << "it holds the lips back";
        EXPECT_FALSE(force_match(opened(30.0, kPlan.force_N / (1.01 * kMostMatched)), kPlan)) << "too far off";
        EXPECT_FALSE(force_match(opened(30.0, kPlan.force_N * 1.01 * kMostMatched), kPlan));
    }

    TEST(ForceMatch, IsNotFoundForAnotherRetractorNorWhereItIsNotAtRest)
    {
        HookReport other = opened(30.0, 54.0);
        other.retractors.front().kind = "sternal";
        EXPECT_FALSE(force_match(other, kPlan));
        HookReport with_hook = opened(30.0, 54.0);
        with_hook.hooks.emplace_back();
        EXPECT_FALSE(force_match(with_hook, kPlan)) << "a hook helps it";
        HookReport two = opened(30.0, 54.0);
        two.retractors.push_back(two.retractors.front());
        EXPECT_FALSE(force_match(two, kPlan));
        HookReport restless = opened(30.0, 54.0);
        restless.retractors.front().imbalance = 0.2;
        EXPECT_FALSE(force_match(restless, kPlan));
        HookReport slips = opened(30.0, 54.0);
        slips.hooks[1].yielded = true;
        EXPECT_FALSE(force_match(slips, kPlan));
        HookReport by_hand = opened(30.0, 54.0);
        by_hand.hooks[0].name = "upper blade";
        EXPECT_FALSE(force_match(by_hand, kPlan)) << "set where the hand wanted it";
        HookReport refused = opened(30.0, 54.0);
        refused.refusal = "a piece is held by nothing";
        EXPECT_FALSE(force_match(refused, kPlan));
        EXPECT_FALSE(force_match({}, kPlan));
    }

    TEST(ForceMatch, AllForcesAreMultipliedAndNothingElse)
    {
        HookReport report = opened(20.0, 40.0);
        report.strain.p99 = 0.3;
        multiply_forces(report, 2.0);
        EXPECT_EQ(report.force_factor, 2.0);
        EXPECT_EQ(report.retractors.front().force_N, 80.0);
        EXPECT_EQ(report.retractors.front().blade_N[1], 80.0);
        EXPECT_EQ(report.retractors.front().opening_mm, 20.0);
        EXPECT_EQ(report.hooks[1].force_N.z(), -80.0);
        EXPECT_EQ(report.side_N[0], 80.0);
        EXPECT_EQ(report.strain.p99, 0.3);
    }

    constexpr double kOpeningMm = 12.0, kPlannedN = 33.0; // N: any force within kMostMatched of the wall's

    /// The slab with a planned incision and retractor, and what their plan says.
    SurgerySetup planned_slab(std::optional<PlannedForce> force)
    {
        SurgerySetup setup = layered_wall();
        setup.approach.incision = { { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 } };
        setup.approach.directions.assign(2, Vec3::UnitY());
        setup.approach.depth_mm = 20.0;
        setup.approach.retractor
            = RetractorSpec { .kind = "small", .opening_mm = kOpeningMm, .greatest_opening_mm = 30.0 };
        for (const double pull : { 1.0, -1.0 })
            setup.approach.hooks.push_back({ .name = pull > 0.0 ? "left_blade" : "right_blade",
                .side = pull > 0.0 ? 1 : -1,
                .along_mm = 30.0,
                .depth_mm = 8.0,
                .direction = pull * Vec3::UnitZ(),
                .opening_mm = 0.5 * kOpeningMm });
        setup.planned_force = std::move(force);
        return setup;
    }

    void settle(SurgerySession& live_session)
    {
        for (int i = 0; i < 1000 && live_session.moving(); ++i)
            live_session.relax(40.0);
    }

    double blade_force_N(const SurgerySession& live_session) { return live_session.hooks().retractors.at(0).force_N; }

    TEST(ForceMatch, OfASessionHoldsForThePlannedCutAndItsRetractor)
    {
        constexpr double kSame = 1e-6; // two solves of one wound
        const PlannedForce plan { .retractor = "small", .opening_mm = kOpeningMm, .force_N = kPlannedN };
        SurgerySession matched(planned_slab(plan)), raw(planned_slab(std::nullopt));
        for (SurgerySession* live_session : { &matched, &raw }) {
            ASSERT_TRUE(live_session->cut_as_planned().done);
            const KnifeAnswer taken = live_session->take_planned_hooks();
            ASSERT_TRUE(taken.done) << taken.reason;
            settle(*live_session);
        }
        ASSERT_EQ(matched.hooks().retractors.size(), 1U);
        ASSERT_TRUE(matched.hooks().force_factor);
        EXPECT_FALSE(raw.hooks().force_factor);
        const double factor = *matched.hooks().force_factor;
        EXPECT_NEAR(blade_force_N(matched), kPlannedN, kSame * kPlannedN);
        EXPECT_NEAR(factor * blade_force_N(raw), kPlannedN, kSame * kPlannedN);

        for (SurgerySession* live_session : { &matched, &raw }) {
            live_session->crank(live_session->hooks().retractors.at(0).blades[0], 0.5 * kOpeningMm);
            settle(*live_session);
        }
        EXPECT_EQ(matched.hooks().force_factor, factor) << "in proportion at other openings";
        EXPECT_LT(blade_force_N(matched), 0.75 * kPlannedN);
        matched.crank(matched.hooks().retractors.at(0).blades[0], kOpeningMm);
        settle(matched);

        // A further cut softens the wound, and the force falls: while it is drawn, and after it.
        const auto at = [&](double x, double z) { return touch(*matched.picture(), ray_down(x, z)).value(); };
        ASSERT_TRUE(matched.begin_stroke(at(60.0, 75.0), { .depth_mm = 20.0 }).done);
        for (double z = 78.0; z <= 100.0; z += 4.0)
            (void)matched.draw_to(at(60.0, z));
        settle(matched);
        EXPECT_EQ(matched.hooks().force_factor, factor);
        ASSERT_TRUE(matched.finish_stroke().done);
        settle(matched);
        EXPECT_EQ(matched.hooks().force_factor, factor);

        matched.set_yield(1000.0);
        EXPECT_FALSE(matched.hooks().force_factor) << "a limit is compared with forces as they are computed";
    }

    TEST(ForceMatch, OfASessionFollowsAPlanThatIsMadeLater)
    {
        constexpr double kSame = 1e-6; // two solves of one wound
        PlannedForce plan { .retractor = "small", .opening_mm = kOpeningMm, .force_N = kPlannedN };
        SurgerySession live_session(planned_slab(std::nullopt));
        ASSERT_TRUE(live_session.cut_as_planned().done);
        ASSERT_TRUE(live_session.take_planned_hooks().done);
        settle(live_session);
        EXPECT_FALSE(live_session.hooks().force_factor);
        EXPECT_TRUE(live_session.set_planned_force(plan));
        EXPECT_NEAR(blade_force_N(live_session), kPlannedN, kSame * kPlannedN);
        EXPECT_FALSE(live_session.set_planned_force(plan)) << "it says the same";
        plan.force_N = 2.0 * kPlannedN;
        EXPECT_TRUE(live_session.set_planned_force(plan));
        EXPECT_NEAR(blade_force_N(live_session), 2.0 * kPlannedN, kSame * kPlannedN);
        // Further cuts do not lose the match to a plan of the same opening.
        live_session.crank(live_session.hooks().retractors.at(0).blades[0], 0.5 * kOpeningMm);
        settle(live_session);
        const double halfway_N = blade_force_N(live_session);
        plan.force_N = kPlannedN;
        EXPECT_TRUE(live_session.set_planned_force(plan));
        EXPECT_NEAR(blade_force_N(live_session), 0.5 * halfway_N, kSame * halfway_N);
        plan.opening_mm = 2.0 * kOpeningMm;
        EXPECT_TRUE(live_session.set_planned_force(plan));
        EXPECT_FALSE(live_session.hooks().force_factor) << "not opened as far as the new plan yet";
        EXPECT_TRUE(live_session.set_planned_force(std::nullopt));
        EXPECT_FALSE(live_session.hooks().force_factor);
    }

    TEST(ForceMatch, OfASessionIsNotMadeInAnotherCut)
    {
        SurgerySession live_session(
            planned_slab(PlannedForce { .retractor = "small", .opening_mm = kOpeningMm, .force_N = kPlannedN }));
        const auto at = [&](double x, double z) { return touch(*live_session.picture(), ray_down(x, z)).value(); };
        ASSERT_TRUE(live_session.begin_stroke(at(35.0, 60.0), { .depth_mm = 15.0 }).done);
        for (double x = 40.0; x <= 85.0; x += 5.0)
            (void)live_session.draw_to(at(x, 60.0));
        ASSERT_TRUE(live_session.finish_stroke().done);
        ASSERT_TRUE(live_session.take_planned_hooks().done);
        settle(live_session);
        ASSERT_EQ(live_session.hooks().retractors.size(), 1U);
        EXPECT_FALSE(live_session.hooks().force_factor);
    }

} // namespace force_match_test
} // namespace retractor::planner
