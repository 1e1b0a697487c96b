#include "planner/wall/joint_places.h"

#include "datasets/phantoms/phantom.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace retractor::planner {
namespace joint_places_test {

    std::map<std::string, JointPlaces> places_of(const mesh::LabelVolume& labels)
    {
        std::map<std::string, JointPlaces> places;
        for (const JointPlaces& joint :
            joint_places(labels, std::array { mesh::label_named(labels.table, "spine").id }))
            places.emplace(mesh::find_label(labels.table, joint.label)->name, joint);
        return places;
    }

    /// The image turned and shifted, sampled anew on a grid of its own.
    mesh::LabelVolume turned(const mesh::LabelVolume& labels, const Eigen::Isometry3d& motion)
    {
        mesh::LabelVolume image { labels.grid, {}, labels.table };
        const Vec3 middle
            = labels.grid.world(0.5 * Vec3(labels.grid.size[0] - 1, labels.grid.size[1] - 1, labels.grid.size[2] - 1));
        image.grid.origin += motion * middle - middle;
        image.voxels.resize(labels.voxels.size());
        const Eigen::Isometry3d back = motion.inverse();
        for (int k = 0; k < image.grid.size[2]; ++k)
            for (int j = 0; j < image.grid.size[1]; ++j)
                for (int i = 0; i < image.grid.size[0]; ++i)
                    image.voxels[image.grid.offset(i, j, k)]
                        = mesh::label_at(labels, back * image.grid.world(Vec3(i, j, k)));
        return image;
    }

    TEST(JointPlaces, EveryRibOfThePhantomHasBothInEveryPose)
    {
        const mesh::LabelVolume labels
            = datasets::make_thorax_phantom({ .spacing_mm = { 2.0, 2.0, 2.2 }, .noise_hu = 0.0 }).labels;
        const std::map<std::string, JointPlaces> first = places_of(labels);
        EXPECT_EQ(first.size(), 24U);
        for (const auto& [name, joint] : first) {
            EXPECT_TRUE(joint.tubercle || name.ends_with("_11") || name.ends_with("_12")) << name;
            if (!joint.tubercle || joint.axis_of_neighbour)
                continue;
            const Vec3 neck = *joint.tubercle - joint.head;
            EXPECT_GE(neck.norm(), kShortestAxisMm) << name;
            EXPECT_LT(neck.norm(), 35.0) << name;
            EXPECT_GT(std::abs(joint.tubercle->x()), std::abs(joint.head.x()) + 4.0) << name; // more lateral
        }
        // Voxels that fall elsewhere move the places by less than this.
        constexpr double kVoxelMm = 4.0, kTubercleMm = 15.0; // the tubercle may be found by the wider gap
        for (const Eigen::AngleAxisd& turn :
            { Eigen::AngleAxisd(0.0, Vec3::UnitX()), Eigen::AngleAxisd(0.15, Vec3(0.3, 0.2, 1.0).normalized()) }) {
            const Eigen::Isometry3d motion = Eigen::Translation3d(0.9, -0.7, 1.1) * turn;
            const std::map<std::string, JointPlaces> there = places_of(turned(labels, motion));
            constexpr int kMostLost = 6; // short ribs, whose process the labels of a turned image lose
            int lost = 0;
            for (const auto& [name, joint] : first) {
                const auto found = there.find(name);
                ASSERT_NE(found, there.end()) << name;
                if (!found->second.tubercle || !joint.tubercle || found->second.axis_of_neighbour
                    || joint.axis_of_neighbour) {
                    ++lost;
                    continue;
                }
                EXPECT_LT((found->second.head - motion * joint.head).norm(), kVoxelMm) << name;
                EXPECT_LT((*found->second.tubercle - motion * *joint.tubercle).norm(), kTubercleMm) << name;
            }
            EXPECT_LE(lost, kMostLost);
        }
    }

