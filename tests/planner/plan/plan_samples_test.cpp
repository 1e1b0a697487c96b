// Several plans at once: samples of stiffness from one opening, and approaches of which one is impossible.

#include "planner/plan/plan.h"

#include "mesh/base/error.h"
#include "planner/approach/retractors.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace plan_samples_test {

    constexpr double kOpeningMm = 10.0;
    const std::vector<StiffnessFactors> kSamples { { { "skin", 1.9 }, { "fat", 0.6 }, { "muscle", 1.7 } }, {},
        { { "skin", 0.6 }, { "muscle", 0.6 } }, { { "fat", 2.0 }, { "muscle", 0.5 } } };

    Case drafted(const std::string& name, Approach (*approach_of)(const mesh::LabelVolume&))
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case(name, phantom);
        planned_case.solution.element = ElementKind::p1;
        planned_case.contact = ContactMode::never;
        planned_case.approaches = { approach_of(phantom.labels) };
        return planned_case;
    }

    Approach with_hooks(const mesh::LabelVolume& labels)
    {
        return test_support::block_approach(labels, Eigen::Isometry3d::Identity(), kOpeningMm);
    }

    Approach with_blades(const mesh::LabelVolume& labels)
    {
        Approach approach = test_support::block_approach(labels, Eigen::Isometry3d::Identity(), 0.0);
        approach.hooks.clear();
        approach.sizing.region_mm = 30.0; // the border of the region holds the wall
        RetractorKind kind = find_retractor(built_in_retractors(), "midcab");
        kind.blade_width_mm = 20.0;
        approach.retractor = make_retractor(approach, kind, { .opening_mm = kOpeningMm });
        return approach;
    }

    Approach with_blades_that_hold(const mesh::LabelVolume& labels)
    {
        Approach approach = with_blades(labels);
        approach.retractor->hold = HookHold::fixed;
        return approach;
    }

    const PlanChecks kDraft { .error_bars = false, .draft = true };

    /// The fast path beside the slow one: each sample planned from the beginning.
    /// @param of_force how far the forces may differ, relative
    void expect_same_as_alone(const Case& planned_case, double of_force)
    {
        Patient patient(planned_case, {});
        const Approach& approach = planned_case.approaches.front();
        std::vector<std::optional<PlanAttempt>> attempts(kSamples.size());
        plan_samples(
            patient, approach, kSamples,
            [&](std::size_t sample, PlanAttempt attempt) { attempts.at(sample) = std::move(attempt); }, {}, kDraft);
        std::vector<double> forces;
        for (std::size_t s = 0; s < kSamples.size(); ++s) {
            ASSERT_TRUE(attempts[s] && attempts[s]->failure.empty());
            const PlannedField& field = attempts[s]->field;
            Patient fresh(planned_case, {});
            fresh.set_stiffness_factors(kSamples[s]);
            const PlannedField alone = plan_approach(fresh, approach, {}, kDraft);
            ASSERT_EQ(field.status, alone.status) << field.message;
            EXPECT_EQ(field.wall.tet_count(), alone.wall.tet_count());
            forces.push_back(alone.metrics.hook_force_N);
            EXPECT_NEAR(field.metrics.hook_force_N, forces.back(), of_force * forces.back()) << s;
            EXPECT_NEAR(field.metrics.opening_area_mm2, alone.metrics.opening_area_mm2,
                of_force * alone.metrics.opening_area_mm2);
            constexpr double kSeen = 0.02; // samples at the edge of the opening
            EXPECT_NEAR(field.metrics.seen_best_eye, alone.metrics.seen_best_eye, kSeen);
        }
        EXPECT_GT(forces[0], (1.0 + 3.0 * of_force) * forces[2]) << "stiffer skin, or the comparison says nothing";
    }

    TEST(PlanSamples, HooksPullAsInPlansFromTheBeginning)
    {
        constexpr double kResidual = 1e-3; // ten times what the solver leaves of the forces: lips are soft
        expect_same_as_alone(drafted("samples_hooks", with_hooks), kResidual);
    }

    TEST(PlanSamples, BladesPullAsInPlansFromTheBeginning)
    {
        constexpr double kBalance = 0.02; // a hundredth in each of the two
        expect_same_as_alone(drafted("samples_blades", with_blades_that_hold), kBalance);
    }

    /// Lips that slide on turned blades have more than one balance, of which a sample may find another than a plan from
    /// the beginning. Both are balances.
    TEST(PlanSamples, BladesInContactEndInBalance)
    {
        const Case planned_case = drafted("samples_contact", with_blades);
        Patient patient(planned_case, {});
        std::size_t planned = 0;
        plan_samples(
            patient, planned_case.approaches.front(), kSamples,
            [&](std::size_t sample, const PlanAttempt& attempt) {
                ASSERT_TRUE(attempt.failure.empty()) << attempt.failure;
                ASSERT_EQ(attempt.field.status, PlanStatus::done) << attempt.field.message;
                ASSERT_TRUE(attempt.field.retractor);
                EXPECT_FALSE(attempt.field.contact_was_lost);
                constexpr double kBalance = 0.02; // as plans with blades in contact ask for
                EXPECT_LE(
                    attempt.field.retractor->residual_force_N, 1.01 * kBalance * attempt.field.metrics.hook_force_N)
                    << sample;
                ++planned;
            },
            {}, kDraft);
        EXPECT_EQ(planned, kSamples.size());
    }

    TEST(PlanSamples, TakeTheWholeWallWhereTheRegionIsToBeFound)
    {
        Case planned_case = drafted("samples_region", with_hooks);
        planned_case.approaches.front().sizing.corridor_edge_mm = 12.0; // drafts of shorter edges find a region
        planned_case.approaches.front().sizing.coarse_edge_mm = 20.0;
        Patient patient(planned_case, {});
        const Approach& approach = planned_case.approaches.front();
        ASSERT_FALSE(approach.sizing.region_mm);
        std::size_t planned = 0;
        for (const bool find_region : { false, true }) {
            PlanChecks checks = kDraft;
            checks.find_region = find_region;
            plan_samples(
                patient, approach, std::span(kSamples).first(1),
                [&](std::size_t, const PlanAttempt& attempt) {
                    ASSERT_TRUE(attempt.failure.empty()) << attempt.failure;
                    EXPECT_EQ(attempt.field.approach.sizing.region_mm.has_value(), find_region);
                    EXPECT_EQ(attempt.field.metrics.region.ended_by,
                        find_region ? RegionEnd::whole : RegionEnd::not_searched);
                    ++planned;
                },
                {}, checks);
        }
        EXPECT_EQ(planned, 2U);
    }

    TEST(PlanSamples, EndWhereTheyAreCancelled)
    {
        const Case planned_case = drafted("samples_cancelled", with_hooks);
        Patient patient(planned_case, {});
        std::atomic<bool> cancelled { false };
        Job job;
        job.cancel = &cancelled;
        std::size_t planned = 0;
        plan_samples(
            patient, planned_case.approaches.front(), kSamples,
            [&](std::size_t, const PlanAttempt&) {
                ++planned;
                cancelled = true;
            },
            job, kDraft);
        EXPECT_EQ(planned, 1U);
    }

    TEST(PlanEach, OneImpossibleApproachLeavesTheOthers)
    {
        Case planned_case = drafted("each", with_hooks);
        Approach beside = planned_case.approaches.front();
        beside.name = "hooks beside";
        for (HookSpec& hook : beside.hooks)
            hook.along_mm += 400.0; // there is no lip
        planned_case.approaches.insert(planned_case.approaches.begin(), beside);
        Patient patient(planned_case, {});
        EXPECT_THROW(static_cast<void>(plan_all(patient, {}, kDraft)), InputError);
        const std::vector<PlanAttempt> attempts = plan_each(patient, {}, kDraft);
        ASSERT_EQ(attempts.size(), 2U);
        EXPECT_FALSE(attempts[0].failure.empty());
        EXPECT_TRUE(attempts[1].failure.empty()) << attempts[1].failure;
        EXPECT_TRUE(is_measured(attempts[1].field)) << attempts[1].field.message;
        EXPECT_EQ(attempts[1].field.approach.name, planned_case.approaches[1].name);
    }

} // namespace plan_samples_test
} // namespace retractor::planner
