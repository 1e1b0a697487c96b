#include "planner/approach/intercostal_space.h"

#include "mesh/base/error.h"
#include "planner/approach/approach_templates.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

namespace retractor::planner {
namespace intercostal_space_test {

    using test_support::ChestShape;

    const ChestShape kShape {};
    /// Half a voxel, by which a label's border is known.
    const double kHalfVoxelMm = 0.5 * kShape.spacing;

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

    ApproachRequest request(const std::string& name, bool left = true)
    {
        ApproachRequest r;
        r.template_name = name;
        r.target.label = "aneurysm";
        r.left = left;
        return r;
    }

    TEST(IntercostalSpace, ItsMiddleAndLevelsAreThoseOfTheRoundChest)
    {
        for (const bool left : { true, false }) {
            const BodyProbe probe(chest());
            const IntercostalSpace space = find_intercostal_space(probe, anatomy(), left, 4);
            EXPECT_EQ(space.left, left);
            ASSERT_GT(space.places.size(), 40U);
            for (const SpacePlace& place : space.places) {
                if (place.angle_deg < 30.0 || place.angle_deg > 125.0)
                    continue; // the ends of smoothed lines are rougher
                SCOPED_TRACE(place.angle_deg);
                const Vec3& m = place.middle;
                EXPECT_EQ(m.x() > 0.0, left);
                const double angle = std::atan2(std::abs(m.x()), m.y()) * 180.0 / std::numbers::pi;
                const double height = 0.5
                    * (test_support::rib_height_at(kShape, 4, angle) + test_support::rib_height_at(kShape, 5, angle));
                EXPECT_NEAR(m.z(), height, kHalfVoxelMm);
                EXPECT_NEAR(
                    place.cut.z(), test_support::upper_edge_at(kShape, 5, angle) + kAboveLowerRibMm, kHalfVoxelMm);
                EXPECT_NEAR(std::hypot(m.x(), m.y()), kShape.rib_radius, kHalfVoxelMm);
                EXPECT_NEAR(place.gap_mm, kShape.rib_pitch - kShape.rib_height, 2.0 * kHalfVoxelMm);
                // The wall is 24 mm thick, from 120 to 96 mm; the ribs' middle lies at 104 mm, their outer side at 108.
                EXPECT_NEAR(place.inner_mm, kShape.rib_radius - (kShape.radius - kShape.wall), 2.0 * kHalfVoxelMm);
                EXPECT_NEAR(place.outer_mm, 0.5 * kShape.rib_thickness, 2.0 * kHalfVoxelMm);
                EXPECT_TRUE(place.open);
                EXPECT_NEAR(place.outward.norm(), 1.0, 1e-12);
                EXPECT_GT(place.outward.dot(Vec3(m.x(), m.y(), 0.0).normalized()), 0.97);
            }
            for (std::size_t n = 1; n < space.places.size(); ++n)
                EXPECT_GT(space.places[n].along_mm, space.places[n - 1].along_mm);
        }
    }

    TEST(IntercostalSpace, IsOpenWhereTheWallBehindTheRibsIsThin)
    {
        for (const double behind : { 0.5, 2.0, 3.5 }) { // mm from the ribs' middle to the cavity; voxels have 3 mm
            ChestShape shape;
            shape.rib_radius = shape.radius - shape.wall + behind;
            const mesh::LabelVolume labels = test_support::synthetic_chest(shape);
            const BodyProbe probe(labels);
            for (const SpacePlace& place : find_intercostal_space(probe, find_anatomy(labels), true, 4).places)
                if (place.angle_deg > 30.0 && place.angle_deg < 125.0) {
                    EXPECT_TRUE(place.open) << behind << " mm, at " << place.angle_deg;
                    EXPECT_TRUE(place.cavity);
                    EXPECT_NEAR(place.inner_mm, behind, 2.0 * kHalfVoxelMm);
                }
        }
    }

    TEST(IntercostalSpace, IsFoundUnderTheIncisionOfATemplate)
    {
        for (const bool left : { true, false })
            for (const int number : { 3, 5 }) {
                const Approach approach = approach_from_template(
                    chest(), anatomy(), request("intercostal:" + std::to_string(number), left));
                const auto found = space_under_incision(anatomy(), approach);
                ASSERT_TRUE(found);
                EXPECT_EQ(found->left, left);
                EXPECT_EQ(found->number, number);
            }
        EXPECT_FALSE(space_under_incision(anatomy(), approach_from_template(chest(), anatomy(), request("median"))));
    }

