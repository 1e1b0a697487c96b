#include "planner/approach/approach_draft.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace retractor::planner {
namespace approach_draft_test {

    constexpr double kSkinMm = 1.0; // half a voxel of the block

    Patient& patient()
    {
        static Patient made(
            test_support::block_case("draft", datasets::make_block_phantom(test_support::small_block())));
        return made;
    }

    ApproachDraft drawn()
    {
        return { .points = { { -22.0, -2.0, 3.0 }, { 0.0, 4.0, 0.0 }, { 24.0, -3.0, -2.0 } },
            .target = "target",
            .opened_by = { .hooks = "2", .opening_mm = 18.0 } };
    }

    TEST(ApproachDraft, ADrawnIncisionLiesOnTheSkinAndIsOpened)
    {
        const Approach approach = approach_from_draft(patient(), patient().planned_case(), drawn());
        EXPECT_EQ(approach.name, "drawn");
        EXPECT_EQ(surgical_name(approach), "Drawn incision");
        for (const Vec3& point : approach.incision)
            EXPECT_NEAR(point.y(), 0.0, kSkinMm);
        EXPECT_NEAR((approach.incision.front() - Vec3(-22.0, 0.0, 3.0)).norm(), 0.0, 2.0 * kSkinMm);
        ASSERT_EQ(approach.hooks.size(), 2U);
        EXPECT_EQ(approach.hooks[0].opening_mm, 9.0);
        EXPECT_EQ(approach.division.extent, DivisionExtent::skin);
    }

    TEST(ApproachDraft, WhatIsDividedIsChosen)
    {
        ApproachDraft draft = drawn();
        draft.divides = Divides::space;
        EXPECT_EQ(
            approach_from_draft(patient(), patient().planned_case(), draft).division.extent, DivisionExtent::full);
        draft.divides = Divides::bone;
        EXPECT_TRUE(approach_from_draft(patient(), patient().planned_case(), draft).uncut_labels.empty());
        draft.depth_mm = 12.0;
        EXPECT_EQ(approach_from_draft(patient(), patient().planned_case(), draft).depth_mm, 12.0);
    }

    TEST(ApproachDraft, NamesAreFree)
    {
        Case planned_case = patient().planned_case();
        for (const char* name : { "drawn", "drawn-2" }) {
            add_approach(planned_case, approach_from_draft(patient(), planned_case, drawn()));
            EXPECT_EQ(planned_case.approaches.back().name, name);
        }
        EXPECT_EQ(free_approach_name(planned_case, "median"), "median");
    }

    TEST(ApproachDraft, OpeningsAreChanged)
    {
        const Approach approach = approach_from_draft(patient(), patient().planned_case(), drawn());
        const Approach spread = opened_by(approach, { .retractor = "midcab", .opening_mm = 25.0 });
        ASSERT_TRUE(spread.retractor);
        EXPECT_TRUE(spread.hooks.empty());
        EXPECT_EQ(spread.retractor->kind, "midcab");
        EXPECT_EQ(spread.retractor->opening_mm, 25.0);
        EXPECT_EQ(asked_opening_mm(spread), 25.0);
        EXPECT_EQ(with_opening(spread, 30.0).retractor->opening_mm, 30.0);
        EXPECT_EQ(with_opening(spread, 30.0).retractor->kind, "midcab");
        Approach hooked = opened_by(approach, { .hooks = "2", .opening_mm = 18.0 });
        EXPECT_EQ(asked_opening_mm(hooked), 18.0);
        hooked.hooks[1].opening_mm = 3.0;
        EXPECT_EQ(asked_opening_mm(hooked), 12.0);
        EXPECT_NEAR(with_opening(hooked, 24.0).hooks[0].opening_mm, 18.0, 1e-12);
        EXPECT_NEAR(with_opening(hooked, 24.0).hooks[1].opening_mm, 6.0, 1e-12);
        for (HookSpec& hook : hooked.hooks)
            hook.pull.force_N = 40.0;
        EXPECT_EQ(asked_opening_mm(hooked), 0.0) << "the force decides";
        const Approach cut = opened_by(spread, {});
        EXPECT_EQ(asked_opening_mm(cut), 0.0);
        EXPECT_FALSE(cut.retractor);
        EXPECT_TRUE(cut.hooks.empty());
        EXPECT_THROW((void)opened_by(approach, { .retractor = "none", .opening_mm = 25.0 }), InputError);
        EXPECT_THROW((void)opened_by(approach, { .hooks = "3", .opening_mm = 25.0 }), InputError);
    }

