#include "mesh/cutting/mesh_attributes.h"

#include "mesh/base/error.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace retractor::mesh {

namespace {

    template <class Value> void check_length(const std::vector<Value>& values, std::size_t count, const char* name)
    {
        if (!values.empty() && values.size() != count)
            throw InputError("has " + std::to_string(values.size()) + " values for " + std::to_string(count), name);
        for (std::size_t i = 0; i < values.size(); ++i)
            for (std::size_t k = 0; k < sizeof(Value) / sizeof(double); ++k)
                if (!std::isfinite(values[i][static_cast<int>(k)]))
                    throw InputError("is not finite", std::string(name) + "/" + std::to_string(i));
    }

    /// Barycentric coordinates of a point in an element.
    std::array<double, 4> weights_in(const TetMesh& mesh, TetId tet, const Vec3& point)
    {
        const std::array<Vec3, 4> p = tet_corners(mesh, tet);
        const double whole = tet_volume(p[0], p[1], p[2], p[3]);
        std::array<double, 4> weights {};
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<Vec3, 4> q = p;
            q[i] = point;
            weights[i] = tet_volume(q[0], q[1], q[2], q[3]) / whole;
        }
        return weights;
    }

    template <class Value>
    std::vector<Value> gathered(const std::vector<Value>& values, const std::vector<std::int32_t>& slots)
    {
        std::vector<Value> compact;
        if (values.empty())
            return compact;
        compact.reserve(slots.size());
        for (const std::int32_t slot : slots)
            compact.push_back(values[static_cast<std::size_t>(slot)]);
        return compact;
    }

} // namespace

MeshAttributes::MeshAttributes(TetMesh mesh, AttributeArrays values)
    : mesh_(std::move(mesh))
    , first_(std::move(values))
{
    check_mesh(mesh_);
    check_length(first_.fibre, mesh_.tet_count(), "fibre");
    check_length(first_.pre_strain, mesh_.tet_count(), "pre_strain");
    check_length(first_.texture, mesh_.vertex_count(), "texture");
    values_ = first_;
}

void MeshAttributes::resize(const CutSession& session)
{
    if (!first_.fibre.empty())
        values_.fibre.resize(session.tet_slots(), Vec3::Zero());
    if (!first_.pre_strain.empty())
        values_.pre_strain.resize(session.tet_slots(), {});
    if (!first_.texture.empty())
        values_.texture.resize(session.vertex_slots(), {});
}

void MeshAttributes::take_tet(const CutSession& session, TetId tet)
{
    const auto slot = static_cast<std::size_t>(tet);
    if (slot >= session.tet_slots())
        return;
    const bool alive = session.has_tet(tet);
    const std::size_t origin = alive ? static_cast<std::size_t>(session.origin(tet)) : 0;
    if (!first_.fibre.empty())
        values_.fibre[slot] = alive ? first_.fibre[origin] : Vec3(Vec3::Zero());
    if (!first_.pre_strain.empty())
        values_.pre_strain[slot] = alive ? first_.pre_strain[origin] : std::array<double, 6> {};
}

void MeshAttributes::take_vertex(const CutSession& session, VertexId vertex)
{
    const auto slot = static_cast<std::size_t>(vertex);
    if (first_.texture.empty() || slot >= session.vertex_slots())
        return;
    auto& value = values_.texture[slot];
    value = {};
    if (!session.has_vertex(vertex))
        return;
    const Vec3 p = session.position(vertex);
    if (slot < mesh_.vertex_count() && p == mesh_.vertices.row(vertex).transpose()) {
        value = first_.texture[slot];
        return;
    }
    std::vector<TetId> origins;
    for (const TetId t : session.tets_at(vertex))
        origins.push_back(session.origin(t));
    std::sort(origins.begin(), origins.end());
    origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
    double best = -std::numeric_limits<double>::infinity(); // the element that the point lies deepest in
    for (const TetId origin : origins) {
        const auto weights = weights_in(mesh_, origin, p);
        const double least = *std::min_element(weights.begin(), weights.end());
        if (least <= best)
            continue;
        best = least;
        value = {};
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t k = 0; k < 2; ++k)
                value[k] += weights[i] * first_.texture[static_cast<std::size_t>(mesh_.tet(origin)[i])][k];
    }
}

void MeshAttributes::follow(const MeshDelta& delta, const CutSession& session)
{
    resize(session);
    std::vector<VertexId> vertices;
    for (const auto* tets : { &delta.tets_gone, &delta.tets_born })
        for (const MeshDelta::Tet& tet : *tets) {
            take_tet(session, tet.id);
            vertices.insert(vertices.end(), tet.nodes.begin(), tet.nodes.end());
        }
    for (const auto& moved : delta.vertices_moved)
        vertices.push_back(moved.id);
    for (const auto* list : { &delta.vertices_born, &delta.vertices_gone })
        for (const auto& vertex : *list)
            vertices.push_back(vertex.id);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const VertexId v : vertices)
        take_vertex(session, v);
}

void MeshAttributes::take(const CutSession& session)
{
    resize(session);
    for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t)
        take_tet(session, t);
    for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
        take_vertex(session, v);
}

AttributeArrays MeshAttributes::compact(const SlotMap& map) const
{
    return { gathered(values_.fibre, map.tet_slot), gathered(values_.pre_strain, map.tet_slot),
        gathered(values_.texture, map.vertex_slot) };
}

} // namespace retractor::mesh