    TEST(IntercostalSpace, IsClosedWhereTheRibsJoin)
    {
        mesh::LabelVolume joined = chest();
        const Label rib = mesh::label_named(joined.table, "rib_left_4").id;
        for (int k = 0; k < joined.grid.size[2]; ++k)
            for (int j = 0; j < joined.grid.size[1]; ++j)
                for (int i = 0; i < joined.grid.size[0]; ++i) {
                    const Vec3 p = joined.grid.world(Vec3(i, j, k));
                    const double angle = std::atan2(std::abs(p.x()), p.y()) * 180.0 / std::numbers::pi;
                    const bool between = p.z() < test_support::rib_height_at(kShape, 4, angle)
                        && p.z() > test_support::rib_height_at(kShape, 5, angle);
                    const double off = std::abs(std::hypot(p.x(), p.y()) - kShape.rib_radius);
                    if (p.x() > 0.0 && angle > 100.0 && angle < 115.0 && between && off < 4.0)
                        joined.voxels[joined.grid.offset(i, j, k)] = rib;
                }
        const BodyProbe probe(joined);
        const IntercostalSpace space = find_intercostal_space(probe, anatomy(), true, 4);
        for (const SpacePlace& place : space.places) {
            const bool inside = place.angle_deg > 103.0 && place.angle_deg < 112.0;
            const bool outside = place.angle_deg > 30.0 && place.angle_deg < 90.0;
            if (!inside && !outside)
                continue;
            EXPECT_EQ(place.open, outside) << place.angle_deg;
        }
        // The bridge draws the cut beside it towards the middle between the ribs at most, and to neither rib.
        for (const SpacePlace& place : space.places) {
            if (place.angle_deg < 85.0 || place.angle_deg > 125.0)
                continue;
            const double right = test_support::upper_edge_at(kShape, 5, place.angle_deg) + kAboveLowerRibMm;
            const double half_way = 0.5
                * (test_support::rib_height_at(kShape, 4, place.angle_deg)
                    + test_support::rib_height_at(kShape, 5, place.angle_deg));
            EXPECT_GT(place.cut.z(), right - kHalfVoxelMm) << place.angle_deg;
            EXPECT_LT(place.cut.z(), half_way + kHalfVoxelMm) << place.angle_deg;
        }
    }

    TEST(IntercostalSpace, IsCutAboveTheLowerRibInGapsOfEveryWidth)
    {
        EXPECT_DOUBLE_EQ(height_of_cut(0.0), 0.0);
        EXPECT_DOUBLE_EQ(height_of_cut(6.0), 3.0);
        EXPECT_DOUBLE_EQ(height_of_cut(12.0), kAboveLowerRibMm);
        EXPECT_DOUBLE_EQ(height_of_cut(18.0), 18.0 - kMostBelowUpperRibMm);
        EXPECT_DOUBLE_EQ(height_of_cut(30.0), 15.0);
        for (const double pitch : { 15.0, 21.0, 28.0 }) { // gaps of 6, 12 and 19 mm
            ChestShape shape;
            shape.rib_pitch = pitch;
            const mesh::LabelVolume labels = test_support::synthetic_chest(shape);
            const BodyProbe probe(labels);
            for (const SpacePlace& place : find_intercostal_space(probe, find_anatomy(labels), true, 3).places)
                if (place.angle_deg > 30.0 && place.angle_deg < 125.0) {
                    EXPECT_NEAR(place.cut.z(),
                        test_support::upper_edge_at(shape, 4, place.angle_deg)
                            + height_of_cut(pitch - shape.rib_height),
                        kHalfVoxelMm)
                        << "gap of " << pitch - shape.rib_height << " mm, at " << place.angle_deg;
                }
        }
    }

    TEST(IntercostalSpace, PlacesAreInterpolatedAndEndAtTheEnds)
    {
        IntercostalSpace space;
        space.places = { { .angle_deg = 0.0, .middle = Vec3(0, 0, 0), .outward = Vec3(0, 0, 1), .gap_mm = 10.0 },
            { .angle_deg = 2.0,
                .middle = Vec3(4, 0, 0),
                .cut = Vec3(4, 2, 0),
                .outward = Vec3(0, 0, 1),
                .gap_mm = 20.0,
                .along_mm = 4.0 },
            { .angle_deg = 4.0,
                .middle = Vec3(8, 0, 0),
                .outward = Vec3(0, 0, 1),
                .gap_mm = 2.0,
                .open = false,
                .along_mm = 8.0 } };
        const SpacePlace between = place_along(space, 1.0);
        EXPECT_DOUBLE_EQ(between.gap_mm, 12.5);
        EXPECT_DOUBLE_EQ(between.middle.x(), 1.0);
        EXPECT_DOUBLE_EQ(between.cut.y(), 0.5);
        EXPECT_TRUE(between.open);
        EXPECT_FALSE(place_along(space, 5.0).open);
        EXPECT_DOUBLE_EQ(place_along(space, -3.0).along_mm, 0.0);
        EXPECT_DOUBLE_EQ(place_along(space, 30.0).along_mm, 8.0);
    }

    TEST(IntercostalSpace, AMissingRibIsNamed)
    {
        const BodyProbe probe(chest());
        try {
            static_cast<void>(find_intercostal_space(probe, anatomy(), true, 8)); // this chest has eight ribs
            FAIL() << "a space without a lower rib was found";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "rib_left_9");
        }
    }

} // namespace intercostal_space_test
} // namespace retractor::planner
