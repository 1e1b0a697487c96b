#include "planner/measures/joint_loads.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace retractor::planner {
namespace joint_loads_test {

    constexpr double kRoundOff = 1e-12;

    /// Two nodes of a wall, 4 and 9, 20 mm apart along x.
    BoneForces two_nodes()
    {
        BoneForces bone;
        bone.node_of = { 4, 9 };
        bone.positions = Points::Zero(2, 3);
        bone.positions(1, 0) = 20.0;
        bone.forces = Points::Zero(2, 3);
        return bone;
    }

    TEST(JointLoads, OfSpringsAreStiffnessTimesDisplacement)
    {
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * 10);
        u[3 * 4 + 1] = 1.0;
        u[3 * 9 + 1] = 3.0;
        const std::vector<fem::BeddedVertex> springs { { 2, 100.0 }, { 4, 5.0 }, { 9, 5.0 } };
        const auto load = spring_load(two_nodes(), springs, u);
        ASSERT_TRUE(load.has_value());
        EXPECT_NEAR(load->force_N, 20.0, kRoundOff);
        EXPECT_NEAR(load->moment_Nm, 0.1, kRoundOff); // (15 - 5) N times 10 mm
        EXPECT_FALSE(spring_load(two_nodes(), std::vector<fem::BeddedVertex> { { 2, 100.0 } }, u).has_value());
    }

    TEST(JointLoads, OfCartilageAreTheForcesOnTheSharedNodes)
    {
        BoneForces bone = two_nodes();
        bone.forces(0, 2) = 7.0;
        bone.forces(1, 2) = -7.0;
        std::vector<std::uint8_t> cartilage(10, 0);
        EXPECT_FALSE(cartilage_load(bone, cartilage).has_value());
        cartilage[9] = 1;
        EXPECT_NEAR(cartilage_load(bone, cartilage)->force_N, 7.0, kRoundOff);
        cartilage[4] = 1;
        const auto couple = cartilage_load(bone, cartilage);
        EXPECT_NEAR(couple->force_N, 0.0, kRoundOff);
        EXPECT_NEAR(couple->moment_Nm, 0.14, kRoundOff);
    }

} // namespace joint_loads_test
} // namespace retractor::planner
