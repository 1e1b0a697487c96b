#include "planner/approach/blade_fit.h"

#include "planner/approach/retractors.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace retractor::planner {
namespace blade_fit_test {

    constexpr Label kMuscle = 1, kBone = 2;
    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr double kYawTolerance = 1.5 * kDegree; // a voxel over the width of a blade
    constexpr double kVoxelMm = 1.0;

    /// Place in the wound: along the incision, to the left of the cut, and below the skin, mm.
    using IsBone = std::function<bool(double along, double left, double depth)>;

    struct Wound {
        mesh::LabelVolume labels;
        Approach approach;
    };

    /// A wall with an incision of 100 mm, and a rib spreader in its middle.
    /// @param pose turns wound and bones in the image
    Wound wound_with(const IsBone& is_bone, double wall_mm = 30.0, const Mat3& pose = Mat3::Identity())
    {
        Wound wound;
        mesh::LabelVolume& labels = wound.labels;
        labels.grid.size = { 120, 120, 120 };
        labels.grid.spacing = Vec3::Constant(kVoxelMm);
        labels.grid.origin = Vec3::Constant(-60.0);
        labels.table = { { .id = kMuscle, .name = "muscle", .material = "muscle", .role = mesh::Role::wall },
            { .id = kBone, .name = "rib", .material = "bone", .role = mesh::Role::wall } };
        // The incision runs along y and the body lies below it, so the left of the cut is towards -x.
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    const Vec3 p = pose.transpose() * labels.grid.world(Vec3(i, j, k));
                    labels.voxels.push_back(is_bone(p.y(), -p.x(), -p.z()) ? kBone : kMuscle);
                }
        Approach& approach = wound.approach;
        approach.name = "space";
        approach.incision = { pose * Vec3(0.0, -50.0, 0.0), pose * Vec3(0.0, 50.0, 0.0) };
        approach.directions = { pose * -Vec3::UnitZ(), pose * -Vec3::UnitZ() };
        approach.depth_mm = wall_mm + 5.0;
        approach.wall_thickness_mm = { wall_mm, wall_mm };
        approach.target = { .label = {}, .centre = pose * Vec3(0.0, 0.0, -80.0), .radius_mm = 10.0 };
        approach.retractor
            = make_retractor(approach, find_retractor(built_in_retractors(), "finochietto"), { .opening_mm = 40.0 });
        approach.hooks = blades_of(approach);
        return wound;
    }

    /// Two ribs, 8 mm to either side of the cut, that run to the left by the slope of an angle.
    IsBone ribs(double left_rib, double right_rib, double from_mm = 15.0, double to_mm = 25.0)
    {
        return [=](double along, double left, double depth) {
            const double a = left - along * std::tan(left_rib), b = left - along * std::tan(right_rib);
            return depth > from_mm && depth < to_mm && ((a > 8.0 && a < 18.0) || (b < -8.0 && b > -18.0));
        };
    }

    TEST(BladeFit, BladesTurnAlongTheRibs)
    {
        for (const double angle : { -12.0, -5.0, 0.0, 8.0 }) {
            const Wound wound = wound_with(ribs(angle * kDegree, angle * kDegree));
            EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -angle * kDegree, kYawTolerance) << angle;
            Approach fitted = wound.approach;
            fit_blades(fitted, wound.labels);
            const Vec3 rib = Vec3(-std::tan(angle * kDegree), 1.0, 0.0).normalized();
            for (const HookSpec& blade : fitted.hooks) {
                EXPECT_NEAR(std::abs(patch_place(fitted, blade).along.dot(rib)), 1.0, 1e-3) << angle;
                EXPECT_NEAR(blade.direction.dot(rib), 0.0, std::sin(kYawTolerance)) << angle;
                EXPECT_NEAR(blade.direction.norm(), 1.0, 1e-12);
            }
            EXPECT_LT((fitted.hooks[0].direction + fitted.hooks[1].direction).norm(), 1e-12) << "one rack";
        }
    }

    TEST(BladeFit, BetweenRibsOfTwoDirectionsTheyTakeTheMean)
    {
        const Wound wound = wound_with(ribs(10.0 * kDegree, 4.0 * kDegree));
        EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -7.0 * kDegree, kYawTolerance);
    }

    TEST(BladeFit, ThePatientsPoseDoesNotMatter)
    {
        const Mat3 pose = (Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(-1.9, Vec3::UnitZ())).matrix();
        const Wound wound = wound_with(ribs(8.0 * kDegree, 8.0 * kDegree), 30.0, pose);
        EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -8.0 * kDegree, kYawTolerance);
    }

    TEST(BladeFit, BonesThatTheCutPassesThroughAskForNoTurn)
    {
        const Wound wound
            = wound_with([](double, double, double depth) { return depth > 10.0 && depth < 20.0; }); // a sternum
        EXPECT_EQ(blade_fit(wound.approach, wound.labels).yaw, 0.0);
    }

    TEST(BladeFit, RibsThatCrossThePlaneOfTheBladeCountWithTheirEdges)
    {
        const double slope = std::tan(12.0 * kDegree);
        const Wound wound = wound_with([&](double along, double left, double depth) {
            const double beside = std::abs(left - along * slope); // 4 mm: at its ends the blade is 5 mm off the line
            return depth > 15.0 && depth < 25.0 && beside > 4.0 && beside < 14.0;
        });
        EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -12.0 * kDegree, kYawTolerance);
    }

    TEST(BladeFit, WithoutBoneTheBladesStay)
    {
        const Wound wound = wound_with([](double, double, double) { return false; });
        Approach fitted = wound.approach;
        fit_blades(fitted, wound.labels);
        for (std::size_t h = 0; h < 2; ++h) {
            EXPECT_EQ(fitted.hooks[h].direction, wound.approach.hooks[h].direction);
            EXPECT_EQ(fitted.hooks[h].patch_height_mm, wound.approach.hooks[h].patch_height_mm);
        }
        // A rib of the neighbouring space, and bone behind a small part of the blade, do not count.
        const auto short_bone
            = [](double along, double left, double) { return left > 25.0 || (along > 15.0 && left > along); };
        const Wound far = wound_with(short_bone);
        EXPECT_EQ(blade_fit(far.approach, far.labels).yaw, 0.0);
    }

    TEST(BladeFit, BoneOnOneSideDecidesAlone)
    {
        const auto two = ribs(9.0 * kDegree, 9.0 * kDegree);
        const Wound wound = wound_with([&](double a, double l, double d) { return l > 0.0 && two(a, l, d); });
        EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -9.0 * kDegree, kYawTolerance);
    }

    TEST(BladeFit, TheTurnIsAtMostFifteenDegrees)
    {
        const Wound wound = wound_with(ribs(22.0 * kDegree, 22.0 * kDegree));
        EXPECT_NEAR(blade_fit(wound.approach, wound.labels).yaw, -15.0 * kDegree, 1e-3);
    }

    TEST(BladeFit, BladesReachTheRibsThatLieDeeperThanTheThinnestWall)
    {
        // The wall is thin at one end of the blade, and blades ended above the ribs there.
        Wound wound = wound_with(ribs(0.0, 0.0, 24.0, 34.0), 40.0);
        wound.approach.wall_thickness_mm = { 12.0, 40.0 };
        wound.approach.hooks = blades_of(wound.approach);
        const auto bottom = [](const HookSpec& blade) { return blade.depth_mm + 0.5 * blade.patch_height_mm; };
        ASSERT_LT(bottom(wound.approach.hooks[0]), 24.0);
        const double reach = blade_fit(wound.approach, wound.labels).reach_mm;
        EXPECT_GT(reach, 24.0);
        EXPECT_LT(reach, 34.0 + 4.0);
        Approach fitted = wound.approach;
        fit_blades(fitted, wound.labels);
        for (const HookSpec& blade : fitted.hooks) {
            EXPECT_NEAR(bottom(blade), reach, 1e-9);
            EXPECT_NEAR(blade.depth_mm - 0.5 * blade.patch_height_mm, 2.0, 1e-9) << "the skin stays on the blade";
        }
        // A blade of steel does not grow.
        fitted = wound.approach;
        fitted.retractor->blade_depth_mm = 26.0;
        fitted.hooks = blades_of(fitted);
        fit_blades(fitted, wound.labels);
        EXPECT_NEAR(bottom(fitted.hooks[0]), 26.0, 1e-9);
    }

} // namespace blade_fit_test
} // namespace retractor::planner
