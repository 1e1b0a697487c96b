#pragma once
// The joints between ribs and spine, as springs and hinges on a mesh. Units mm, N, rad; frame patient LPS.
//
// Measured on two bodies [Lebschy 2024, J Biomech 163:111923]: a costovertebral joint gives way by 18 to 26 N/mm, and
// turns cranio-caudally by 13.2 degrees between -0.1 and 0.1 N m. A rib has two joints with the spine, at its head and
// at its tubercle (joint_places.h), so it turns about the axis through both:
// - Springs at both places, half of kJointN_per_mm each, hold the axis in place.
// - A hinge (fem/model/hinge.h) resists turning about the axis. Springs and hinge together have kJointNmm_per_rad.
// - Beyond kJointRangeRad the hinge stiffens: the stop. The joint's curve has a zone of low stiffness and nearly linear
//   zones on both sides [Lemosse 1998, doi 10.1007/s005860050021]. The stiffness of the stop is ours.
// These sums are properties of the joint, not of a mesh.
//
// Where the labels show one place only, the springs lie round this place: without an axis and without a stop. Their
// resistance to turning is then kJointNmm_per_rad in the mean over all axes.

#include "fem/model/hinge.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/wall/joint_places.h"

#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

inline constexpr double kJointN_per_mm = 22.0; ///< the middle of the measured stiffness
inline constexpr double kJointRangeRad = 6.6 * std::numbers::pi / 180.0; ///< half of 13.2 degrees
inline constexpr double kJointNmm_per_rad = 100.0 / kJointRangeRad; ///< 0.1 N m at the end of the range: 868

/// Stiffness of the stop: 20 times the stiffness within the range. The 3 N m at which ribs break at their posterior
/// part are then borne at about 17 degrees. Ours: the published curves end at 0.1 N m.
inline constexpr double kStopNmm_per_rad = 20.0 * kJointNmm_per_rad;
/// The stop reaches its stiffness over twice this angle. Ours.
inline constexpr double kStopToeRad = 1.0 * std::numbers::pi / 180.0;

/// Length of a joint along a rib from the spine: head and neck. Only where the labels show one place of the joint.
inline constexpr double kJointReachMm = 14.0;

struct RibJoints {
    std::vector<fem::BeddedVertex> springs; ///< each vertex once
    std::vector<fem::Hinge> hinges; ///< named as the labels of the ribs
    std::vector<std::string> one_point; ///< names of the labels whose joints have one place only
    std::vector<std::string> neighbours_axis; ///< names of the labels that turn about the axis of the nearest rib
};

/// The joints of the bones that reach voxels with a label in `fixed_labels`, as far as the mesh has their heads.
/// @param mesh the wall before any cut, four-node elements
RibJoints rib_joints(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> fixed_labels);

/// Text for people: the joints whose axis the labels do not show; empty when there are none.
std::string guessed_joints_text(const RibJoints& joints);

} // namespace retractor::planner
