#include "planner/approach/divided_bones.h"

#include "planner/approach/approach_templates.h"
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
        // The same blade a rib's pitch lower, half on the rib: bone that a scalpel does not sever is not divided.
        for (Vec3& point : between.incision)
            point.z() -= 0.5 * test_support::ChestShape {}.rib_pitch;
        EXPECT_TRUE(divided_bones(labels, between).empty());
        between.uncut_labels.clear();
        EXPECT_EQ(divided_bones(labels, between), std::vector<std::string> { "rib_left_5" });
        EXPECT_TRUE(divided_bones(labels, between, 1e6).empty());
    }

} // namespace divided_bones_test
} // namespace retractor::planner
