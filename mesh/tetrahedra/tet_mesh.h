#pragma once
// The tetrahedral mesh, a plain struct of arrays, with free functions. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

/// An element's nodes begin with its four corners v0 to v3, with det(v1-v0, v2-v0, v3-v0) > 0. With ten nodes the edge
/// midpoints follow in VTK's order: 01, 12, 02, 03, 13, 23. In a mesh of both kinds some edges are straight: they have
/// no midpoint, and their entry repeats the first corner of the edge. Displacements are linear along a straight edge.
struct TetMesh {
    Points vertices; ///< n x 3, mm
    int nodes_per_tet = 4; ///< 4 (P1) or 10 (P2)
    std::vector<VertexId> nodes; ///< nodes_per_tet per element
    std::vector<Label> labels; ///< one per element

    std::size_t tet_count() const { return labels.size(); }
    std::size_t vertex_count() const { return static_cast<std::size_t>(vertices.rows()); }
    std::span<const VertexId> tet(TetId t) const
    {
        return { nodes.data() + static_cast<std::size_t>(t) * static_cast<std::size_t>(nodes_per_tet),
            static_cast<std::size_t>(nodes_per_tet) };
    }
};

/// Local corner indices of the face opposite corner f, counter-clockwise seen from outside.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces { { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } } };
/// Local corner indices of the six edges, in the order of the P2 midpoints.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges { { { 0, 1 }, { 1, 2 }, { 0, 2 }, { 0, 3 }, { 1, 3 },
    { 2, 3 } } };

/// Whether an edge of an element with ten entries has no midpoint.
inline bool is_straight(std::span<const VertexId> element, std::size_t edge)
{
    return element[4 + edge] == element[static_cast<std::size_t>(kTetEdges[edge][0])];
}

/// The corners of the face opposite a corner, counter-clockwise seen from outside. The corners of the element may be
/// ids or points.
template <class Corner> std::array<Corner, 3> face_corners(const std::array<Corner, 4>& element, int opposite)
{
    const auto& face = kTetFaces[static_cast<std::size_t>(opposite)];
    const auto at = [&](std::size_t i) -> const Corner& { return element[static_cast<std::size_t>(face[i])]; };
    return { at(0), at(1), at(2) };
}
/// The ends of the six edges, in the order of kTetEdges; the smaller id of each edge comes first.
std::array<std::pair<VertexId, VertexId>, 6> edge_keys(const std::array<VertexId, 4>& element);

/// The four corners of element t, in the node order above.
std::array<Vec3, 4> tet_corners(const TetMesh& mesh, TetId t);
/// Signed volume (mm^3) of the tetrahedron a, b, c, d; positive for the node order above.
double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// Signed volume (mm^3) of element t, by its four corners.
double tet_volume(const TetMesh& mesh, TetId t);
/// The six dihedral angles (degrees) of the tetrahedron a, b, c, d.
std::array<double, 6> dihedral_angles_deg(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// A face of an element, given by the element and the local corner opposite the face.
struct TetFace {
    TetId tet = 0;
    int corner = 0;
};

/// The three corners of a face, counter-clockwise seen from outside its element.
std::array<VertexId, 3> face_vertices(const TetMesh& mesh, const TetFace& face);

/// The triangles between the nodes of a face, counter-clockwise seen from outside: one, and one more for each midpoint.
std::vector<std::array<VertexId, 3>> face_triangles(const TetMesh& mesh, const TetFace& face);

/// A face of an element with its corners in ascending order.
struct FaceRecord {
    std::array<VertexId, 3> key;
    TetFace face;
};
/// All faces of all elements, sorted by their corners and then by element, so that equal faces stand side by side.
std::vector<FaceRecord> sorted_faces(const TetMesh& mesh);

/// Faces that belong to one element only. @throws InputError when a face belongs to more than two elements
std::vector<TetFace> boundary_faces(const TetMesh& mesh);

/// For each element the number of its piece; elements of a piece are connected by faces. Pieces are numbered from 0,
/// the largest first; of equal pieces, the piece with the first element comes first.
std::vector<int> connected_pieces(const TetMesh& mesh);

/// The elements with one of the labels, on all vertices of the mesh. `kept`, when not null, receives their ids.
TetMesh part_with_labels(const TetMesh& mesh, std::span<const Label> labels, std::vector<TetId>* kept = nullptr);

/// Refuses meshes that no later stage can use: indices out of range, NaN or infinite coordinates, wrong array lengths,
/// elements of zero or negative volume.
/// @throws InputError naming the element or vertex
void check_mesh(const TetMesh& mesh);

/// The quadratic mesh of a linear mesh: adds the edge midpoints; corners keep their ids.
/// @param elements one per element: 1 where all edges get midpoints; the other edges are straight. Empty: all edges get
/// midpoints.
/// @throws InputError when the elements are not four-node elements, or `elements` has another number of entries
TetMesh with_midpoints(const TetMesh& mesh, std::span<const std::uint8_t> elements = {});

/// Kuhn box: nx x ny x nz cubes of `spacing` mm, each divided into six tetrahedra, with a corner at the origin.
TetMesh kuhn_box(int nx, int ny, int nz, double spacing, Label label = 1);

} // namespace retractor::mesh
