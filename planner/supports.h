#pragma once
// Where the wall is held: at the spine, and where the model was cut off from the rest of the body.

#include "mesh/tet_mesh.h"
#include "mesh/volume.h"

#include <span>
#include <vector>

namespace retractor {

/// Width of a costovertebral joint, with the half voxels that the mesh's surface may stand off the labels.
inline constexpr double kJointGapMm = 5.0;

/// Vertices that do not move:
/// - the spine side: all vertices of elements with a label in `fixed_labels`, and boundary vertices within kJointGapMm
///   of voxels with such a label (rib heads stand off the spine by the joint's gap);
/// - the model's cut-off border: boundary vertices beyond which, two voxels along the outward normal, the labels
///   still show wall, or where the image ends. Bone and cartilage are held only where they were cut off from other
///   bone, not by the soft tissue left out round them.
/// @param mesh the wall before any cut, mm, patient LPS.
/// @param region_border whether the cut-off border is held.
std::vector<VertexId> wall_supports(
    const TetMesh& mesh, const LabelVolume& labels, std::span<const Label> fixed_labels, bool region_border);

} // namespace retractor
