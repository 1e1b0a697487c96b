#pragma once
// Inserts vertices into a tetrahedral mesh. Units mm; frame patient LPS.

#include "mesh/tetrahedra/tet_mesh.h"

#include <array>

namespace retractor::mesh {

/// A corner whose weight is below this share is passed over by insert_vertex(): the vertex is placed on the opposite
/// edge, or at a corner. New elements then keep at least this share of the volume of the element that they divide.
inline constexpr double kLeastInsertionWeight = 0.2;

/// Returns a vertex at a point on a face, and divides the elements on both sides where no vertex stands there yet. New
/// vertices and elements are appended; a divided element keeps its id for one of its parts. All parts have its label.
/// @param face three corners of an element
/// @param weights barycentric coordinates on the face, not negative, sum 1
/// @pre mesh.nodes_per_tet == 4
VertexId insert_vertex(TetMesh& mesh, const std::array<VertexId, 3>& face, const Vec3& weights);

} // namespace retractor::mesh
