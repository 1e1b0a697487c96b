// The planned incision and what is divided beyond the skin, in a session: as cuts that can be undone.

#include "mesh/tetrahedra/tet_grid.h"
#include "planner/session/saved_cuts.h"
#include "planner/session/surgery_session.h"
#include "planner/session/surgery_worker.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

namespace retractor::planner {
namespace division_by_hand_test {

    constexpr Label kSkin = 1, kMuscle = 2, kIntercostal = 3, kRib = 4;

    /// 96 x 32 x 24 mm: the chest lies below z = 0. Intercostal muscle between two ribs along x up to z = 8, muscle up
    /// to z = 20, skin above.
    mesh::TetMesh wall()
    {
        mesh::TetMesh box = mesh::kuhn_box(24, 8, 6, 4.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            Vec3 c = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                c += 0.25 * box.vertices.row(v).transpose();
            Label& label = box.labels[static_cast<std::size_t>(t)];
            label = c.z() > 20.0 ? kSkin : c.z() > 8.0 ? kMuscle : kIntercostal;
            if (c.z() < 8.0 && (c.y() < 8.0 || c.y() > 24.0))
                label = kRib;
        }
        return box;
    }

    DivisionStroke stroke(StrokeWay way, const Vec3& from, double to_x)
    {
        DivisionStroke s { .way = way, .severs = { "intercostal" }, .depth_mm = 12.0 };
        s.length_mm = std::abs(to_x - from.x());
        for (const double x : { from.x(), 0.5 * (from.x() + to_x), to_x }) {
            s.line.emplace_back(x, from.y(), -4.0);
            s.directions.emplace_back(0, 0, 1);
        }
        return s;
    }

    /// As find_division() for this wall: to x = 13 and x = 81.
    void divide(Approach& approach)
    {
        const Vec3 first = approach.incision.front(), last = approach.incision.back();
        approach.division.strokes
            = { stroke(StrokeWay::backwards, first, 13.0), stroke(StrokeWay::forwards, last, 81.0) };
        approach.division.words = "in the space between the ribs";
    }

    SurgerySetup setup(DivisionExtent extent = DivisionExtent::full)
    {
        SurgerySetup setup;
        setup.wall = wall();
        setup.outward = Vec3::UnitZ();
        for (VertexId v = 0; v < static_cast<VertexId>(setup.wall.vertex_count()); ++v)
            if (const double x = setup.wall.vertices(v, 0); x == 0.0 || x == 96.0)
                setup.held.push_back(v);
        setup.labels = { { kSkin, "skin", "skin", mesh::Role::wall }, { kMuscle, "muscle", "muscle", mesh::Role::wall },
            { kIntercostal, "intercostal", "intercostal", mesh::Role::wall },
            { kRib, "rib", "bone", mesh::Role::wall } };
        setup.materials.resize(5);
        Approach& approach = setup.approach;
        approach.name = "between";
        approach.incision = { { 37.3, 17.3, 24.0 }, { 58.7, 17.3, 24.0 } };
        approach.directions = { { 0, 0, -1 }, { 0, 0, -1 } };
        approach.wall_thickness_mm = { 24.0, 24.0 };
        approach.depth_mm = 28.0;
        approach.uncut_labels = { "rib" };
        approach.division = { .extent = extent };
        if (extent != DivisionExtent::skin) {
            divide(approach);
            setup.find_division = divide;
        }
        return setup;
    }

    void draw(SurgerySession& live_session, double from_x, double to_x, double depth_mm)
    {
        const auto at = [&](double x) {
            return *touch(*live_session.picture(), { { x, 17.3, 80.0 }, -Vec3::UnitZ() });
        };
        ASSERT_TRUE(live_session.begin_stroke(at(from_x), { .depth_mm = depth_mm }).done);
        for (int i = 1; i <= 10; ++i)
            (void)live_session.draw_to(at(from_x + 0.1 * i * (to_x - from_x)));
        ASSERT_TRUE(live_session.finish_stroke().done);
    }

    double wound_mm2(const SurgerySession& live_session)
    {
        double area = 0.0;
        for (const CutEntry& cut : live_session.cuts())
            area += cut.in_force ? cut.report.lip_area_mm2 : 0.0;
        return area;
    }

    TEST(DivisionByHand, StrokesOfThePlanAreRecognisedWhenTheyAreRestored)
    {
        namespace fs = std::filesystem;
        const fs::path folder = fs::temp_directory_path() / "division_by_hand_test";
        fs::remove_all(folder);
        fs::create_directories(folder); // the case's
        SurgerySetup journalled = setup();
        journalled.journal = cuts_journal(folder / "case.json", "between");
        {
            SurgerySession live_session = new_session(journalled);
            ASSERT_TRUE(live_session.cut_as_planned().done);
            live_session.undo(); // the last stroke
            live_session.redo();
        }
        const SurgerySession live_session
            = restored_session(journalled, read_saved_cuts(journalled.journal, journalled.wall));
        ASSERT_EQ(live_session.cuts().size(), 3U);
        EXPECT_TRUE(live_session.cuts()[0].as_planned);
        EXPECT_EQ(live_session.cuts()[1].divides, StrokeWay::backwards);
        EXPECT_EQ(live_session.cuts()[2].divides, StrokeWay::forwards);
        EXPECT_GT(live_session.cuts()[2].report.lip_area_mm2, 0.0);
    }

