#include "planner/approach/space_division.h"

#include "mesh/base/corridor.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/intercostal_space.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace space_division_test {

    using test_support::ChestShape;

    const ChestShape kShape {};
    const double kVoxelMm = kShape.spacing;
    /// The step of the search, and a voxel.
    const double kRoughMm = 1.0 + kVoxelMm;

    const mesh::LabelVolume& chest()
    {
        static const mesh::LabelVolume labels = test_support::synthetic_chest(kShape);
        return labels;
    }
    const Anatomy& anatomy()
    {
        static const Anatomy found = find_anatomy(chest());
        return found;
    }

    Approach lateral(double length = 80.0)
    {
        ApproachRequest request;
        request.template_name = "intercostal:4";
        request.target.label = "aneurysm";
        request.length_mm = length;
        Approach approach = approach_from_template(chest(), anatomy(), request);
        approach.division = { .extent = DivisionExtent::full };
        return approach;
    }

    const DivisionStroke& stroke(const Approach& approach, bool forwards)
    {
        return *std::find_if(approach.division.strokes.begin(), approach.division.strokes.end(),
            [&](const DivisionStroke& s) { return (s.way == StrokeWay::forwards) == forwards; });
    }

    Vec3 outer_end(const DivisionStroke& s, std::size_t n) { return s.line[n] + s.depth_mm * s.directions[n]; }

    double angle_of(const Vec3& p) { return std::atan2(std::abs(p.x()), p.y()) * 180.0 / std::numbers::pi; }

    TEST(SpaceDivision, EndsBeforeAnAssumedMammaryArtery)
    {
        Approach approach = lateral();
        find_space_division(approach, chest(), anatomy());
        const DivisionStroke free = stroke(approach, true);
        // It runs down across the space, where the free division would pass.
        const std::size_t middle = free.line.size() / 2;
        const Vec3 crossed = outer_end(free, middle) - 0.5 * kShape.rib_thickness * free.directions[middle];
        const std::vector<AssumedVessel> assumed { { .name = "mammary_artery_left",
            .line = { crossed + 40.0 * Vec3::UnitZ(), crossed - 40.0 * Vec3::UnitZ() },
            .radius_mm = 1.1 } };
        find_space_division(approach, chest(), anatomy(), assumed);
        const DivisionStroke& ended = stroke(approach, true);
        EXPECT_LT(ended.length_mm, free.length_mm);
        const Vec3 off = outer_end(ended, ended.line.size() - 1) - crossed;
        const double beside = std::hypot(off.x(), off.y());
        EXPECT_GT(beside, kFromMammaryMm + 1.1 - kRoughMm);
        EXPECT_LT(beside, kFromMammaryMm + 1.1 + kShape.rib_thickness + kRoughMm);
        EXPECT_NE(approach.division.words.find("5 mm from where the mammary artery is assumed"), std::string::npos)
            << approach.division.words;
    }

    TEST(SpaceDivision, GoesFromTheIncisionToTheSpineAndToTheRibsEnd)
    {
        Approach approach = lateral();
        find_space_division(approach, chest(), anatomy());
        ASSERT_EQ(approach.division.strokes.size(), 2U) << approach.division.words;
        const DivisionStroke &back = stroke(approach, false), &front = stroke(approach, true);
        // The template's line runs from the back to the front. Both strokes begin on the rays of the blade's ends.
        const auto off_ray = [](const Vec3& p, const Vec3& skin, const Vec3& direction) {
            return (p - skin - direction.dot(p - skin) * direction).norm();
        };
        constexpr double kRoundOff = 1e-9;
        EXPECT_LT(off_ray(back.line.front(), approach.incision.front(), approach.directions.front()), kRoundOff);
        EXPECT_LT(off_ray(front.line.front(), approach.incision.back(), approach.directions.back()), kRoundOff);
        EXPECT_LT((back.directions.front() + approach.directions.front()).norm(), kRoundOff);
        // Backwards 40 mm from the spine's midline, which is x = 0; forwards the ribs end at 140 degrees.
        EXPECT_NEAR(back.line.back().x() + back.depth_mm * back.directions.back().x()
                - 0.5 * kShape.rib_thickness * back.directions.back().x(),
            kFromSpineMm, kRoughMm);
        EXPECT_NEAR(angle_of(outer_end(front, front.line.size() - 1)), test_support::kRibToDeg, 4.0);
        EXPECT_NE(approach.division.words.find("left intercostal space 4"), std::string::npos);
        EXPECT_NE(approach.division.words.find("40 mm from the spine's midline"), std::string::npos);
        EXPECT_NE(approach.division.words.find("do not tell intercostal muscle apart"), std::string::npos);
    }

    TEST(SpaceDivision, ItsBladesRunFromTheChestToTheRibsOuterSide)
    {
        Approach approach = lateral();
        find_space_division(approach, chest(), anatomy());
        const mesh::LabelFlags wall = mesh::flagged_labels(chest().table, mesh::is_wall);
        for (const DivisionStroke& s : approach.division.strokes) {
            ASSERT_GE(s.line.size(), 3U);
            EXPECT_NO_THROW(static_cast<void>(mesh::SweptBlade(blade_of(s))));
            for (std::size_t n = 0; n < s.line.size(); ++n) {
                EXPECT_EQ(wall[mesh::label_at(chest(), s.line[n])], 0) << n;
                const Vec3 end = outer_end(s, n);
                EXPECT_NEAR(std::hypot(end.x(), end.y()), kShape.rib_radius + 0.5 * kShape.rib_thickness, kVoxelMm)
                    << n;
                const double height = test_support::upper_edge_at(kShape, 5, angle_of(end)) + kAboveLowerRibMm;
                EXPECT_NEAR(end.z(), height, kVoxelMm) << n;
            }
        }
    }

    TEST(SpaceDivision, KeepsItsDistanceFromAMammaryArtery)
    {
        mesh::LabelVolume labels = chest();
        const Label artery = 90;
        labels.table.push_back({ artery, "left_internal_mammary_artery", "vessel", mesh::Role::at_risk });
        const Vec3 place = 93.0 * Vec3(std::sin(2.2), std::cos(2.2), 0.0); // at 126 degrees, on the inner side
        for (int k = 0; k < labels.grid.size[2]; ++k) {
            const Vec3 index = labels.grid.index(Vec3(place.x(), place.y(), 0.0));
            labels.voxels[labels.grid.offset(
                static_cast<int>(std::lround(index.x())), static_cast<int>(std::lround(index.y())), k)]
                = artery;
        }
        Approach approach = lateral();
        find_space_division(approach, labels, anatomy());
        const DivisionStroke& front = stroke(approach, true);
        EXPECT_NE(approach.division.words.find("5 mm from the mammary artery"), std::string::npos)
            << approach.division.words;
        const Vec3 end = outer_end(front, front.line.size() - 1);
        const double beside = (end - Vec3(place.x(), place.y(), end.z())).norm();
        EXPECT_GT(beside, kFromMammaryMm);
        EXPECT_LT(angle_of(end), 126.0);
    }

    TEST(SpaceDivision, EndsBeforeAVesselThatLiesAgainstTheWallFromWithin)
    {
        mesh::LabelVolume labels = chest();
        const Label vessel = 91;
        labels.table.push_back({ vessel, "aorta_descending", "vessel", mesh::Role::at_risk });
        // A column of 10 mm radius behind the wall, at 50 degrees from straight back.
        const double angle = 50.0 * std::numbers::pi / 180.0;
        const Vec3 axis = 85.0 * Vec3(std::sin(angle), std::cos(angle), 0.0);
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    if (std::hypot(p.x() - axis.x(), p.y() - axis.y()) < 10.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = vessel;
                }
        Approach approach = lateral();
        find_space_division(approach, labels, anatomy());
        EXPECT_NE(approach.division.words.find("the aorta descending lies behind the wall"), std::string::npos)
            << approach.division.words;
        const DivisionStroke& back = stroke(approach, false);
        for (std::size_t n = 0; n < back.line.size(); ++n) // from its begin inside the chest
            EXPECT_GT(std::hypot(back.line[n].x() - axis.x(), back.line[n].y() - axis.y()), 10.0);
    }

    TEST(SpaceDivision, GivenDistancesAreKept)
    {
        Approach approach = lateral();
        approach.division.forwards_mm = 20.0;
        approach.division.backwards_mm = 0.0;
        find_space_division(approach, chest(), anatomy());
        ASSERT_EQ(approach.division.strokes.size(), 1U);
        EXPECT_TRUE(approach.division.strokes[0].way == StrokeWay::forwards);
        // The blend from the incision to the rib's upper edge may make the way a little longer.
        EXPECT_NEAR(approach.division.strokes[0].length_mm, 20.0, 1.0);
        approach.division.forwards_mm = 400.0;
        find_space_division(approach, chest(), anatomy());
        EXPECT_LT(approach.division.strokes[0].length_mm, 100.0);
        EXPECT_NE(approach.division.words.find("400 mm were given"), std::string::npos);
    }

    TEST(SpaceDivision, AReversedIncisionIsDividedAlike)
    {
        Approach approach = lateral();
        Approach reversed = approach;
        std::reverse(reversed.incision.begin(), reversed.incision.end());
        std::reverse(reversed.directions.begin(), reversed.directions.end());
        find_space_division(approach, chest(), anatomy());
        find_space_division(reversed, chest(), anatomy());
        ASSERT_EQ(reversed.division.strokes.size(), 2U);
        for (const bool forwards : { true, false })
            EXPECT_DOUBLE_EQ(stroke(reversed, forwards).length_mm, stroke(approach, forwards).length_mm);
    }

    TEST(SpaceDivision, AnIncisionOutsideEverySpaceIsLeftAsItIs)
    {
        ApproachRequest request;
        request.template_name = "median";
        request.target.label = "aneurysm";
        Approach median = approach_from_template(chest(), anatomy(), request);
        median.division = { .extent = DivisionExtent::full };
        find_space_division(median, chest(), anatomy());
        EXPECT_TRUE(median.division.strokes.empty());
        EXPECT_EQ(
            median.division.words, "the incision follows no intercostal space: nothing is divided beyond the skin");
        Approach skin = lateral();
        skin.division = {};
        find_space_division(skin, chest(), anatomy());
        EXPECT_TRUE(skin.division.strokes.empty());
        EXPECT_EQ(skin.division.words, "");
    }

    TEST(SpaceDivision, TheMeshReachesAlongTheStrokes)
    {
        Approach approach = lateral();
        EXPECT_TRUE(mesh_sizing_of(approach, chest().table).coarse_path.empty());
        find_space_division(approach, chest(), anatomy());
        const mesh::MeshSizing sizing = mesh_sizing_of(approach, chest().table);
        EXPECT_DOUBLE_EQ(sizing.coarse_path_edge_mm, 1.5 * approach.sizing.corridor_edge_mm);
        for (const DivisionStroke& s : approach.division.strokes)
            for (std::size_t n = 0; n < s.line.size(); ++n)
                EXPECT_LT(polyline_distance(sizing.coarse_path, s.line[n] + 0.5 * s.depth_mm * s.directions[n]), 1e-9);
        // No step of the line of the region crosses the chest.
        const std::vector<Vec3> line = mesh::region_line(sizing);
        for (std::size_t n = sizing.corridor.size(); n < line.size(); ++n)
            EXPECT_LT((line[n] - line[n - 1]).norm(), 20.0) << n;
    }

} // namespace space_division_test
} // namespace retractor::planner
