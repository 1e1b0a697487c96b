#pragma once
// Where the wall is held: at the spine, and where the model was cut off from the rest of the body.

#include "fem/statics/boundary_conditions.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::planner {

/// Width of a costovertebral joint, with the half voxels that the mesh's surface may stand off the labels.
inline constexpr double kJointGapMm = 5.0;

/// Vertices that do not move:
/// - the spine side: all vertices of elements with a label in `fixed_labels`, and boundary vertices within kJointGapMm
///   of voxels with such a label (rib heads stand off the spine by the joint's gap);
/// - the model's cut-off border, where the image ends, and where bone was cut off from other bone; with a spine side,
///   bones kept whole are not held where the image ends: ribs have their joints, the shoulder girdle hangs in muscle;
/// - without a spine side, also soft tissue that was cut off: boundary vertices beyond which, two voxels along the
///   outward normal, the labels still show wall. With one, soft tissue hangs on the ribs that it moves with, and a held
///   border would tear it off them.
/// @param mesh the wall before any cut, mm, patient LPS.
/// @param whole_labels labels that the mesh keeps to their ends (MeshSizing): nothing of them is cut off.
/// @param region_border whether the cut-off border is held.
std::vector<VertexId> wall_supports(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels,
    std::span<const Label> fixed_labels, std::span<const Label> whole_labels, bool region_border);

/// Corners of the faces at which the mesh was cut off: one and two voxels along their normal the labels still show
/// wall, or the image ends. They are no surface of the body, whether they are held or not.
/// @param mesh the wall before any cut, mm, patient LPS.
std::vector<VertexId> cut_off_vertices(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels);

/// The bones of the shoulder girdle have no joint with the spine: they hang in muscle, which the mesh does not hold
/// beyond its region. Their bare vertices, beyond which the labels show soft tissue, rest on springs of kBedModulus
/// times the vertex' share of the surface. The rib cage holds itself: its ribs have their joints, and the muscle
/// between them moves along.
/// @param whole_labels as above; those of the rib cage (ribs, sternum, cartilages) get no bed.
std::vector<fem::BeddedVertex> girdle_beds(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> whole_labels);

/// Stiffness of that bed (N/mm per mm^2): muscle (0.04 MPa) that gives way over 150 mm, half the width of a chest.
inline constexpr double kBedModulus = 0.04 / 150.0;

/// Elements of bone or cartilage that stand for the joints between ribs and spine: those with a corner within
/// kJointReachMm of a voxel with a label in `fixed_labels`. A rib turns on its joint; clamped there, it would have to
/// bend.
/// @returns one flag per element.
std::vector<bool> joint_elements(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> fixed_labels);

/// How far a joint reaches along a rib from the spine: head and neck, at least one element.
inline constexpr double kJointReachMm = 14.0;

} // namespace retractor::planner
