#include "planner/case/label_correction.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace retractor::planner {
namespace label_correction_test {

    Case named_everywhere()
    {
        Case c;
        c.label_table = { { 1, "skin", "skin", mesh::Role::wall }, { 2, "rib_left_4", "bone", mesh::Role::wall },
            { 3, "rib_left_5", "bone", mesh::Role::wall }, { 4, "lung_left", "lung", mesh::Role::voxel },
            { 5, "lung_upper_left", "lung", mesh::Role::voxel } };
        c.estimated_labels = { "rib_left_4", "lung_left" };
        c.supports.labels = { "rib_left_4" };
        c.pressures = { { "lung_left", 1.0 }, { "lung_upper_left", 2.0 } };
        Approach approach;
        approach.name = "one";
        approach.target.label = "lung_left";
        approach.retracted = { "lung_left", "lung_upper_left" };
        approach.uncut_labels = { "rib_left_4", "rib_left_5" };
        approach.ablations = { { .label = "rib_left_4" } };
        c.approaches = { approach };
        return c;
    }

    TEST(LabelCorrection, ARenamedLabelIsRenamedWhereverItStands)
    {
        Case c = named_everywhere();
        rename_label(c, "rib_left_4", "rib_left_3");
        EXPECT_NE(mesh::find_label(c.label_table, "rib_left_3"), nullptr);
        EXPECT_EQ(mesh::find_label(c.label_table, "rib_left_4"), nullptr);
        EXPECT_EQ(c.estimated_labels.front(), "rib_left_3");
        EXPECT_EQ(c.supports.labels.front(), "rib_left_3");
        EXPECT_EQ(c.approaches[0].uncut_labels.front(), "rib_left_3");
        EXPECT_EQ(c.approaches[0].ablations[0].label, "rib_left_3");
        rename_label(c, "lung_left", "lung_lower_left");
        EXPECT_EQ(c.approaches[0].target.label, "lung_lower_left");
        EXPECT_EQ(c.pressures.front().label, "lung_lower_left");
    }

    TEST(LabelCorrection, AJoinedLabelIsNamedOnce)
    {
        Case c = named_everywhere();
        EXPECT_THROW(join_label(c, "lung_left", "lung_upper_left"), InputError) << "the target would be held aside";
        c.approaches[0].target.label = "lung_upper_left";
        join_label(c, "lung_left", "lung_upper_left");
        EXPECT_EQ(c.approaches[0].retracted, std::vector<std::string> { "lung_upper_left" });
        ASSERT_EQ(c.pressures.size(), 1U);
        EXPECT_EQ(c.pressures.front().pressure_kPa, 2.0) << "the pressure of the label that stays";
        EXPECT_TRUE(is_estimated(c, "lung_upper_left")) << "a part of it is estimated";
        EXPECT_EQ(mesh::find_label(c.label_table, "lung_left"), nullptr);
    }

    TEST(LabelCorrection, RefusesAndLeavesTheCase)
    {
        Case c = named_everywhere();
        EXPECT_THROW(rename_label(c, "spleen", "liver"), InputError);
        EXPECT_THROW(rename_label(c, "rib_left_4", "rib_left_5"), InputError);
        for (const char* bad : { "", "a,b", "a:b", "a/b", "-x", "a b", "a\nb", "1,2,3,4" })
            EXPECT_THROW(rename_label(c, "rib_left_4", bad), InputError) << bad;
        EXPECT_THROW(join_label(c, "rib_left_4", "lung_left"), InputError) << "bone is no lung";
        EXPECT_THROW(join_label(c, "skin", "rib_left_4"), InputError) << "skin is no bone";
        EXPECT_THROW(join_label(c, "rib_left_4", "rib_left_4"), InputError);
        EXPECT_THROW(join_label(c, "rib_left_4", "liver"), InputError);
        EXPECT_THROW(confirm_label(c, "rib_left_5"), InputError) << "it is not estimated";
        EXPECT_EQ(c.label_table.size(), 5U);
        EXPECT_EQ(c.estimated_labels.size(), 2U);
        confirm_label(c, "rib_left_4");
        EXPECT_FALSE(is_estimated(c, "rib_left_4"));
    }

} // namespace label_correction_test
} // namespace retractor::planner
