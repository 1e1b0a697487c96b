#pragma once
// Finds the vertices of a cut body at which two parts of its surface touch in a point: for example, the tip of a wound
// reaches another wound or the skin. At these vertices alone the surface is no manifold.

#include "mesh/cutting/cut_session.h"

#include <cstddef>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace retractor::test_support {

/// Number of fans of surface faces that meet at a vertex: 0 inside, 1 on a manifold surface.
inline std::size_t surface_fans(const mesh::CutSession& session, VertexId v)
{
    std::map<std::pair<VertexId, VertexId>, int> faces; // by the edge opposite v
    for (const TetId t : session.tets_at(v))
        for (const auto& edge : mesh::edge_keys(session.tet(t).nodes))
            if (edge.first != v && edge.second != v)
                ++faces[edge];
    std::map<VertexId, std::vector<VertexId>> next;
    for (const auto& [edge, count] : faces)
        if (count == 1) {
            next[edge.first].push_back(edge.second);
            next[edge.second].push_back(edge.first);
        }
    std::size_t fans = 0;
    while (!next.empty()) {
        ++fans;
        std::vector<VertexId> open { next.begin()->first };
        while (!open.empty()) {
            const auto node = next.extract(open.back());
            open.pop_back();
            if (!node.empty())
                open.insert(open.end(), node.mapped().begin(), node.mapped().end());
        }
    }
    return fans;
}

/// The vertices at which two parts of the surface touch, ascending.
inline std::vector<VertexId> pinched_vertices(const mesh::CutSession& session)
{
    std::set<VertexId> vertices;
    for (const mesh::LipFace& lip : session.lips())
        for (const VertexId v : mesh::face_corners(session.tet(lip.face.tet).nodes, lip.face.corner))
            vertices.insert(v);
    std::erase_if(vertices, [&](VertexId v) { return surface_fans(session, v) <= 1; });
    return { vertices.begin(), vertices.end() };
}

} // namespace retractor::test_support
