#include "planner/approach/divided_bones.h"

#include "planner/approach/approach_templates.h"
#include "planner/approach/intercostal_space.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace retractor::planner {
namespace divided_bones_test {

    TEST(DividedBones, AreThoseUnderASawAndNoneBetweenRibs)
    {
        const mesh::LabelVolume labels = test_support::synthetic_chest();
        ApproachRequest request;
        request.target.label = "aneurysm";
        request.template_name = "median";
        const Approach median = approach_from_template(labels, request);
        EXPECT_EQ(divided_bones(labels, median), std::vector<std::string> { "sternum" });
        request.template_name = "intercostal:4";
        Approach between = approach_from_template(labels, request);
        EXPECT_TRUE(divided_bones(labels, between).empty());
        EXPECT_TRUE(crossed_bones(labels, between).empty());
        EXPECT_EQ(name_crossed_skeleton(between, labels), "");
        // The same blade over the middle of the lower rib: bone that a scalpel does not sever is not divided.
        for (Vec3& point : between.incision)
            point.z() -= kAboveLowerRibMm + 0.5 * test_support::ChestShape {}.rib_height;
        EXPECT_TRUE(divided_bones(labels, between).empty());
        EXPECT_EQ(crossed_bones(labels, between), std::vector<std::string> { "rib_left_5" });
        between.rationale = "As asked.";
        EXPECT_EQ(
            name_crossed_skeleton(between, labels), "The incision crosses bone that stays whole: rib 5 on the left.");
        EXPECT_EQ(between.rationale, "The incision crosses bone that stays whole: rib 5 on the left. As asked.");
        between.uncut_labels.clear();
        EXPECT_TRUE(crossed_bones(labels, between).empty());
        EXPECT_EQ(divided_bones(labels, between), std::vector<std::string> { "rib_left_5" });
        EXPECT_TRUE(divided_bones(labels, between, 1e6).empty());
    }

    TEST(CrossedBones, AreNoneInASpaceAndEachRibAcrossWhichOneCuts)
    {
        const mesh::LabelVolume labels = test_support::synthetic_chest();
        ApproachRequest request;
        request.target.label = "aneurysm";
        for (const bool left : { true, false })
            for (const char* space : { "intercostal:3", "intercostal:4", "intercostal:5" }) {
                request.template_name = space;
                request.left = left;
                const Approach between = approach_from_template(labels, request);
                EXPECT_TRUE(crossed_bones(labels, between).empty()) << space << (left ? " left" : " right");
            }
        // Along the body over the side of the chest: across ribs, and grazing none of them.
        request.template_name = "intercostal:4";
        request.left = true;
        Approach across = approach_from_template(labels, request);
        const std::size_t middle = across.incision.size() / 2;
        const Vec3 place = across.incision[middle], inward = across.directions[middle];
        across.incision = { place + Vec3(0.0, 0.0, 30.0), place, place - Vec3(0.0, 0.0, 30.0) };
        across.directions.assign(3, inward);
        EXPECT_GE(crossed_bones(labels, across).size(), 2U);
    }

} // namespace divided_bones_test
} // namespace retractor::planner
