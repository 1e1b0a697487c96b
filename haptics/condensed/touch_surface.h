#pragma once
// The surface of a body that fingers touch, made ready for a servo: where it is nearest, and the stations that carry
// contact. Units mm.
//
// A station is a patch of surface about one vertex, with a fixed spacing between stations: where the mesh is finer,
// several vertices share a station, so that contact has a limit under refinement (a force on a single vertex has none);
// where it is coarser every vertex is a station. A force on a station is spread over its nodes by `weights`, and its
// displacement is the mean of theirs by the same weights: P1 meshes by the area round each vertex, P2 meshes by the
// integral of each shape function over the patch (a force on single nodes of a P2 mesh would feel corners and midpoints
// apart).

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::haptics {

/// Lists of numbers, one per item, compressed.
struct NumberLists {
    std::vector<std::int32_t> start { 0 }; ///< item count + 1
    std::vector<std::int32_t> entry;

    std::size_t count() const { return start.size() - 1; }
    std::span<const std::int32_t> of(std::size_t item) const noexcept
    {
        return { entry.data() + start[item], static_cast<std::size_t>(start[item + 1] - start[item]) };
    }
};

struct ContactNode {
    std::int32_t vertex = 0; ///< of the touch surface
    Vec3 point = Vec3::Zero(); ///< at rest
    Vec3 normal = Vec3::Zero(); ///< outward
};

/// Boundary faces of a mesh: those blood presses on, and all others.
struct WallFaces {
    std::vector<mesh::TetFace> inner, outer;
};
/// @param inner_wall, fixed one per node. A face with a corner on the inner wall is one; a face whose corners are all
/// fixed is in neither list.
WallFaces wall_faces(
    const mesh::TetMesh& mesh, std::span<const std::uint8_t> inner_wall, std::span<const std::uint8_t> fixed);

class TouchSurface {
public:
    /// @param outer the faces that can be touched. @param fixed one per node of the mesh.
    /// @param spacing between stations, mm. @throws InputError when there is nothing to touch.
    TouchSurface(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer,
        const std::vector<std::uint8_t>& fixed, double spacing);

    // Vertices: corners, and midpoints where elements have them.
    std::size_t vertex_count() const { return nodes_.size(); }
    const std::vector<VertexId>& nodes() const { return nodes_; } ///< of the mesh, per vertex
    const Points& rest() const { return rest_; }
    const Points& normals() const { return normals_; }
    const NumberLists& neighbours() const { return neighbours_; } ///< vertices of each vertex
    const NumberLists& triangles_round() const { return triangles_round_; } ///< of each vertex
    const std::vector<std::array<std::int32_t, 3>>& triangles() const { return triangles_; }

    const std::vector<ContactNode>& contact_nodes() const { return contact_nodes_; }
    /// The station whose patch this vertex belongs to; -1: none (fixed).
    std::int32_t contact_node_of(std::int32_t vertex) const noexcept
    {
        return contact_node_of_vertex_[static_cast<std::size_t>(vertex)];
    }
    const NumberLists& contact_node_neighbours() const { return contact_node_neighbours_; }
    /// Nodes of a station and how much of a force each takes; the weights sum to 1 but for fixed nodes' share.
    const NumberLists& contact_node_vertices() const { return contact_node_vertices_; }
    const std::vector<double>& weights() const { return weights_; } ///< per entry of contact_node_vertices()
    double spacing() const { return spacing_; }

    /// A vertex near a point, as a start for a walk; -1: the point is farther than kReach from the surface's box.
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
