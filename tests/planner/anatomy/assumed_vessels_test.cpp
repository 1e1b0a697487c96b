#include "planner/anatomy/assumed_vessels.h"

#include "mesh/base/error.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace assumed_vessels_test {

    using test_support::ChestShape;

    const ChestShape kShape {};
    /// The bones are known to a voxel, and a smoothed line cuts a corner by less than another.
    const double kRoughMm = kShape.spacing;

    const mesh::LabelVolume& chest()
    {
        static const mesh::LabelVolume labels = test_support::synthetic_chest(kShape);
        return labels;
    }

    const std::vector<AssumedVessel>& vessels()
    {
        static const std::vector<AssumedVessel> found = assumed_vessels(chest());
        return found;
    }

    const AssumedVessel& vessel(const std::string& name)
    {
        const auto found = std::ranges::find(vessels(), name, &AssumedVessel::name);
        if (found == vessels().end())
            throw InputError("no such vessel: " + name);
        return *found;
    }

    std::vector<Vec3> centres_of(const mesh::LabelVolume& labels, const std::string& name)
    {
        const Label id = mesh::label_named(labels.table, name).id;
        std::vector<Vec3> centres;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            if (label == id)
                centres.push_back(labels.grid.world(Vec3(i, j, k)));
        });
        return centres;
    }

    double distance_to(const std::vector<Vec3>& centres, const Vec3& p)
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3& q : centres)
            least = std::min(least, (p - q).norm());
        return least;
    }

    TEST(AssumedVessels, MammaryArteriesRunBesideTheSternumBehindIt)
    {
        const std::vector<Vec3> sternum = centres_of(chest(), "sternum");
        double edge = 0.0, back = -std::numeric_limits<double>::infinity();
        for (const Vec3& p : sternum) {
            edge = std::max(edge, std::abs(p.x()) + 0.5 * kShape.spacing);
            back = std::max(back, p.y());
        }
        for (const auto& [name, side] :
            { std::pair { "mammary_artery_left", 1.0 }, { "mammary_artery_right", -1.0 } }) {
            const AssumedVessel& artery = vessel(name);
            EXPECT_EQ(artery.radius_mm, kMammaryRadiusMm);
            for (const Vec3& p : artery.line) {
                EXPECT_NEAR(side * p.x(), edge + kMammaryFromSternumMm, kRoughMm) << name;
                EXPECT_LE(p.y(), -kShape.radius + kShape.wall + 20.0) << name << " lies in the wall or just behind it";
                EXPECT_GT(p.y(), -kShape.radius) << name;
            }
            const double length = test_support::kSternumTop - test_support::kSternumBottom;
            EXPECT_NEAR(artery.line.front().z() - artery.line.back().z(), 0.8 * length, 10.0) << name;
            EXPECT_GT(artery.line.front().z(), artery.line.back().z()) << "from the head to the feet";
        }
    }

    TEST(AssumedVessels, ABundleRunsBelowEachRibOnItsInnerSide)
    {
        for (int number = 1; number <= kShape.ribs; ++number)
            for (const char* side : { "left", "right" }) {
                const std::string rib = std::string("rib_") + side + "_" + std::to_string(number);
                const AssumedVessel& bundle
                    = vessel(std::string("neurovascular_bundle_") + side + "_" + std::to_string(number));
                const std::vector<Vec3> bone = centres_of(chest(), rib);
                const Label id = mesh::label_named(chest().table, rib).id;
                ASSERT_GT(bundle.line.size(), 10U) << rib;
                for (const Vec3& p : bundle.line) {
                    EXPECT_NE(mesh::label_at(chest(), p), id) << rib << ": it lies in the bone";
                    EXPECT_LT(distance_to(bone, p), kBundleRadiusMm + 2.0 * kRoughMm) << rib << ": it lies against it";
                    const double angle = std::atan2(std::abs(p.x()), p.y()) * 180.0
                        / std::numbers::pi; // round the axis, from straight back
                    EXPECT_LT(
                        p.z(), test_support::rib_height_at(kShape, number, angle) - 0.5 * kShape.rib_height + kRoughMm)
                        << rib << ": it lies below the rib";
                    EXPECT_LT(std::hypot(p.x(), p.y()), kShape.rib_radius + 0.5) << rib << ": it lies inside";
                }
            }
    }

    TEST(AssumedVessels, MoveWithThePatient)
    {
        const Mat3 turn = Eigen::AngleAxisd(0.3, Vec3(0.2, 1.0, 0.4).normalized()).toRotationMatrix();
        const Vec3 by(12.0, -7.0, 30.0);
        const std::vector<AssumedVessel> moved = assumed_vessels(test_support::moved(chest(), turn, by));
        ASSERT_EQ(moved.size(), vessels().size());
        for (const AssumedVessel& one : moved) {
            const std::vector<Vec3> here = places_along(vessel(one.name), 1.0);
            for (const Vec3& p : one.line)
                EXPECT_LT(distance_to(here, turn.transpose() * (p - by)), 2.0 * kRoughMm) << one.name;
        }
    }

    TEST(AssumedVessels, ALabelledOneIsNotAssumed)
    {
        mesh::LabelVolume labels = chest();
        labels.table.push_back({ 200, "internal_thoracic_artery_left", "vessel", mesh::Role::at_risk });
        labels.table.push_back({ 201, "neurovascular_bundle_left_4", "vessel", mesh::Role::at_risk });
        const std::vector<AssumedVessel> found = assumed_vessels(labels);
        EXPECT_EQ(found.size(), vessels().size() - 2U);
        EXPECT_EQ(std::ranges::find(found, "mammary_artery_left", &AssumedVessel::name), found.end());
        EXPECT_NE(std::ranges::find(found, "mammary_artery_right", &AssumedVessel::name), found.end());
        EXPECT_EQ(std::ranges::find(found, "neurovascular_bundle_left_4", &AssumedVessel::name), found.end());
    }

    TEST(AssumedVessels, WithoutBonesThereAreNone)
    {
        mesh::LabelVolume labels = chest();
        std::erase_if(labels.table, [](const mesh::LabelInfo& info) { return info.name == "sternum"; });
        for (Label& label : labels.voxels)
            if (mesh::find_label(labels.table, label) == nullptr)
                label = 0;
        EXPECT_TRUE(assumed_vessels(labels).empty());
    }

    TEST(AssumedVessels, PlacesAlongALineAreCloseAndHoldItsPoints)
    {
        const AssumedVessel bent { .name = "bent",
            .line = { Vec3::Zero(), Vec3(10.0, 0.0, 0.0), Vec3(10.0, 5.0, 0.0) } };
        const std::vector<Vec3> places = places_along(bent, 2.0);
        ASSERT_EQ(places.size(), 9U); // five steps of 2 mm and three of 5/3 mm
        EXPECT_EQ(places[5], bent.line[1]);
        EXPECT_EQ(places.back(), bent.line.back());
        for (std::size_t n = 1; n < places.size(); ++n)
            EXPECT_LE((places[n] - places[n - 1]).norm(), 2.0 + 1e-12);
    }

} // namespace assumed_vessels_test
} // namespace retractor::planner
