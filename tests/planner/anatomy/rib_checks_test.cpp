#include "planner/anatomy/rib_checks.h"

#include "planner/anatomy/rib_name.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace rib_checks_test {

    constexpr double kDegree = std::numbers::pi / 180.0;

    /// Relabels voxels of one rib between two angles from straight back.
    void relabel(mesh::LabelVolume& labels, const std::string& rib, double from_deg, double to_deg, Label to)
    {
        const Label id = mesh::label_named(labels.table, rib).id;
        std::size_t voxel = 0;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            const Vec3 place = labels.grid.world(Vec3(i, j, k));
            const double angle = std::atan2(std::abs(place.x()), place.y()) / kDegree;
            if (label == id && angle >= from_deg && angle <= to_deg)
                labels.voxels[voxel] = to;
            ++voxel;
        });
    }

    Label other_bone(mesh::LabelVolume& labels)
    {
        constexpr Label kId = 200;
        labels.table.push_back({ kId, "bone_other", "bone", mesh::Role::wall });
        return kId;
    }

    bool says(const std::vector<std::string>& doubts, const std::string& words)
    {
        for (const std::string& doubt : doubts)
            if (doubt.find(words) != std::string::npos)
                return true;
        return false;
    }

    std::string all(const std::vector<std::string>& doubts)
    {
        std::string text;
        for (const std::string& doubt : doubts)
            text += doubt + "\n";
        return text;
    }

    TEST(RibName, IsReadFromALabel)
    {
        EXPECT_EQ(rib_name("rib_left_5"), (RibName { .left = true, .number = 5 }));
        EXPECT_EQ(rib_name("rib_right_12"), (RibName { .left = false, .number = 12 }));
        for (const char* other : { "rib_left_", "rib_left_0", "rib_left_14", "rib_left_5a", "rib_5", "sternum", "" })
            EXPECT_FALSE(rib_name(other)) << other;
        EXPECT_EQ(rib_in_words({ .left = false, .number = 8 }), "rib 8 on the right");
    }

    TEST(RibChecks, APieceHasTheLengthOfItsArc)
    {
        for (const double spacing : { 2.0, 3.0 }) {
            const test_support::ChestShape shape { .spacing = spacing };
            const mesh::LabelVolume labels = test_support::synthetic_chest(shape);
            const auto pieces = bone_pieces(labels, mesh::flagged_labels(labels.table, [](const mesh::LabelInfo& info) {
                return info.name == "rib_left_4";
            }));
            ASSERT_EQ(pieces.size(), 1U);
            const double arc = shape.rib_radius * (test_support::kRibToDeg - test_support::kRibFromDeg) * kDegree;
            // The shortest way keeps to the inner side of the arc, and steps between voxels are longer than the way.
            constexpr double kWay = 0.12;
            EXPECT_NEAR(pieces.front().length_mm, arc, kWay * arc) << spacing;
            EXPECT_FALSE(pieces.front().at_image_end);
            EXPECT_GT(pieces.front().thickness_mm(), 0.8 * shape.rib_thickness);
            EXPECT_LT(pieces.front().thickness_mm(), 1.4 * shape.rib_height);
        }
    }

    TEST(RibChecks, AWholeChestHasNoDoubts)
    {
        for (const double spacing : { 2.0, 3.0, 4.0 })
            EXPECT_EQ(all(rib_doubts(test_support::synthetic_chest({ .spacing = spacing }))), "") << spacing;
        const Mat3 turned = Eigen::AngleAxisd(0.4, Vec3(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
        EXPECT_EQ(
            all(rib_doubts(test_support::moved(test_support::synthetic_chest(), turned, Vec3(5.0, 6.0, 7.0)))), "");
        EXPECT_TRUE(rib_doubts({}).empty());
    }

    TEST(RibChecks, ARibThatEndsEarlyIsNamedWithItsLength)
    {
        mesh::LabelVolume labels = test_support::synthetic_chest();
        relabel(labels, "rib_right_5", 70.0, 180.0, 0);
        const auto doubts = rib_doubts(labels);
        EXPECT_EQ(doubts.size(), 1U) << all(doubts);
        EXPECT_TRUE(says(doubts, "rib 5 on the right is ")) << all(doubts);
        EXPECT_TRUE(says(doubts, "and rib 5 on the left ")) << all(doubts);
        // Both sides alike: the neighbours tell.
        relabel(labels, "rib_left_5", 70.0, 180.0, 0);
        EXPECT_TRUE(says(rib_doubts(labels), "and its neighbours")) << all(rib_doubts(labels));
    }

    TEST(RibChecks, TheLostPartIsFoundInOtherBone)
    {
        mesh::LabelVolume labels = test_support::synthetic_chest();
        const Label other = other_bone(labels);
        relabel(labels, "rib_right_5", 70.0, 180.0, other);
        const auto doubts = rib_doubts(labels);
        EXPECT_EQ(doubts.size(), 2U) << all(doubts);
        EXPECT_TRUE(says(doubts, "have the shape of a rib")) << all(doubts);
        EXPECT_TRUE(says(doubts, "mm from the end of rib 5 on the right and may belong to it")) << all(doubts);
    }

    TEST(RibChecks, ARibInPiecesIsNamed)
    {
        mesh::LabelVolume labels = test_support::synthetic_chest();
        relabel(labels, "rib_left_3", 60.0, 66.0, 0);
        const auto doubts = rib_doubts(labels);
        EXPECT_TRUE(says(doubts, "rib 3 on the left is in pieces")) << all(doubts);
    }

    TEST(RibChecks, ALumpOfOtherBoneIsNoRib)
    {
        mesh::LabelVolume labels = test_support::synthetic_chest();
        const Label other = other_bone(labels);
        std::size_t voxel = 0;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label) {
            if ((labels.grid.world(Vec3(i, j, k)) - Vec3(0.0, 60.0, 20.0)).norm() < 12.0)
                labels.voxels[voxel] = other;
            ++voxel;
        });
        EXPECT_EQ(all(rib_doubts(labels)), "");
    }

} // namespace rib_checks_test
} // namespace retractor::planner
