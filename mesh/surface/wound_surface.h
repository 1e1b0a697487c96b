#pragma once
// Triangle surfaces of a deformed tetrahedral mesh: what blocks the view and what is drawn.
// Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// A surface taken out of a tetrahedral mesh, with the way back.
struct TetSurface {
    TriMesh surface; ///< vertices used only; labels: the owning element's, one per triangle
    std::vector<VertexId> vertex_of; ///< per surface vertex: the vertex of the tetrahedral mesh
    std::vector<TetFace> face_of; ///< per triangle: the element face it is (a part of)
};

/// All faces with tissue on one side only (skin, inner side, lips, region border), at rest position + displacement.
/// P1: one triangle per face. P2: four triangles per face, through the edge midpoints.
/// @param displacement n x 3 (mm), one row per mesh vertex; no rows at all means none (the rest configuration).
/// @throws InputError on a wrong number of rows or on NaN.
TetSurface boundary_surface(const TetMesh& mesh, const Points& displacement);

/// The surface only of boundary_surface().
TriMesh deformed_boundary(const TetMesh& mesh, const Points& displacement);

/// The outer surface of the elements with the given labels, also where they meet other tissue (ribs inside
/// the wall): each face between a listed and an unlisted label (or nothing), outward from the listed one; faces
/// between two listed labels are left out. Closed wherever the listed tissue is a solid.
TetSurface tissue_surface(const TetMesh& mesh, const Points& displacement, std::span<const Label> labels);

} // namespace retractor::mesh
