#include "ui/cli/framework/ball_mesh.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

namespace retractor::ui::cli {

namespace {

    TriMesh icosahedron()
    {
        constexpr double kGolden = std::numbers::phi;
        TriMesh mesh;
        mesh.vertices.resize(12, 3);
        mesh.vertices << -1, kGolden, 0, 1, kGolden, 0, -1, -kGolden, 0, 1, -kGolden, 0, 0, -1, kGolden, 0, 1, kGolden,
            0, -1, -kGolden, 0, 1, -kGolden, kGolden, 0, -1, kGolden, 0, 1, -kGolden, 0, -1, -kGolden, 0, 1;
        mesh.vertices.rowwise().normalize();
        mesh.triangles = { { 0, 11, 5 }, { 0, 5, 1 }, { 0, 1, 7 }, { 0, 7, 10 }, { 0, 10, 11 }, { 1, 5, 9 },
            { 5, 11, 4 }, { 11, 10, 2 }, { 10, 7, 6 }, { 7, 1, 8 }, { 3, 9, 4 }, { 3, 4, 2 }, { 3, 2, 6 }, { 3, 6, 8 },
            { 3, 8, 9 }, { 4, 9, 5 }, { 2, 4, 11 }, { 6, 2, 10 }, { 8, 6, 7 }, { 9, 8, 1 } };
        return mesh;
    }

    TriMesh divided(const TriMesh& mesh)
    {
        TriMesh fine;
        std::vector<Vec3> vertices;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            vertices.push_back(mesh.vertices.row(v).transpose());
        std::map<std::pair<VertexId, VertexId>, VertexId> middle_of;
        const auto middle = [&](VertexId a, VertexId b) {
            const auto [at, added] = middle_of.try_emplace(std::minmax(a, b), static_cast<VertexId>(vertices.size()));
            if (added)
                vertices.push_back(
                    (vertices[static_cast<std::size_t>(a)] + vertices[static_cast<std::size_t>(b)]).normalized());
            return at->second;
        };
        for (const auto& [a, b, c] : mesh.triangles) {
            const VertexId ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            fine.triangles.insert(
                fine.triangles.end(), { { a, ab, ca }, { ab, b, bc }, { ca, bc, c }, { ab, bc, ca } });
        }
        fine.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
        for (std::size_t v = 0; v < vertices.size(); ++v)
            fine.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
        return fine;
    }

} // namespace

TriMesh ball_meshes(const Points& centres, double radius, int divisions)
{
    RETRACTOR_ASSERT(divisions >= 0);
    TriMesh unit = icosahedron();
    for (int i = 0; i < divisions; ++i)
        unit = divided(unit);
    TriMesh all;
    all.vertices.resize(centres.rows() * unit.vertices.rows(), 3);
    all.triangles.reserve(static_cast<std::size_t>(centres.rows()) * unit.triangles.size());
    for (Eigen::Index i = 0; i < centres.rows(); ++i) {
        const Eigen::Index first = i * unit.vertices.rows();
        all.vertices.middleRows(first, unit.vertices.rows()) = (radius * unit.vertices).rowwise() + centres.row(i);
        for (const auto& [a, b, c] : unit.triangles)
            all.triangles.push_back({ static_cast<VertexId>(first) + a, static_cast<VertexId>(first) + b,
                static_cast<VertexId>(first) + c });
    }
    return all;
}

TriMesh ball_mesh(const Vec3& centre, double radius, int divisions)
{
    return ball_meshes(centre.transpose(), radius, divisions);
}

} // namespace retractor::ui::cli
