#include "datasets/segmentation/given_labels.h"

#include <gtest/gtest.h>

namespace retractor::segmentation {
namespace given_labels_test {

    TEST(GivenLabels, PartsBecomeTheWhole)
    {
        LabelVolume labels;
        labels.grid.size = { 7, 1, 1 };
        labels.voxels = { 0, 4, 5, 6, 7, 8, 9 };
        labels.table
            = { { 4, "lung_upper_lobe_left", "lung", Role::voxel }, { 5, "lung_lower_lobe_left", "lung", Role::voxel },
                  { 6, "lung_middle_lobe_right", "lung", Role::voxel }, { 7, "vertebrae_T4", "bone", Role::wall },
                  { 8, "spine", "bone", Role::wall }, { 9, "lung_nodules", "tumour", Role::target } };
        const LabelVolume joined = with_parts_joined(labels);
        const auto id = [&](const char* name) { return find_label(joined.table, name)->id; };
        ASSERT_EQ(joined.table.size(), 4u);
        EXPECT_EQ(joined.voxels,
            (std::vector<Label> {
                0, id("lung_left"), id("lung_left"), id("lung_right"), id("spine"), id("spine"), 9 }));
        EXPECT_EQ(find_label(joined.table, "lung_nodules")->role, Role::target);
        EXPECT_EQ(find_label(joined.table, "spine")->role, Role::wall);
    }

    TEST(GivenLabels, LabelsWithoutPartsStayAsTheyAre)
    {
        LabelVolume labels;
        labels.grid.size = { 2, 1, 1 };
        labels.voxels = { 1, 2 };
        labels.table = { { 1, "lung_left", "lung", Role::voxel }, { 2, "heart", "heart", Role::at_risk } };
        const LabelVolume joined = with_parts_joined(labels);
        EXPECT_EQ(joined.voxels, labels.voxels);
        ASSERT_EQ(joined.table.size(), 2u);
        EXPECT_EQ(joined.table[1].name, "heart");
    }

} // namespace given_labels_test
} // namespace retractor::segmentation
