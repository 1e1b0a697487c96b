#pragma once
// A retractor as a rigid body: a frame with two blades, one on each lip. The blades stand on a rack, which sets the
// distance between them, and each blade turns about its arm within its play. Nothing holds the frame but the tissue.
// Units mm, N, rad; frame patient LPS.
//
// A blade is a HookPatch that turns: its pivot is the place of its arm. The state of the frame has nine numbers: three
// of translation, three of rotation, one turn for each blade, and the distance of the rack. The generalised forces that
// belong to these numbers (virtual work: Goldstein, Poole, Safko 2002, Classical Mechanics, 1.4) are the resultant
// force, the resultant moment, the moment of each blade about its arm, and the force along the rack. In equilibrium the
// first six are zero, and so is the moment about an arm whose blade is not at a stop.

#include "fem/statics/boundary_conditions.h"
#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <span>
#include <vector>

namespace retractor::fem {

/// A blade of the frame, at rest.
struct FrameBlade {
    Vec3 pivot = Vec3::Zero(); ///< place on the axis of the arm, mm
    Vec3 arm = Vec3::UnitY(); ///< axis about which the blade turns, unit
    Vec3 outward = Vec3::UnitX(); ///< direction in which the rack moves the blade, unit; opposite for the two blades
    double play = 0.0; ///< largest turn to either side, rad, >= 0; 0: the blade is fixed to its arm
};

using BladeFrame = std::array<FrameBlade, 2>;

/// Where the frame is.
struct FrameState {
    Mat3 rotation = Mat3::Identity(); ///< of the frame, about frame_centre()
    Vec3 translation = Vec3::Zero(); ///< of the frame's centre, mm
    std::array<double, 2> turn {}; ///< of each blade about its arm, rad
    double distance = 0.0; ///< by which the rack has moved the blades apart, mm
};

/// The numbers of the state, in the order of all vectors and matrices here. Rotation and turns are multiplied by
/// frame_lever(), so that all numbers are in mm and all generalised forces in N.
inline constexpr int kFrameUnknowns = 9, kFrameRotation = 3, kFrameTurns = 6, kFrameDistance = 8;
using FrameVector = Eigen::Matrix<double, kFrameUnknowns, 1>;
using FrameMatrix = Eigen::Matrix<double, kFrameUnknowns, kFrameUnknowns>;

/// The force and the moment that the frame applies to the tissue at one blade.
struct BladeLoad {
    Vec3 force_N = Vec3::Zero();
    Vec3 moment_Nmm = Vec3::Zero(); ///< about the blade's pivot, where the pivot has moved to
    /// Sum over the nodes of lever times force (transposed), N mm: the moment's change when forces stay and levers
    /// turn.
    Mat3 dyad_Nmm = Mat3::Zero();
};

/// @throws InputError naming the blade when a number is not finite or out of range, an axis is not a unit vector, or
/// the two blades do not move in opposite directions across their arms
void check_frame(const BladeFrame& frame);

/// The middle between the pivots at rest.
Vec3 frame_centre(const BladeFrame& frame);

/// The largest distance of a node of the blades from the centre at rest, mm.
double frame_lever(const mesh::TetMesh& mesh, const BladeFrame& frame, std::span<const HookPatch> blades);

/// The blades where the frame holds them: displacement, rotation and pivot are set.
std::vector<HookPatch> blades_at(const BladeFrame& frame, const FrameState& state, std::vector<HookPatch> blades);

/// The state after a step. The rotation is turned further about the present centre.
FrameState moved_by(const FrameState& state, const FrameVector& step, double lever);

/// Forces and moments of each blade.
/// @param blades as blades_at() gives them
/// @param nodal_forces_N three per node (OpeningResult::hook_nodal_forces_N)
std::array<BladeLoad, 2> blade_loads(
    const mesh::TetMesh& mesh, std::span<const HookPatch> blades, const Eigen::VectorXd& nodal_forces_N);

/// The generalised forces of the state, N.
FrameVector generalised_forces(
    const BladeFrame& frame, const FrameState& state, const std::array<BladeLoad, 2>& loads, double lever);

/// Small motions of the blades' nodes, one per column: for each blade three translations (mm) and three rotations about
/// its present pivot (rad).
/// @return 3 nodes x 12
Eigen::MatrixXd blade_motions(const mesh::TetMesh& mesh, std::span<const HookPatch> blades);

/// The motions of the blades, as the columns of blade_motions(), for small steps of the state.
/// @return 12 x 9
Eigen::Matrix<double, 12, kFrameUnknowns> blades_by_state(
    const BladeFrame& frame, const FrameState& state, double lever);

/// The derivative of generalised_forces() by the state, N/mm.
/// @param stiffness of the tissue for blade_motions(), 12 x 12 (motion_response())
FrameMatrix frame_stiffness(const BladeFrame& frame, const FrameState& state, const std::array<BladeLoad, 2>& loads,
    const Eigen::MatrixXd& stiffness, double lever);

} // namespace retractor::fem
