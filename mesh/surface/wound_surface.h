#pragma once
// Triangle surfaces of a deformed tetrahedral mesh, for the line of sight and for pictures. Units mm; frame patient
// LPS.

#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// A surface of a tetrahedral mesh, with the map back to the mesh.
struct TetSurface {
    TriMesh surface; ///< only used vertices; one label per triangle, from its element
    std::vector<VertexId> vertex_of; ///< per surface vertex: vertex of the tetrahedral mesh
};

/// All faces with tissue on one side only (skin, inner side, lips, border of the region), at rest position +
/// displacement. A P1 face gives one triangle. A P2 face gives one triangle more for each edge with a midpoint.
/// @param displacement n x 3 (mm), one row per mesh vertex; without rows: the rest configuration
/// @throws InputError on a wrong number of rows or on NaN
TetSurface boundary_surface(const TetMesh& mesh, const Points& displacement);

/// The surface of boundary_surface() without the maps.
TriMesh deformed_boundary(const TetMesh& mesh, const Points& displacement);

/// The outer surface of the elements with the given labels, also where these elements meet other tissue (ribs inside
/// the wall). The surface consists of the faces between a listed label and an unlisted label or nothing, oriented
/// outwards from the listed label. Faces between two listed labels are left out. The surface is closed where the listed
/// tissue is a solid.
TetSurface tissue_surface(const TetMesh& mesh, const Points& displacement, std::span<const Label> labels);

} // namespace retractor::mesh
