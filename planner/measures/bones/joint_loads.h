#pragma once
// Loads of the joints of a bone: on the springs and the hinge that stand for its joint with the spine
// (planner/wall/rib_joints.h), and where the bone meets cartilage. Units mm, N, N m; frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "planner/measures/bones/bone_forces.h"
#include "planner/measures/field_metrics.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>

namespace retractor::planner {

/// Force and moment of the joint of a bone with the spine: of the springs under the bone and of the hinges in it, about
/// the middle of the springs; and the turn of the first hinge. Empty when no node of the bone rests on a spring.
/// @param wall the solved wall, at rest
/// @param displacement three per node of the wall, mm
std::optional<JointLoad> spine_joint_load(const BoneForces& bone, const mesh::TetMesh& wall,
    const fem::Supports& supports, const Eigen::VectorXd& displacement);

/// Force and moment on the nodes that the bone shares with elements of cartilage, about the middle of these nodes. Soft
/// tissue at the rim of the cartilage counts with it. Empty when the bone meets no cartilage.
/// @param is_cartilage one flag per node of the wall
std::optional<JointLoad> cartilage_load(const BoneForces& bone, std::span<const std::uint8_t> is_cartilage);

} // namespace retractor::planner
