#include "planner/anatomy/body_probe.h"

#include "mesh/base/error.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace body_probe_test {

    constexpr double kSkinMm = 1.5; // half a voxel: where the skin runs along the grid, labels know no better
    constexpr double kNormalDeg = 4.0; // a step of one voxel over the width of the kernel, half seen
    const test_support::ChestShape kShape;

    const mesh::LabelVolume& chest()
    {
        static const mesh::LabelVolume labels = test_support::synthetic_chest();
        return labels;
    }

    Vec3 round(double angle_deg)
    {
        const double angle = angle_deg * std::numbers::pi / 180.0;
        return { std::cos(angle), std::sin(angle), 0.0 };
    }

    TEST(BodyProbe, SkinOfTheRoundChestLiesAtItsRadius)
    {
        const BodyProbe probe(chest());
        for (double angle = 0.0; angle < 360.0; angle += 7.0) {
            const auto skin = probe.skin_along(Vec3(0.0, 0.0, 3.0), round(angle));
            ASSERT_TRUE(skin) << angle;
            EXPECT_NEAR(*skin, kShape.radius, kSkinMm) << angle;
        }
        EXPECT_FALSE(probe.skin_along(Vec3(500.0, 0.0, 0.0), Vec3::UnitX()));
    }

    TEST(BodyProbe, APointerMeetsTheSkinThatFacesIt)
    {
        const BodyProbe probe(chest());
        constexpr double kFar = 600.0;
        for (double angle = 5.0; angle < 360.0; angle += 11.0) {
            const Vec3 outside = kFar * round(angle) + 3.0 * Vec3::UnitZ();
            const auto seen = probe.skin_seen(outside, -round(angle));
            ASSERT_TRUE(seen) << angle;
            EXPECT_NEAR((*seen - 3.0 * Vec3::UnitZ()).norm(), kShape.radius, kSkinMm) << angle;
            EXPECT_LT((*seen - outside).norm(), kFar) << "the side that faces the eye";
            EXPECT_FALSE(probe.skin_seen(outside, round(angle))) << "away from the body";
        }
        EXPECT_FALSE(probe.skin_seen({ kFar, 0.0, 0.0 }, Vec3::UnitY())) << "past the body";
    }

    TEST(BodyProbe, AnArmBesideTheChestHasASkinOfItsOwn)
    {
        mesh::LabelVolume labels = chest();
        // An arm to the right of the chest, 15 mm off it.
        const double from = kShape.radius + 15.0;
        const int reach = static_cast<int>(std::ceil((from + 40.0) / labels.grid.spacing.x()));
        mesh::LabelVolume wide = labels;
        wide.grid.size[0] += 2 * reach;
        wide.grid.origin.x() -= reach * labels.grid.spacing.x();
        wide.voxels.assign(wide.grid.voxel_count(), 0);
        const Label skin = mesh::find_label(labels.table, "skin")->id;
        for (int k = 0; k < wide.grid.size[2]; ++k)
            for (int j = 0; j < wide.grid.size[1]; ++j)
                for (int i = 0; i < wide.grid.size[0]; ++i) {
                    const Vec3 p = wide.grid.world(Vec3(i, j, k));
                    const bool arm = p.x() > from && p.x() < from + 30.0 && std::abs(p.y()) < 25.0;
                    wide.voxels[wide.grid.offset(i, j, k)] = arm ? skin : mesh::label_at(labels, p);
                }
        const BodyProbe probe(wide);
        const Vec3 start(kShape.radius - 0.5 * kShape.wall, 0.0, 3.0);
        const auto first = probe.first_skin_along(start, Vec3::UnitX()), last = probe.skin_along(start, Vec3::UnitX());
        ASSERT_TRUE(first && last);
        EXPECT_NEAR(*first, 0.5 * kShape.wall, 2.0 * kSkinMm); // the arm is within the wide kernel
        EXPECT_NEAR(start.x() + *last, from + 30.0, labels.grid.spacing.x());
        // Where there is no arm, the two are one.
        const Vec3 up(0.0, start.x(), 3.0);
        EXPECT_EQ(probe.first_skin_along(up, Vec3::UnitY()), probe.skin_along(up, Vec3::UnitY()));
    }

    TEST(BodyProbe, WallEndsAtTheCavity)
    {
        const BodyProbe probe(chest());
        for (const double angle : { 3.0, 40.0, 140.0, 170.0, 200.0, 330.0 }) {
            const auto wall = probe.wall_thickness(kShape.radius * round(angle), -round(angle));
            ASSERT_TRUE(wall) << angle;
            EXPECT_NEAR(*wall, kShape.wall, 2.0) << angle; // the narrow kernel follows the 3 mm voxels
        }
        EXPECT_FALSE(probe.wall_thickness(kShape.radius * round(0.0), -round(0.0), 15.0)); // none within the limit
    }

    TEST(BodyProbe, NormalPointsOutwards)
    {
        const BodyProbe probe(chest());
        for (double angle = 0.0; angle < 360.0; angle += 13.0)
            EXPECT_GT(probe.skin_normal(kShape.radius * round(angle)).dot(round(angle)),
                std::cos(kNormalDeg * std::numbers::pi / 180.0));
    }

    TEST(BodyProbe, NearestSkinPointIsStraightOutOrIn)
    {
        const BodyProbe probe(chest());
        for (const double radius : { 100.0, 119.0, 121.0, 145.0 })
            for (const double angle : { 10.0, 100.0, 215.0 }) {
                const Vec3 expected = kShape.radius * round(angle) + Vec3(0.0, 0.0, 31.0);
                const Vec3 found = probe.project_to_skin(radius * round(angle) + Vec3(0.0, 0.0, 31.0));
                EXPECT_LT((found - expected).norm(), 2.0) << radius << " " << angle;
                EXPECT_NEAR(std::hypot(found.x(), found.y()), kShape.radius, kSkinMm);
            }
    }

    TEST(BodyProbe, VolumeWithoutWallIsRefused)
    {
        mesh::LabelVolume labels = chest();
        for (mesh::LabelInfo& info : labels.table)
            info.role = mesh::Role::voxel;
        EXPECT_THROW(BodyProbe { labels }, InputError);
    }

    TEST(BodyProbe, PointsThatAreNoPointsAreRefused)
    {
        const BodyProbe probe(chest());
        EXPECT_THROW(probe.project_to_skin(Vec3::Constant(std::nan(""))), InputError);
    }

} // namespace body_probe_test
} // namespace retractor::planner
