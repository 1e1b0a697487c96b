#pragma once
// Where a hook holds: the nodes of one lip under a rigid rectangular patch. Units mm; frame patient LPS.

#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace retractor::fem {

/// The nodes of the lip surface inside a rectangle round `centre`, sorted. The rectangle lies along `along` (width) and
/// `depth` (height), which need be neither unit nor exactly perpendicular; lip nodes further from its plane than the
/// larger of the two sizes belong to another part of the wound and are left out. P2: edge midpoints are included when
/// both ends of their edge are lip vertices under the patch.
/// @throws InputError naming the hook, its place and the nearest lip node when fewer than three nodes, or nodes on one
/// line only, lie under the patch (a hook is never a point), and on NaN or non-positive sizes.
std::vector<VertexId> hook_patch_nodes(const mesh::TetMesh& mesh, std::span<const std::array<VertexId, 3>> lip_faces,
    const Vec3& centre, const Vec3& along, const Vec3& depth, double width_mm = 10.0, double height_mm = 15.0,
    std::string_view name = "hook");

} // namespace retractor::fem
