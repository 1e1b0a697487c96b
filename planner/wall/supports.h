#pragma once
// Finds where the wall is held: at the spine, and where the model was cut off from the rest of the body. Units mm, N;
// frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::planner {

/// Vertices that do not move:
/// - The spine side: all vertices of elements with a label in `fixed_labels`, and boundary vertices of soft tissue
///   within kJointGapMm of voxels with such a label. The heads of ribs rest on the springs of their joints instead
///   (rib_joints.h).
/// - The cut-off border of the model: where the image ends, and where bone was cut off from other bone. With a spine
///   side, bones kept whole are not held where the image ends, because ribs have their joints and the shoulder girdle
///   hangs in muscle.
/// - Without a spine side, also soft tissue that was cut off: boundary vertices for which the labels still show wall
///   two voxels along the outward normal. With a spine side, soft tissue hangs on the ribs that it moves with, and a
///   held border would tear the tissue off the ribs.
///
/// @param mesh the wall before any cut, mm, patient LPS
/// @param whole_labels labels that the mesh keeps to their ends (MeshSizing), so that nothing of them is cut off
/// @param region_border whether the cut-off border is held
std::vector<VertexId> wall_supports(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels,
    std::span<const Label> fixed_labels, std::span<const Label> whole_labels, bool region_border);

/// Corners of the faces at which the mesh was cut off. Such a face is no surface of the body, whether held or not: one
/// and two voxels along its normal the labels still show wall, or the image ends.
/// @param mesh the wall before any cut, mm, patient LPS
std::vector<VertexId> cut_off_vertices(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels);

/// Beds under the bones of the shoulder girdle. These bones have no joint with the spine. They hang in muscle, which
/// the mesh does not hold beyond its region. Their bare vertices, beyond which the labels show soft tissue, rest on
/// springs of kBedModulus times the vertex's share of the surface.
/// The rib cage holds itself, because its ribs have joints and the muscle between them moves along.
/// @param whole_labels labels kept whole, see wall_supports(); those of the rib cage (ribs, sternum, cartilages) get no
/// bed
std::vector<fem::BeddedVertex> girdle_beds(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> whole_labels);

/// Stiffness of a bed (N/mm per mm^2): muscle (0.04 MPa) that gives way over 150 mm, half the width of a chest.
inline constexpr double kBedModulus = 0.04 / 150.0;

} // namespace retractor::planner
