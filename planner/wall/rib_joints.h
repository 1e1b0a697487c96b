#pragma once
// The joints between ribs and spine, as beds of springs under the heads of the ribs. Units mm, N; frame patient LPS.
//
// Two bodies were measured (Lebschy 2024, J Biomech 163:111923): a costovertebral joint gives way by 18 to 26 N/mm, and
// turns by 13.2 degrees between -0.1 and 0.1 N m. Both are properties of the joint, not of a mesh: the springs of a
// joint have these sums on every mesh. The stiffening beyond the measured range is not modelled.

#include "fem/statics/boundary_conditions.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::planner {

inline constexpr double kJointN_per_mm = 22.0; ///< the middle of the measured stiffness
inline constexpr double kJointNmm_per_rad = 868.0; ///< 0.2 N m over 13.2 degrees

/// Largest distance over a costovertebral joint: the width of the joint, and the half voxels between the mesh's surface
/// and the labels.
inline constexpr double kJointGapMm = 5.0;
/// Length of a joint along a rib from the spine: head and neck.
inline constexpr double kJointReachMm = 14.0;

/// The springs of all joints. A joint is a connected part of a bone within kJointReachMm of voxels with a label in
/// `fixed_labels`, with a vertex within kJointGapMm of them. Its springs add up to kJointN_per_mm; about its middle
/// they resist turning, in the mean over all axes, with kJointNmm_per_rad, as far as the part is large enough.
/// @param mesh the wall before any cut, four-node elements
std::vector<fem::BeddedVertex> rib_joints(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> fixed_labels);

/// Distance of a point from the nearest centre of a voxel with a wanted label, mm; infinite beyond `reach`.
double distance_to_labels(
    const mesh::LabelVolume& labels, const mesh::LabelFlags& wanted, const Vec3& point, double reach);

} // namespace retractor::planner
