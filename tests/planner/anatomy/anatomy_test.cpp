#include "planner/anatomy/anatomy.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace anatomy_test {

    using test_support::ChestShape;
    using test_support::moved;
    using test_support::stored_backwards;
    using test_support::synthetic_chest;

    constexpr double kVoxel = 3.0; // the synthetic chest's
    constexpr double kEquivarianceMm = 1e-6; // round-off of coordinates of some hundred mm through some thousand sums

    const mesh::LabelVolume& chest()
    {
        static const mesh::LabelVolume labels = test_support::synthetic_chest();
        return labels;
    }

    Mat3 some_rotation() { return Eigen::AngleAxisd(0.83, Vec3(0.3, -0.8, 0.52).normalized()).toRotationMatrix(); }
    const Vec3 kSomeShift(41.7, -203.3, 1090.1);

    void expect_same_landmarks(const Anatomy& a, const Anatomy& b, const Mat3& rotation, const Vec3& shift)
    {
        EXPECT_LT((rotation * a.frame.superior - b.frame.superior).norm(), kEquivarianceMm);
        EXPECT_LT((rotation * a.frame.anterior - b.frame.anterior).norm(), kEquivarianceMm);
        EXPECT_LT((rotation * a.frame.left - b.frame.left).norm(), kEquivarianceMm);
        EXPECT_LT((rotation * a.sternum.top + shift - b.sternum.top).norm(), kEquivarianceMm);
        EXPECT_LT((rotation * a.sternum.bottom + shift - b.sternum.bottom).norm(), kEquivarianceMm);
        ASSERT_EQ(a.ribs.size(), b.ribs.size());
        for (std::size_t r = 0; r < a.ribs.size(); ++r) {
            EXPECT_EQ(a.ribs[r].name, b.ribs[r].name);
            ASSERT_EQ(a.ribs[r].points.size(), b.ribs[r].points.size()) << a.ribs[r].name;
            for (std::size_t n = 0; n < a.ribs[r].points.size(); ++n)
                EXPECT_LT((rotation * a.ribs[r].points[n] + shift - b.ribs[r].points[n]).norm(), kEquivarianceMm);
        }
    }

    std::string where_of_refusal(const mesh::LabelVolume& labels)
    {
        try {
            find_anatomy(labels);
        } catch (const InputError& error) {
            return error.where();
        }
        return "accepted";
    }

    void erase(mesh::LabelVolume& labels, std::string_view name)
    {
        const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
        for (Label& voxel : labels.voxels)
            if (voxel == info->id)
                voxel = 0;
    }

    void rename(mesh::LabelVolume& labels, const std::string& from, const std::string& to)
    {
        for (mesh::LabelInfo& info : labels.table)
            if (info.name == from)
                info.name = to;
    }

    TEST(Anatomy, FrameOfTheRoundChestIsThatOfItsMaking)
    {
        const Anatomy anatomy = find_anatomy(chest());
        constexpr double kTolerance = 0.02; // a degree: half a voxel over the depth of the chest
        EXPECT_LT((anatomy.frame.superior - Vec3::UnitZ()).norm(), kTolerance);
        EXPECT_LT((anatomy.frame.anterior + Vec3::UnitY()).norm(), kTolerance);
        EXPECT_LT((anatomy.frame.left - Vec3::UnitX()).norm(), kTolerance);
        EXPECT_LT(std::hypot(anatomy.frame.origin.x(), anatomy.frame.origin.y()), 1.0);
    }

    TEST(Anatomy, SternumRunsFromNotchToXiphoid)
    {
        const Anatomy anatomy = find_anatomy(chest());
        EXPECT_LT((anatomy.sternum.top - Vec3(0.0, -104.0, test_support::kSternumTop)).norm(), kVoxel);
        EXPECT_LT((anatomy.sternum.bottom - Vec3(0.0, -104.0, test_support::kSternumBottom)).norm(), kVoxel);
        for (const Vec3& point : anatomy.sternum.midline)
            EXPECT_LT(std::hypot(point.x(), point.y() + 104.0), 0.5 * kVoxel);
    }

    TEST(Anatomy, RibCentreLinesLieOnTheirHelices)
    {
        const test_support::ChestShape shape;
        const Anatomy anatomy = find_anatomy(chest());
        ASSERT_EQ(anatomy.ribs.size(), 16u);
        for (const RibLine& rib : anatomy.ribs) {
            EXPECT_LT(rib.angle_deg.front(), test_support::kRibFromDeg + 3.0);
            EXPECT_GT(rib.angle_deg.back(), test_support::kRibToDeg - 3.0);
            for (const Vec3& point : rib.points) {
                EXPECT_EQ(rib.left, point.x() > 0.0);
                const double angle = std::atan2(std::abs(point.x()), point.y()) * 180.0 / std::numbers::pi;
                EXPECT_NEAR(std::hypot(point.x(), point.y()), shape.rib_radius, 0.5 * kVoxel) << rib.name;
                EXPECT_NEAR(point.z(), test_support::rib_height_at(shape, rib.number, angle), 0.5 * kVoxel) << rib.name;
            }
        }
    }

    TEST(Anatomy, PointAtAngleLiesAtThatAngle)
    {
        const Anatomy anatomy = find_anatomy(chest());
        const RibLine& rib = find_rib(anatomy, true, 4);
        const Vec3 side = point_at_angle(rib, 90.0);
        EXPECT_NEAR(side.x(), 104.0, 0.5 * kVoxel);
        EXPECT_NEAR(side.y(), 0.0, kVoxel);
        EXPECT_EQ(point_at_angle(rib, -1000.0), rib.points.front());
        EXPECT_EQ(point_at_angle(rib, 1000.0), rib.points.back());
    }

    TEST(Anatomy, TurnedAndShiftedPatientHasTurnedAndShiftedLandmarks)
    {
        const Anatomy anatomy = find_anatomy(chest());
        expect_same_landmarks(
            anatomy, find_anatomy(moved(chest(), some_rotation(), kSomeShift)), some_rotation(), kSomeShift);
    }

    TEST(Anatomy, StorageOrderDoesNotMatter)
    {
        const Anatomy anatomy = find_anatomy(chest());
        for (const int axis : { 0, 1, 2 })
            expect_same_landmarks(
                anatomy, find_anatomy(test_support::stored_backwards(chest(), axis)), Mat3::Identity(), Vec3::Zero());
    }

    TEST(Anatomy, CartilagesLeadTheRibsToTheSternum)
    {
        const datasets::Phantom phantom
            = datasets::make_thorax_phantom({ .spacing_mm = { 2.4, 2.4, 2.6 }, .noise_hu = 0.0 });
        const Anatomy anatomy = find_anatomy(phantom.labels);
        const RibLine& rib = find_rib(anatomy, true, 4);
        double nearest = 1e300;
        for (const Vec3& point : anatomy.sternum.midline)
            nearest = std::min(nearest, (point - rib.points.back()).norm());
        EXPECT_LT(nearest, 30.0); // half the breastbone's width and a cartilage's
    }

    TEST(Anatomy, MissingLandmarksAreNamed)
    {
        for (const std::string name : { "spine", "sternum" }) {
            mesh::LabelVolume labels = chest();
            erase(labels, name);
            EXPECT_EQ(where_of_refusal(labels), name);
        }
        mesh::LabelVolume labels = chest();
        for (int n = 1; n <= 7; ++n)
            erase(labels, "rib_right_" + std::to_string(n));
        EXPECT_EQ(where_of_refusal(labels), "rib_right_*");
        EXPECT_THROW(find_rib(find_anatomy(chest()), true, 11), InputError);
        EXPECT_THROW(label_centroid(chest(), "liver"), InputError);
    }

    TEST(Anatomy, MirroredPatientIsRefused)
    {
        mesh::LabelVolume mirrored = chest();
        mirrored.grid.direction.col(0) *= -1.0; // the axis, but not the voxels
        EXPECT_TRUE(where_of_refusal(mirrored).starts_with("rib_")) << where_of_refusal(mirrored);

        mesh::LabelVolume swapped = chest();
        rename(swapped, "rib_left_3", "x");
        rename(swapped, "rib_right_3", "rib_left_3");
        rename(swapped, "x", "rib_right_3");
        EXPECT_EQ(where_of_refusal(swapped), "rib_left_3");
    }

    TEST(Anatomy, MisnumberedRibsAreRefused)
    {
        mesh::LabelVolume labels = chest();
        const int order[] = { 3, 8, 1, 6, 2, 7, 5, 4 };
        for (mesh::LabelInfo& info : labels.table)
            if (info.name.starts_with("rib_"))
                info.name.back() = static_cast<char>('0' + order[info.name.back() - '1']);
        EXPECT_EQ(where_of_refusal(labels), "rib_*");
    }

    TEST(Anatomy, TotalSegmentatorVertebraeStandForTheSpine)
    {
        mesh::LabelVolume labels = chest();
        rename(labels, "spine", "vertebrae_T5");
        expect_same_landmarks(find_anatomy(chest()), find_anatomy(labels), Mat3::Identity(), Vec3::Zero());
    }

} // namespace anatomy_test
} // namespace retractor::planner
