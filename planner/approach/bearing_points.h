#pragma once
// Finds where the patch of a hook bears on bone or cartilage. A retractor's blade lies against the rib and squeezes the
// muscle between them flat; the rib can turn on the blade. So the rib moves with the hook at the points that the patch
// touches first, and only there. Rays from the patch meet the surface of the bones in the label image. The points
// depend on the anatomy and the patch, not on a mesh. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/case/approach.h"

#include <vector>

namespace retractor::planner {

/// Bone farther behind the patch than this (mm, chosen here) does not bear: the layer between is soft tissue that the
/// hook deforms. Cuts between ribs leave less muscle than this, see kMostBelowUpperRibMm of intercostal_space.h.
inline constexpr double kBearingMm = 12.0;

/// The places on the surface of bones on which the patch bears: one for each 10 mm of the patch's middle half, without
/// places that a rigid patch does not reach. A patch that lies on bone with its own surface has none, because the lip
/// under it is the bone.
std::vector<Vec3> bearing_points(const mesh::LabelVolume& labels, const Approach& approach, const HookSpec& hook);

/// Sets HookSpec::bearing and bears_on of all hooks.
void find_bearing_points(Approach& approach, const mesh::LabelVolume& labels);

/// Inserts a vertex on a bone of the wall at each place on which a hook bears, so that the cut wall
/// has a node there. A place far from every bone of the wall is passed over.
/// @param wall before the cut, four-node elements
void insert_bearing_points(mesh::TetMesh& wall, const mesh::LabelTable& table, const Approach& approach);

/// The vertices of bone nearest to the places on which a hook bears.
std::vector<VertexId> bearing_vertices(const mesh::TetMesh& wall, const mesh::LabelTable& table, const HookSpec& hook);

} // namespace retractor::planner