    /// Labels of a straight rib along x from x = 0, with a spine at x < -1 and, from `from` to `to`, behind it.
    mesh::LabelVolume straight_rib(double spacing, double from, double to)
    {
        mesh::LabelVolume labels;
        labels.grid.spacing = Vec3::Constant(spacing);
        labels.grid.size
            = { static_cast<int>(210.0 / spacing), static_cast<int>(40.0 / spacing), static_cast<int>(24.0 / spacing) };
        labels.grid.origin = Vec3(-10.0, -20.0, -12.0);
        labels.table = { { 1, "rib_left_5", "bone", mesh::Role::wall }, { 2, "spine", "bone", mesh::Role::wall } };
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    Label& label = labels.voxels[labels.grid.offset(i, j, k)];
                    if (p.x() >= 0.0 && std::hypot(p.y(), p.z()) <= 5.0)
                        label = 1;
                    else if (p.x() < -1.0 || (p.x() >= from && p.x() <= to && p.y() > 6.0))
                        label = 2;
                }
        return labels;
    }

    TEST(JointPlaces, AreHeadAndTubercleOnEveryGrid)
    {
        for (const double spacing : { 0.8, 1.0, 1.5, 2.0 }) {
            const auto places = places_of(straight_rib(spacing, 22.0, 30.0));
            ASSERT_EQ(places.size(), 1U);
            const JointPlaces& joint = places.at("rib_left_5");
            EXPECT_NEAR(joint.head.x(), 1.5, 1.5) << spacing;
            EXPECT_LT(joint.head.tail<2>().norm(), 1.5) << spacing;
            ASSERT_TRUE(joint.tubercle.has_value()) << spacing;
            // Voxels within 5 mm of the process stand up to 4 mm beside it.
            EXPECT_NEAR(joint.tubercle->x(), 27.5, 3.0) << spacing;
            EXPECT_GT(joint.tubercle->y(), 1.0) << spacing;
        }
    }

    TEST(JointPlaces, LabelsThatMergeAlongTheNeckChangeNeitherEnd)
    {
        const JointPlaces apart = places_of(straight_rib(1.0, 22.0, 30.0)).at("rib_left_5");
        const JointPlaces merged = places_of(straight_rib(1.0, 0.0, 30.0)).at("rib_left_5");
        ASSERT_TRUE(merged.tubercle.has_value());
        EXPECT_LT((*merged.tubercle - *apart.tubercle).norm(), 2.0);
        EXPECT_LT((merged.head - apart.head).norm(), 4.0);
    }

    TEST(JointPlaces, ARibWithoutATubercleTakesTheAxisOfTheNearestOfItsSide)
    {
        // Two ribs above each other; the process reaches the lower one only.
        mesh::LabelVolume labels = straight_rib(1.0, 22.0, 30.0);
        const mesh::LabelVolume lower = labels;
        const int n = labels.grid.size[2];
        labels.grid.size[2] = 3 * n; // the spine alone lies between the ribs
        for (int copy = 0; copy < 2; ++copy)
            labels.voxels.insert(labels.voxels.end(), lower.voxels.begin(), lower.voxels.end());
        const auto with_upper = [&](const std::string& name) {
            mesh::LabelVolume image = labels;
            image.table.push_back({ 3, name, "bone", mesh::Role::wall });
            for (int k = n; k < 3 * n; ++k)
                for (int j = 0; j < image.grid.size[1]; ++j)
                    for (int i = 0; i < image.grid.size[0]; ++i) {
                        Label& label = image.voxels[image.grid.offset(i, j, k)];
                        if (label == 1)
                            label = k < 2 * n ? 0 : 3;
                        else if (label == 2 && i > 12)
                            label = 0;
                    }
            return places_of(image);
        };
        const auto both = with_upper("rib_left_4");
        const JointPlaces &own = both.at("rib_left_5"), &taken = both.at("rib_left_4");
        EXPECT_FALSE(own.axis_of_neighbour);
        ASSERT_TRUE(taken.axis_of_neighbour);
        EXPECT_LT(((*taken.tubercle - taken.head) - (*own.tubercle - own.head)).norm(), 1e-9);
        EXPECT_FALSE(with_upper("rib_right_4").at("rib_right_4").tubercle.has_value());
        EXPECT_FALSE(with_upper("rib_left_12").at("rib_left_12").tubercle.has_value());
    }

    TEST(JointPlaces, AShortContactHasOnePlaceAndAFarBoneHasNone)
    {
        const auto head = places_of(straight_rib(1.0, 300.0, 300.0));
        ASSERT_EQ(head.size(), 1U);
        EXPECT_FALSE(head.at("rib_left_5").tubercle.has_value());
        const auto beyond = places_of(straight_rib(1.0, 70.0, 80.0)); // a second contact far down the shaft
        EXPECT_FALSE(beyond.at("rib_left_5").tubercle.has_value());
        mesh::LabelVolume labels = straight_rib(1.0, 300.0, 300.0);
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i)
                    if (labels.grid.world(Vec3(i, j, k)).x() < 8.0 && labels.voxels[labels.grid.offset(i, j, k)] == 1)
                        labels.voxels[labels.grid.offset(i, j, k)] = 0;
        EXPECT_TRUE(places_of(labels).empty());
        EXPECT_TRUE(joint_places(labels, {}).empty());
    }

} // namespace joint_places_test
} // namespace retractor::planner