    TEST(ApproachDraft, AMovedIncisionKeepsTheRest)
    {
        Approach approach = approach_from_draft(patient(), patient().planned_case(), drawn());
        approach.retracted = { "cavity" };
        approach.sizing.corridor_edge_mm = 6.0;
        std::vector<Vec3> handles = incision_handles(approach);
        ASSERT_EQ(handles.size(), 3U); // 46 mm at 25 mm
        EXPECT_LT((handles.front() - approach.incision.front()).norm(), 1e-9);
        EXPECT_LT((handles.back() - approach.incision.back()).norm(), 1e-9);
        const Approach same = with_incision_through(patient(), approach, handles);
        EXPECT_NEAR(incision_length(same), incision_length(approach), kSkinMm);
        handles.back() += Vec3(0.0, 0.0, 12.0);
        const Approach moved = with_incision_through(patient(), approach, handles);
        EXPECT_NEAR(moved.incision.back().z(), approach.incision.back().z() + 12.0, kSkinMm);
        EXPECT_EQ(moved.name, approach.name);
        EXPECT_EQ(moved.retracted, approach.retracted);
        EXPECT_EQ(moved.sizing.corridor_edge_mm, 6.0);
        ASSERT_EQ(moved.hooks.size(), 2U);
        EXPECT_GT(std::abs(moved.hooks[0].direction.dot(approach.hooks[0].direction)), 0.8);
        EXPECT_NE(moved.hooks[0].direction, approach.hooks[0].direction) << "hooks pull across the moved incision";
        EXPECT_NE(moved.rationale.find("moved by hand"), std::string::npos);

        Approach spread = opened_by(approach, { .retractor = "midcab", .opening_mm = 25.0 });
        EXPECT_NEAR(with_incision_through(patient(), spread, handles).retractor->along_mm, 0.5 * incision_length(moved),
            kSkinMm);

        approach.hooks[1].along_mm += 5.0; // no template has it there
        EXPECT_THROW((void)with_incision_through(patient(), approach, handles), InputError);
        approach.hooks.resize(1);
        EXPECT_THROW((void)with_incision_through(patient(), approach, handles), InputError);
        EXPECT_THROW((void)with_incision_through(patient(), spread, { handles.front() }), InputError);
    }

    TEST(ApproachDraft, AnotherTargetIsNotHeldAsideAndNotSpokenOfAsTheOld)
    {
        Approach approach = approach_from_draft(patient(), patient().planned_case(), drawn());
        ASSERT_NE(approach.rationale.find("The target's centre lies"), std::string::npos) << approach.rationale;
        approach.retracted = { "cavity", "lung_left" };
        const std::string before = approach.rationale.substr(0, approach.rationale.find(" The target's centre lies"));
        const Approach other = with_target(
            approach, { .label = "cavity", .centre = Vec3(0.0, 40.0, 0.0), .radius_mm = 8.0, .site = "clamp site" });
        EXPECT_EQ(other.target.site, "clamp site");
        EXPECT_EQ(other.retracted, std::vector<std::string> { "lung_left" });
        EXPECT_EQ(other.rationale, before);
        EXPECT_EQ(with_target(other, approach.target).rationale, before) << "there is nothing more to drop";
    }

    TEST(SurgicalName, IsWhatSurgeonsSay)
    {
        Approach approach;
        approach.template_name = "median";
        EXPECT_EQ(surgical_name(approach), "Median sternotomy");
        approach.name = "median";
        EXPECT_EQ(spoken_name(approach), "Median sternotomy");
        approach.name = "median-2"; // as a copy is named
        EXPECT_EQ(spoken_name(approach), "Median sternotomy, no. 2");
        for (const char* own : { "median-", "median-b", "median 2" }) {
            approach.name = own;
            EXPECT_EQ(spoken_name(approach), own);
        }
        approach.name = "second plan";
        EXPECT_EQ(spoken_name(approach), "second plan");
        approach.template_name = "intercostal:4";
        EXPECT_EQ(surgical_name(approach), "Thoracotomy, 4th space");
        approach.retracted = { "lung_left", "mediastinal_fat" };
        EXPECT_EQ(surgical_name(approach), "Left thoracotomy, 4th space");
        approach.retracted = { "lung_upper_lobe_right" };
        EXPECT_EQ(surgical_name(approach), "Right thoracotomy, 4th space");
        approach.retracted.clear();
        approach.template_name = "intercostal:3";
        EXPECT_EQ(surgical_name(approach), "Thoracotomy, 3rd space");
        approach.template_name = "distal";
        EXPECT_EQ(surgical_name(approach), "Left posterolateral thoracotomy");
        approach.template_name = "midcab:5";
        EXPECT_EQ(surgical_name(approach), "Left anterior mini-thoracotomy, 5th space");
    }

} // namespace approach_draft_test
} // namespace retractor::planner
