#include "planner/case/division.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace retractor::planner {
namespace division_test {

    std::string refused_at(const Division& division)
    {
        try {
            check_division(division, "/approaches/0/division");
        } catch (const InputError& error) {
            return error.where();
        }
        return "accepted";
    }

    TEST(Division, ItsWordsComeBack)
    {
        for (const DivisionExtent extent : { DivisionExtent::skin, DivisionExtent::full })
            EXPECT_EQ(division_extent_from_string(to_string(extent)), extent);
        EXPECT_FALSE(division_extent_from_string("half"));
        EXPECT_EQ(Division {}.extent, DivisionExtent::skin); // old cases keep their meaning
    }

    TEST(Division, DistancesGoWithFullDivisionOnly)
    {
        EXPECT_EQ(refused_at({}), "accepted");
        EXPECT_EQ(refused_at({ .extent = DivisionExtent::full }), "accepted");
        EXPECT_EQ(refused_at({ .extent = DivisionExtent::full, .forwards_mm = 0.0, .backwards_mm = 60.0 }), "accepted");
        EXPECT_EQ(refused_at({ .forwards_mm = 10.0 }), "/approaches/0/division/forwards_mm");
        EXPECT_EQ(refused_at({ .backwards_mm = 10.0 }), "/approaches/0/division/backwards_mm");
    }

    TEST(Division, DistancesOutOfRangeAreRefused)
    {
        for (const double bad : { -1.0, 501.0, std::numeric_limits<double>::quiet_NaN() }) {
            EXPECT_EQ(refused_at({ .extent = DivisionExtent::full, .forwards_mm = bad }),
                "/approaches/0/division/forwards_mm");
            EXPECT_EQ(refused_at({ .extent = DivisionExtent::full, .backwards_mm = bad }),
                "/approaches/0/division/backwards_mm");
        }
    }

    TEST(Division, SeversIntercostalMuscleWhereItHasALabel)
    {
        mesh::LabelTable table { { 1, "skin", "skin", mesh::Role::wall }, { 2, "muscle", "muscle", mesh::Role::wall },
            { 3, "intercostal", "intercostal", mesh::Role::wall }, { 4, "rib_left_4", "bone", mesh::Role::wall },
            { 5, "costal_cartilages", "cartilage", mesh::Role::wall }, { 6, "pleura", "muscle", mesh::Role::wall },
            { 7, "lung_left", "lung", mesh::Role::voxel } };
        const DividedLabels own = divided_labels(table);
        EXPECT_TRUE(own.has_own);
        EXPECT_EQ(own.names, (std::vector<std::string> { "intercostal", "pleura" }));
        EXPECT_EQ(own.ids, (std::vector<Label> { 3, 6 }));
        std::erase_if(table, [](const mesh::LabelInfo& info) { return info.id == 3 || info.id == 6; });
        const DividedLabels soft = divided_labels(table);
        EXPECT_FALSE(soft.has_own);
        EXPECT_EQ(soft.names, std::vector<std::string> { "muscle" });
    }

    TEST(Division, ItsBladeCutsNothingBehindItsLine)
    {
        const DivisionStroke stroke { .line = { Vec3(0, 0, 0), Vec3(10, 0, 0) },
            .directions = { Vec3(0, 0, 1), Vec3(0, 0, 1) },
            .depth_mm = 14.0,
            .length_mm = 10.0 };
        const mesh::SweptBlade blade(blade_of(stroke));
        EXPECT_DOUBLE_EQ(blade.length(), 10.0);
        EXPECT_DOUBLE_EQ(blade.depth(), 14.0);
        EXPECT_DOUBLE_EQ(blade.box(0.0, 10.0).min().z(), 0.0);
    }

} // namespace division_test
} // namespace retractor::planner
