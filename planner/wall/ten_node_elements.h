#pragma once
// Which elements of a cut wall get ten nodes. Four-node elements bend bone too stiffly, and fold where hooks and blades
// bear on soft tissue (docs/method/elasticity.md, Elements). Units mm.

#include "mesh/cutting/store/cut_types.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::planner {

/// Farther from the lips than this, tissue is hardly strained: docs/method/verification.md has what four-node elements
/// there change.
inline constexpr double kTenNodesWithinMm = 60.0;

/// What becomes of soft tissue at the lips.
enum class SoftLips {
    ten_nodes,
    /// Blades that bear on cut bone crush the tissue before the bone, and Newton's method takes many steps for it:
    /// soft elements that touch a lip, or are flat, get no midpoints, and soft elements that share an edge with one of
    /// these neither. Without these midpoints the phantom's median sternotomy has a force 5 to 7 % larger.
    four_nodes,
};

/// Flags the elements with midpoints: those near the lips that touch bone, cartilage or a lip. Soft elements at the
/// front of the cut, where the two lips meet, have none: slivers that the blade left there stretch many times over.
/// In a wall without bone hooks bear on soft tissue alone, and all elements have midpoints.
/// @param wall four-node elements
/// @param lips faces of the wall; none: the distance from the lips does not count
/// @returns one flag per element
std::vector<std::uint8_t> ten_node_elements(
    const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips, const mesh::LabelTable& table, SoftLips soft_lips);

/// The vertices of the lips, each once, one row each.
Points lip_points(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips);

} // namespace retractor::planner