    TEST(DivisionByHand, ThePlannedIncisionIsCutWithAllThatThePlanDivides)
    {
        SurgerySession live_session(setup());
        KnifeAnswer cut = live_session.cut_as_planned();
        ASSERT_TRUE(cut.done) << cut.reason;
        EXPECT_EQ(cut.reason, "in the space between the ribs");
        ASSERT_EQ(live_session.cuts().size(), 3U);
        EXPECT_TRUE(live_session.cuts()[0].as_planned);
        EXPECT_NEAR(live_session.cuts()[0].length_mm, 21.4, 1e-9);
        EXPECT_EQ(live_session.cuts()[1].divides, StrokeWay::backwards);
        EXPECT_EQ(live_session.cuts()[2].divides, StrokeWay::forwards);
        EXPECT_NEAR(live_session.cuts()[1].report.lip_area_mm2, (37.3 - 13.0) * 8.0, 0.1 * 24.3 * 8.0);
        const double all_mm2 = wound_mm2(live_session);

        cut = live_session.cut_as_planned();
        EXPECT_FALSE(cut.done);
        EXPECT_NE(cut.reason.find("undo the cuts"), std::string::npos) << cut.reason;
        EXPECT_EQ(
            live_session.divide_beyond_cut().reason, "what the approach divides beyond the skin is divided already");
        live_session.undo();
        EXPECT_TRUE(live_session.divide_beyond_cut().done) << "the way forwards";
        EXPECT_EQ(live_session.cuts()[2].divides, StrokeWay::forwards);
        live_session.undo();
        live_session.undo();
        EXPECT_EQ(live_session.session().cut_count(), 1U);
        EXPECT_TRUE(live_session.divide_beyond_cut().done) << "both ways";
        ASSERT_EQ(live_session.cuts().size(), 3U);
        EXPECT_NEAR(wound_mm2(live_session), all_mm2, 1e-6 * all_mm2);
        EXPECT_FALSE(live_session.can_redo());
    }

    TEST(DivisionByHand, BeyondACutThatAHandDrewTheSpaceIsDividedFromItsEnds)
    {
        SurgerySession live_session(setup());
        EXPECT_NE(live_session.divide_beyond_cut().reason.find("cut first"), std::string::npos);
        draw(live_session, 30.0, 54.0, 12.0);
        KnifeAnswer divided = live_session.divide_beyond_cut();
        EXPECT_FALSE(divided.done);
        EXPECT_NE(divided.reason.find("does not go through the wall"), std::string::npos) << divided.reason;
        live_session.undo();
        draw(live_session, 30.0, 54.0, 28.0);
        divided = live_session.divide_beyond_cut();
        ASSERT_TRUE(divided.done) << divided.reason;
        ASSERT_EQ(live_session.cuts().size(), 3U);
        EXPECT_NEAR(live_session.cuts()[1].length_mm, 30.0 - 13.0, 1.0);
        EXPECT_NEAR(live_session.cuts()[2].length_mm, 81.0 - 54.0, 1.0);
        EXPECT_GT(live_session.cuts()[2].report.lip_area_mm2, 0.8 * 27.0 * 8.0);
    }

    TEST(DivisionByHand, WhatCannotBeDividedIsNamedAndTheRestIsDivided)
    {
        SurgerySetup beside = setup();
        beside.find_division = [](Approach& approach) {
            divide(approach);
            for (Vec3& point : approach.division.strokes[0].line)
                point.z() -= 400.0; // far below the wall
        };
        SurgerySession live_session(std::move(beside));
        draw(live_session, 36.0, 58.0, 28.0);
        const KnifeAnswer divided = live_session.divide_beyond_cut();
        EXPECT_TRUE(divided.done);
        EXPECT_NE(divided.reason.find("could not be divided backwards"), std::string::npos) << divided.reason;
        ASSERT_EQ(live_session.cuts().size(), 2U);
        EXPECT_EQ(live_session.cuts()[1].divides, StrokeWay::forwards);
    }

    TEST(DivisionByHand, AnApproachThatDividesNothingBeyondTheSkinSaysSo)
    {
        SurgerySession live_session(setup(DivisionExtent::skin));
        EXPECT_TRUE(live_session.cut_as_planned().done);
        EXPECT_EQ(live_session.cuts().size(), 1U);
        const KnifeAnswer divided = live_session.divide_beyond_cut();
        EXPECT_FALSE(divided.done);
        EXPECT_EQ(divided.reason, "the approach divides nothing beyond the skin");
    }

} // namespace division_by_hand_test
} // namespace retractor::planner
