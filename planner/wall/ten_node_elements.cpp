#include "planner/wall/ten_node_elements.h"

#include "fem/statics/nonlinear_region.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    using Flags = std::vector<std::uint8_t>;

    /// Marks the vertices of the front of the cut, where the two lips meet.
    Flags vertices_of_cut_front(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips)
    {
        std::array<Flags, 2> on_lip;
        on_lip.fill(Flags(wall.vertex_count(), 0));
        for (const mesh::LipFace& lip : lips)
            if (lip.side != 0)
                for (const VertexId v : mesh::face_vertices(wall, lip.face))
                    on_lip[lip.side > 0 ? 1 : 0][static_cast<std::size_t>(v)] = 1;
        Flags front(wall.vertex_count(), 0);
        std::ranges::transform(on_lip[0], on_lip[1], front.begin(), std::bit_and<>());
        return front;
    }

    /// Marks the elements that have a marked vertex.
    Flags elements_touching(const mesh::TetMesh& mesh, const Flags& vertices)
    {
        Flags marked(mesh.tet_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const VertexId v : mesh.tet(t))
                marked[static_cast<std::size_t>(t)] |= vertices[static_cast<std::size_t>(v)];
        return marked;
    }

    /// Marks the vertices of marked elements.
    Flags vertices_of(const mesh::TetMesh& mesh, const Flags& elements)
    {
        Flags marked(mesh.vertex_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (elements[static_cast<std::size_t>(t)] != 0)
                for (const VertexId v : mesh.tet(t))
                    marked[static_cast<std::size_t>(v)] = 1;
        return marked;
    }

    /// The volume of an element over that of the regular tetrahedron with the same mean square edge.
    double ratio_to_regular(const mesh::TetMesh& mesh, TetId t)
    {
        const std::array<Vec3, 4> corners = mesh::tet_corners(mesh, t);
        double square = 0.0;
        for (const auto& [a, b] : mesh::kTetEdges)
            square += (corners[static_cast<std::size_t>(a)] - corners[static_cast<std::size_t>(b)]).squaredNorm();
        square /= static_cast<double>(mesh::kTetEdges.size());
        return 6.0 * std::numbers::sqrt2 * mesh::tet_volume(mesh, t) / std::pow(square, 1.5);
    }

    /// Clears the marks of soft elements that touch a lip or are flat, and of soft elements that share an edge with one
    /// of these: their edges stay straight, but for the edges of bone.
    /// @param on_lips one flag per vertex
    /// @param marked one flag per element
    void clear_at_lips(const mesh::TetMesh& mesh, const Flags& bone, const Flags& on_lips, Flags& marked)
    {
        constexpr double kFlat = 0.15; // ratio_to_regular(): fewer than one soft element in fifty at a chest's lips
        const auto edges = [&](TetId t) {
            const auto corners = mesh.tet(t);
            return mesh::edge_keys({ corners[0], corners[1], corners[2], corners[3] });
        };
        const Flags touching = elements_touching(mesh, on_lips);
        std::set<std::pair<VertexId, VertexId>> straight;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (const auto i = static_cast<std::size_t>(t);
                bone[i] == 0 && (touching[i] != 0 || ratio_to_regular(mesh, t) < kFlat))
                for (const auto& edge : edges(t))
                    straight.insert(edge);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (const auto i = static_cast<std::size_t>(t); marked[i] != 0 && bone[i] == 0
                && std::ranges::any_of(edges(t), [&](const auto& edge) { return straight.contains(edge); }))
                marked[i] = 0;
    }

} // namespace

Points lip_points(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips)
{
    std::set<VertexId> vertices;
    for (const mesh::LipFace& lip : lips)
        for (const VertexId v : mesh::face_vertices(wall, lip.face))
            vertices.insert(v);
    return wall.vertices(std::vector<VertexId>(vertices.begin(), vertices.end()), Eigen::all);
}

std::vector<std::uint8_t> ten_node_elements(
    const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips, const mesh::LabelTable& table, SoftLips soft_lips)
{
    const mesh::LabelFlags is_bone = mesh::flagged_labels(table, mesh::is_skeleton);
    Flags bone(wall.tet_count(), 0);
    std::ranges::transform(wall.labels, bone.begin(), [&](Label label) { return is_bone[label]; });
    if (std::ranges::none_of(bone, [](std::uint8_t flag) { return flag != 0; }))
        return Flags(wall.tet_count(), 1);
    Flags on_lips(wall.vertex_count(), 0);
    for (const mesh::LipFace& lip : lips)
        for (const VertexId v : mesh::face_vertices(wall, lip.face))
            on_lips[static_cast<std::size_t>(v)] = 1;
    Flags touched = vertices_of(wall, bone);
    std::ranges::transform(touched, on_lips, touched.begin(), std::bit_or<>());
    Flags marked = elements_touching(wall, touched);
    const Flags around = elements_touching(wall, vertices_of_cut_front(wall, lips));
    for (std::size_t t = 0; t < marked.size(); ++t)
        if (around[t] != 0 && bone[t] == 0)
            marked[t] = 0;
    if (soft_lips == SoftLips::four_nodes)
        clear_at_lips(wall, bone, on_lips, marked);
    if (lips.empty())
        return marked;
    const Flags near = fem::elements_near(wall, lip_points(wall, lips), kTenNodesWithinMm);
    std::ranges::transform(marked, near, marked.begin(), std::bit_and<>());
    return marked;
}

} // namespace retractor::planner
