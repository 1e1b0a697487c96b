#pragma once
// The nodes of one lip under the rigid rectangular patch of a hook. Units mm; frame patient LPS.

#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace retractor::fem {

/// Returns the nodes of the lip surface inside a rectangle round `centre`, sorted. The rectangle has its width along
/// `along` and its height along `depth`; the two vectors need neither unit length nor a right angle. Lip nodes farther
/// from the plane of the rectangle than the larger of the two sizes belong to another part of the wound and are
/// excluded. A P2 edge midpoint is included when both ends of its edge are lip vertices under the patch.
/// @throws InputError naming the hook, its place and the nearest lip node when fewer than three nodes, or only nodes on
/// one line, lie under the patch (a hook is never a point), and on sizes that are NaN or not positive
std::vector<VertexId> hook_patch_nodes(const mesh::TetMesh& mesh, std::span<const std::array<VertexId, 3>> lip_faces,
    const Vec3& centre, const Vec3& along, const Vec3& depth, double width_mm = 10.0, double height_mm = 15.0,
    std::string_view name = "hook");

} // namespace retractor::fem
