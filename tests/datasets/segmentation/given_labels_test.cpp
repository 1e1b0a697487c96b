#include "datasets/segmentation/given_labels.h"

#include <gtest/gtest.h>

namespace retractor::datasets::segmentation {
namespace given_labels_test {

    TEST(GivenLabels, PartsBecomeTheWhole)
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 7, 1, 1 };
        labels.voxels = { 0, 4, 5, 6, 7, 8, 9 };
        labels.table = { { 4, "lung_upper_lobe_left", "lung", mesh::Role::voxel },
            { 5, "lung_lower_lobe_left", "lung", mesh::Role::voxel },
            { 6, "lung_middle_lobe_right", "lung", mesh::Role::voxel }, { 7, "vertebrae_T4", "bone", mesh::Role::wall },
            { 8, "spine", "bone", mesh::Role::wall }, { 9, "lung_nodules", "tumour", mesh::Role::target } };
        const mesh::LabelVolume joined = with_parts_joined(labels);
        const auto id = [&](const char* name) { return mesh::find_label(joined.table, name)->id; };
        ASSERT_EQ(joined.table.size(), 4u);
        EXPECT_EQ(joined.voxels,
            (std::vector<Label> {
                0, id("lung_left"), id("lung_left"), id("lung_right"), id("spine"), id("spine"), 9 }));
        EXPECT_EQ(mesh::find_label(joined.table, "lung_nodules")->role, mesh::Role::target);
        EXPECT_EQ(mesh::find_label(joined.table, "spine")->role, mesh::Role::wall);
    }

    TEST(GivenLabels, LabelsWithoutPartsStayAsTheyAre)
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 2, 1, 1 };
        labels.voxels = { 1, 2 };
        labels.table = { { 1, "lung_left", "lung", mesh::Role::voxel }, { 2, "heart", "heart", mesh::Role::at_risk } };
        const mesh::LabelVolume joined = with_parts_joined(labels);
        EXPECT_EQ(joined.voxels, labels.voxels);
        ASSERT_EQ(joined.table.size(), 2u);
        EXPECT_EQ(joined.table[1].name, "heart");
    }

} // namespace given_labels_test
} // namespace retractor::datasets::segmentation
