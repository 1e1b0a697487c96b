#include "planner/measures/bones/joint_loads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
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

    /// A wall with ten nodes on a line; nodes 4 and 9 are those of the bone.
    mesh::TetMesh wall()
    {
        mesh::TetMesh mesh;
        mesh.vertices = Points::Zero(10, 3);
        mesh.vertices(9, 0) = 20.0;
        return mesh;
    }

    TEST(JointLoads, OfSpringsAreStiffnessTimesDisplacement)
    {
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * 10);
        u[3 * 4 + 1] = 1.0;
        u[3 * 9 + 1] = 3.0;
        const fem::Supports springs { .bedded = { { 2, 100.0 }, { 4, 5.0 }, { 9, 5.0 } } };
        const auto load = spine_joint_load(two_nodes(), wall(), springs, u);
        ASSERT_TRUE(load.has_value());
        EXPECT_NEAR(load->force_N, 20.0, kRoundOff);
        EXPECT_NEAR(load->moment_Nm, 0.1, kRoundOff); // (15 - 5) N times 10 mm
        EXPECT_FALSE(load->turn_deg.has_value());
        EXPECT_FALSE(spine_joint_load(two_nodes(), wall(), { .bedded = { { 2, 100.0 } } }, u).has_value());
    }

    TEST(JointLoads, OfAHingeAreItsTorqueAndItsTurn)
    {
        constexpr double kDegree = std::numbers::pi / 180.0;
        fem::Supports supports { .bedded = { { 4, 5.0 } },
            .hinges = { { .name = "rib_left_5",
                .axis = Vec3::UnitZ(),
                .stiffness = 800.0,
                .range = 6.6 * kDegree,
                .stop_stiffness = 8000.0,
                .toe = kDegree,
                .edges = { { 4, 9, 1.0 } } } } };
        for (const double degrees : { 5.0, -9.0 }) {
            BoneForces bone = two_nodes();
            const Vec3 end(20.0 * std::cos(degrees * kDegree), 20.0 * std::sin(degrees * kDegree), 0.0);
            bone.positions.row(1) = end.transpose();
            Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * 10);
            u.segment<3>(3 * 9) = end - Vec3(20.0, 0.0, 0.0);
            const auto load = spine_joint_load(bone, wall(), supports, u);
            ASSERT_TRUE(load.has_value());
            EXPECT_NEAR(load->force_N, 0.0, kRoundOff);
            const double torque = fem::hinge_torque(supports.hinges[0], degrees * kDegree).torque;
            EXPECT_NEAR(load->moment_Nm, 1e-3 * std::abs(torque), kRoundOff);
            ASSERT_TRUE(load->turn_deg.has_value());
            EXPECT_NEAR(*load->turn_deg, std::abs(degrees), 1e-9);
            EXPECT_EQ(load->at_stop, std::abs(degrees) > 6.6);
        }
        supports.hinges[0].edges = { { 2, 3, 1.0 } }; // of another bone
        EXPECT_FALSE(spine_joint_load(two_nodes(), wall(), supports, Eigen::VectorXd::Zero(30))->turn_deg.has_value());
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
