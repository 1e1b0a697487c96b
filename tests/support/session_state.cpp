#include "tests/support/session_state.h"

#include <cmath>

namespace retractor::test_support {

SessionState::SessionState(const mesh::CutSession& session)
    : mesh(session.compact_mesh(&map))
    , lips(session.lips())
    , cuts(session.cut_count())
    , redo(session.can_redo())
    , stroke(session.stroke_open())
{
    for (const TetId t : map.tet_slot)
        origins.push_back(session.origin(t));
}

bool SessionState::operator==(const SessionState& other) const
{
    const auto same_lip = [](const mesh::LipFace& a, const mesh::LipFace& b) {
        return a.face.tet == b.face.tet && a.face.corner == b.face.corner && a.side == b.side && a.cut == b.cut;
    };
    return mesh.vertices.rows() == other.mesh.vertices.rows()
        && (mesh.vertices.array() == other.mesh.vertices.array()).all() && mesh.nodes == other.mesh.nodes
        && mesh.labels == other.mesh.labels && origins == other.origins && map.vertex_slot == other.map.vertex_slot
        && map.tet_slot == other.map.tet_slot && map.compact_vertex == other.map.compact_vertex
        && map.compact_tet == other.map.compact_tet
        && std::equal(lips.begin(), lips.end(), other.lips.begin(), other.lips.end(), same_lip) && cuts == other.cuts
        && redo == other.redo && stroke == other.stroke;
}

mesh::TetMesh three_layers(int nx, int ny, int nz, double spacing)
{
    mesh::TetMesh box = mesh::kuhn_box(nx, ny, nz, spacing);
    for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
        double height = 0.0;
        for (const VertexId v : box.tet(t))
            height += 0.25 * box.vertices(v, 2) / (nz * spacing);
        box.labels[static_cast<std::size_t>(t)] = static_cast<Label>(1 + static_cast<int>(3.0 * height));
    }
    return box;
}

mesh::Blade random_stroke(std::mt19937& random, const Vec3& extent)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0), lean(-0.5, 0.5);
    const auto on_top = [&] {
        return Vec3((1.2 * unit(random) - 0.1) * extent.x(), (1.2 * unit(random) - 0.1) * extent.y(), extent.z());
    };
    const Vec3 a = on_top(), b = on_top();
    mesh::Blade blade;
    const int points = 2 + static_cast<int>(3.0 * unit(random));
    const Vec3 bow = Vec3(lean(random), lean(random), 0.0) * 0.3 * (b - a).norm();
    for (int i = 0; i < points; ++i) {
        const double s = static_cast<double>(i) / (points - 1);
        blade.line.push_back(a + s * (b - a) + 4.0 * s * (1.0 - s) * bow);
    }
    blade.directions = { { lean(random), lean(random), -1.0 } };
    blade.depth_mm = (0.2 + unit(random)) * extent.z();
    return blade;
}

std::vector<TetId> random_marks(
    std::mt19937& random, const mesh::CutSession& session, const Vec3& extent, double radius)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const Vec3 centre(unit(random) * extent.x(), unit(random) * extent.y(), unit(random) * extent.z());
    std::vector<TetId> marked;
    for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t) {
        if (!session.has_tet(t))
            continue;
        Vec3 centroid = Vec3::Zero();
        for (const VertexId v : session.tet(t).nodes)
            centroid += 0.25 * session.position(v);
        if ((centroid - centre).norm() < radius)
            marked.push_back(t);
    }
    return marked;
}

} // namespace retractor::test_support
