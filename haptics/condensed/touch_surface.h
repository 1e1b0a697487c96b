#pragma once
// The surface of a body that fingers touch, prepared for a servo: a grid to find near vertices, and the contact nodes
// that carry contact forces. Units mm.
//
// A contact node is a patch of surface about one vertex, with a fixed spacing between contact nodes. Where the mesh is
// finer than the spacing, several vertices share a contact node, so that the contact has a limit under refinement (a
// force on a single vertex has none). Where the mesh is coarser, every vertex is a contact node. A force on a contact
// node is spread over its mesh nodes by `weights`, and the displacement of a contact node is the mean of its mesh nodes
// by the same weights. In P1 meshes a weight is the area round the vertex. In P2 meshes a weight is the integral of the
// shape function over the patch, because a force on single nodes of a P2 mesh would act differently on corners and
// midpoints.

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::haptics {

/// Compressed lists of indices, one list per item.
struct NumberLists {
    std::vector<std::int32_t> start { 0 }; ///< item count + 1 offsets into `entry`
    std::vector<std::int32_t> entry;

    std::size_t count() const { return start.size() - 1; }
    std::span<const std::int32_t> of(std::size_t item) const noexcept
    {
        return { entry.data() + start[item], static_cast<std::size_t>(start[item + 1] - start[item]) };
    }
};

struct ContactNode {
    std::int32_t vertex = 0; ///< index in the touch surface
    Vec3 point = Vec3::Zero(); ///< at rest, mm
    Vec3 normal = Vec3::Zero(); ///< outward unit normal
};

/// Boundary faces of a mesh: faces under blood pressure (`inner`) and touchable faces (`outer`).
struct WallFaces {
    std::vector<mesh::TetFace> inner, outer;
};
/// Sorts the boundary faces of a mesh. A face with a corner on the inner wall is inner. A face with only fixed corners
/// is in neither list.
/// @param inner_wall,fixed one per node
WallFaces wall_faces(
    const mesh::TetMesh& mesh, std::span<const std::uint8_t> inner_wall, std::span<const std::uint8_t> fixed);

class TouchSurface {
public:
    /// @param outer faces that can be touched
    /// @param fixed one per node of the mesh
    /// @param spacing distance between contact nodes, mm
    /// @throws InputError when there is nothing to touch
    TouchSurface(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer,
        const std::vector<std::uint8_t>& fixed, double spacing);

    // Vertices are corners, and midpoints where the elements have midpoints.
    std::size_t vertex_count() const { return nodes_.size(); }
    const std::vector<VertexId>& nodes() const { return nodes_; } ///< node of the mesh for each vertex
    const Points& rest() const { return rest_; }
    const Points& normals() const { return normals_; }
    const NumberLists& neighbours() const { return neighbours_; } ///< neighbouring vertices of each vertex
    const NumberLists& triangles_round() const { return triangles_round_; } ///< triangles round each vertex
    const std::vector<std::array<std::int32_t, 3>>& triangles() const { return triangles_; }

    const std::vector<ContactNode>& contact_nodes() const { return contact_nodes_; }
    /// Contact node whose patch contains this vertex; -1: none, because the vertex is fixed.
    std::int32_t contact_node_of(std::int32_t vertex) const noexcept
    {
        return contact_node_of_vertex_[static_cast<std::size_t>(vertex)];
    }
    const NumberLists& contact_node_neighbours() const { return contact_node_neighbours_; }
    /// Mesh nodes of each contact node. Their `weights` sum to 1, less the share of fixed nodes.
    const NumberLists& contact_node_vertices() const { return contact_node_vertices_; }
    /// Share of a force for each entry of contact_node_vertices().
    const std::vector<double>& weights() const { return weights_; }
    double spacing() const { return spacing_; }

    /// A vertex near a point, as the start of a walk. -1: the point is farther than kReach from the box of the surface.
    std::int32_t near(const Vec3& point) const noexcept;
    static constexpr double kReach = 16.0; ///< mm

    std::size_t bytes() const;

private:
    void take_faces(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer);
    void measure_normals();
    void place_contact_nodes(const std::vector<std::uint8_t>& fixed);
    void weigh_contact_nodes(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer);
    void fill_grid();

    double spacing_ = 0.0;
    std::vector<VertexId> nodes_;
    std::vector<std::int32_t> vertex_of_node_;
    Points rest_, normals_;
    std::vector<std::array<std::int32_t, 3>> triangles_;
    NumberLists neighbours_, triangles_round_;
    std::vector<ContactNode> contact_nodes_;
    std::vector<std::int32_t> contact_node_of_vertex_;
    NumberLists contact_node_neighbours_, contact_node_vertices_;
    std::vector<double> weights_;

    Vec3 grid_low_ = Vec3::Zero();
    double cell_ = 1.0; ///< mm
    std::array<int, 3> cells_ { 0, 0, 0 };
    std::vector<std::int32_t> nearest_; ///< per cell: a vertex near its middle
};

} // namespace retractor::haptics
