#include "mesh/tetrahedra/tet_mesh.h"

#include "mesh/base/assert.h"
#include "mesh/base/disjoint_sets.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

namespace retractor::mesh {

namespace {

    [[maybe_unused]] bool has_nodes(const TetMesh& mesh, TetId t)
    {
        return t >= 0
            && static_cast<std::size_t>(mesh.nodes_per_tet) * (static_cast<std::size_t>(t) + 1) <= mesh.nodes.size();
    }

    std::size_t run_length(const std::vector<FaceRecord>& faces, std::size_t begin)
    {
        std::size_t end = begin + 1;
        while (end < faces.size() && faces[end].key == faces[begin].key)
            ++end;
        return end - begin;
    }

} // namespace

std::array<std::pair<VertexId, VertexId>, 6> edge_keys(const std::array<VertexId, 4>& element)
{
    std::array<std::pair<VertexId, VertexId>, 6> keys;
    for (std::size_t e = 0; e < 6; ++e)
        keys[e] = std::minmax(
            element[static_cast<std::size_t>(kTetEdges[e][0])], element[static_cast<std::size_t>(kTetEdges[e][1])]);
    return keys;
}

std::array<Vec3, 4> tet_corners(const TetMesh& mesh, TetId t)
{
    RETRACTOR_ASSERT(has_nodes(mesh, t));
    const auto n = mesh.tet(t);
    return { point_at(mesh.vertices, n[0]), point_at(mesh.vertices, n[1]), point_at(mesh.vertices, n[2]),
        point_at(mesh.vertices, n[3]) };
}

double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    return (b - a).dot((c - a).cross(d - a)) / 6.0;
}

double tet_volume(const TetMesh& mesh, TetId t)
{
    const auto [a, b, c, d] = tet_corners(mesh, t);
    return tet_volume(a, b, c, d);
}

std::array<double, 6> dihedral_angles_deg(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    const std::array<Vec3, 4> p { a, b, c, d };
    const std::array<Vec3, 4> normal { unit_normal(face_corners(p, 0)), unit_normal(face_corners(p, 1)),
        unit_normal(face_corners(p, 2)), unit_normal(face_corners(p, 3)) };
    std::array<double, 6> angles {};
    for (std::size_t e = 0; e < 6; ++e) {
        // The two faces at an edge are opposite the two corners that are not on the edge.
        std::array<std::size_t, 2> opposite {};
        std::size_t found = 0;
        for (int corner = 0; corner < 4; ++corner)
            if (corner != kTetEdges[e][0] && corner != kTetEdges[e][1])
                opposite[found++] = static_cast<std::size_t>(corner);
        const double cosine = std::clamp(-normal[opposite[0]].dot(normal[opposite[1]]), -1.0, 1.0);
        angles[e] = std::acos(cosine) * 180.0 / std::numbers::pi;
    }
    return angles;
}

std::array<VertexId, 3> face_vertices(const TetMesh& mesh, const TetFace& face)
{
    RETRACTOR_ASSERT(has_nodes(mesh, face.tet) && face.corner >= 0 && face.corner < 4);
    const auto n = mesh.tet(face.tet);
    const auto& local = kTetFaces[static_cast<std::size_t>(face.corner)];
    return { n[static_cast<std::size_t>(local[0])], n[static_cast<std::size_t>(local[1])],
        n[static_cast<std::size_t>(local[2])] };
}

std::vector<std::array<VertexId, 3>> face_triangles(const TetMesh& mesh, const TetFace& face)
{
    const auto corner = face_vertices(mesh, face);
    const auto& local = kTetFaces[static_cast<std::size_t>(face.corner)];
    const auto nodes = mesh.tet(face.tet);
    constexpr VertexId kStraight = -1;
    std::array<VertexId, 3> middle { kStraight, kStraight, kStraight }; // behind each corner
    for (std::size_t i = 0; mesh.nodes_per_tet == 10 && i < 3; ++i)
        for (std::size_t e = 0; e < kTetEdges.size(); ++e)
            if (std::minmax(local[i], local[(i + 1) % 3]) == std::minmax(kTetEdges[e][0], kTetEdges[e][1])
                && !is_straight(nodes, e))
                middle[i] = nodes[4 + e];
    const auto straight = std::ranges::count(middle, kStraight);
    if (straight == 3)
        return { corner };
    if (straight == 0)
        return { { corner[0], middle[0], middle[2] }, { middle[0], corner[1], middle[1] },
            { middle[2], middle[1], corner[2] }, { middle[0], middle[1], middle[2] } };
    // From the edge that differs from the two others.
    const bool differs_by_middle = straight == 2;
    std::size_t i = 0;
    while ((middle[i] != kStraight) != differs_by_middle)
        ++i;
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    if (differs_by_middle)
        return { { corner[i], middle[i], corner[k] }, { middle[i], corner[j], corner[k] } };
    return { { middle[j], corner[k], middle[k] }, { corner[i], corner[j], middle[j] },
        { corner[i], middle[j], middle[k] } };
}

std::vector<FaceRecord> sorted_faces(const TetMesh& mesh)
{
    RETRACTOR_ASSERT(mesh.nodes.size() == mesh.tet_count() * static_cast<std::size_t>(mesh.nodes_per_tet));
    std::vector<FaceRecord> faces;
    faces.reserve(mesh.tet_count() * 4);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        for (int corner = 0; corner < 4; ++corner) {
            const TetFace face { t, corner };
            std::array<VertexId, 3> key = face_vertices(mesh, face);
            std::sort(key.begin(), key.end());
            faces.push_back({ key, face });
        }
    std::sort(faces.begin(), faces.end(), [](const FaceRecord& a, const FaceRecord& b) {
        return a.key != b.key ? a.key < b.key : a.face.tet < b.face.tet;
    });
    return faces;
}

std::vector<TetFace> boundary_faces(const TetMesh& mesh)
{
    const std::vector<FaceRecord> faces = sorted_faces(mesh);
    std::vector<TetFace> boundary;
    for (std::size_t i = 0; i < faces.size();) {
        const std::size_t count = run_length(faces, i);
        if (count > 2)
            throw InputError("a face is shared by " + std::to_string(count) + " elements",
                "element " + std::to_string(faces[i].face.tet));
        if (count == 1)
            boundary.push_back(faces[i].face);
        i += count;
    }
    std::sort(boundary.begin(), boundary.end(),
        [](const TetFace& a, const TetFace& b) { return a.tet != b.tet ? a.tet < b.tet : a.corner < b.corner; });
    return boundary;
}

std::vector<int> connected_pieces(const TetMesh& mesh)
{
    DisjointSets sets(mesh.tet_count());
    const std::vector<FaceRecord> faces = sorted_faces(mesh);
    for (std::size_t i = 0; i < faces.size();) {
        const std::size_t count = run_length(faces, i);
        for (std::size_t j = 1; j < count; ++j)
            sets.join(static_cast<std::size_t>(faces[i].face.tet), static_cast<std::size_t>(faces[i + j].face.tet));
        i += count;
    }
    const std::vector<std::size_t> roots = sets.roots();
    std::vector<std::size_t> size(roots.size(), 0),
        order; // elements of each piece; roots of the pieces, the largest piece first
    for (const std::size_t root : roots)
        if (size[root]++ == 0)
            order.push_back(root);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
    std::vector<int> number(roots.size()), piece(roots.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        number[order[i]] = static_cast<int>(i);
    for (std::size_t t = 0; t < roots.size(); ++t)
        piece[t] = number[roots[t]];
    return piece;
}

TetMesh part_with_labels(const TetMesh& mesh, std::span<const Label> labels, std::vector<TetId>* kept)
{
    TetMesh part { mesh.vertices, mesh.nodes_per_tet, {}, {} };
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (const Label label = mesh.labels[static_cast<std::size_t>(t)];
            std::find(labels.begin(), labels.end(), label) != labels.end()) {
            const auto nodes = mesh.tet(t);
            part.nodes.insert(part.nodes.end(), nodes.begin(), nodes.end());
            part.labels.push_back(label);
            if (kept != nullptr)
                kept->push_back(t);
        }
    return part;
}

void check_mesh(const TetMesh& mesh)
{
    if (mesh.nodes_per_tet != 4 && mesh.nodes_per_tet != 10)
        throw InputError("a tetrahedron has 4 or 10 nodes, not " + std::to_string(mesh.nodes_per_tet));
    if (mesh.nodes.size() != mesh.tet_count() * static_cast<std::size_t>(mesh.nodes_per_tet))
        throw InputError("the node list does not match the number of elements");
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        if (!mesh.vertices.row(v).allFinite())
            throw InputError("a coordinate is not finite", "vertex " + std::to_string(v));
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
        if (mesh.nodes[i] < 0 || mesh.nodes[i] >= mesh.vertices.rows())
            throw InputError("node index " + std::to_string(mesh.nodes[i]) + " is out of range",
                "element " + std::to_string(i / static_cast<std::size_t>(mesh.nodes_per_tet)));
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const double volume = tet_volume(mesh, t);
        if (!(volume > 0.0))
            throw InputError(
                "volume " + std::to_string(volume) + " mm^3 is not positive", "element " + std::to_string(t));
    }
}

TetMesh with_midpoints(const TetMesh& mesh, std::span<const std::uint8_t> elements)
{
    if (mesh.nodes_per_tet != 4)
        throw InputError("midpoints can be added to four-node elements only");
    if (!elements.empty() && elements.size() != mesh.tet_count())
        throw InputError("midpoints are chosen for each element, or for none", "elements");
    TetMesh quadratic;
    quadratic.nodes_per_tet = 10;
    quadratic.labels = mesh.labels;
    quadratic.nodes.reserve(mesh.tet_count() * 10);
    std::map<std::pair<VertexId, VertexId>, VertexId> midpoint;
    std::vector<Vec3> added;
    const auto ends_of = [&](TetId t, const std::array<int, 2>& edge) {
        const auto n = mesh.tet(t);
        return std::pair { n[static_cast<std::size_t>(edge[0])], n[static_cast<std::size_t>(edge[1])] };
    };
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (elements.empty() || elements[static_cast<std::size_t>(t)] != 0)
            for (const auto& edge : kTetEdges) {
                const auto [a, b] = ends_of(t, edge);
                const auto next = static_cast<VertexId>(mesh.vertices.rows()) + static_cast<VertexId>(added.size());
                if (midpoint.try_emplace(std::minmax(a, b), next).second)
                    added.push_back(0.5 * (point_at(mesh.vertices, a) + point_at(mesh.vertices, b)));
            }
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto n = mesh.tet(t);
        quadratic.nodes.insert(quadratic.nodes.end(), n.begin(), n.end());
        for (const auto& edge : kTetEdges) {
            const auto [a, b] = ends_of(t, edge);
            const auto found = midpoint.find(std::minmax(a, b));
            quadratic.nodes.push_back(found == midpoint.end() ? a : found->second);
        }
    }
    quadratic.vertices.resize(mesh.vertices.rows() + static_cast<Eigen::Index>(added.size()), 3);
    quadratic.vertices.topRows(mesh.vertices.rows()) = mesh.vertices;
    for (std::size_t i = 0; i < added.size(); ++i)
        quadratic.vertices.row(mesh.vertices.rows() + static_cast<Eigen::Index>(i)) = added[i].transpose();
    return quadratic;
}

TetMesh kuhn_box(int nx, int ny, int nz, double spacing, Label label)
{
    if (nx <= 0 || ny <= 0 || nz <= 0 || !(spacing > 0.0))
        throw InputError("a box needs positive cell counts and spacing");
    TetMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(nx + 1) * (ny + 1) * (nz + 1), 3);
    const auto id = [&](int i, int j, int k) { return static_cast<VertexId>((k * (ny + 1) + j) * (nx + 1) + i); };
    for (int k = 0; k <= nz; ++k)
        for (int j = 0; j <= ny; ++j)
            for (int i = 0; i <= nx; ++i)
                mesh.vertices.row(id(i, j, k)) << i * spacing, j * spacing, k * spacing;
    // Each path from corner 000 to corner 111 along the axes is a tetrahedron; odd permutations are flipped.
    constexpr std::array<std::array<int, 3>, 6> kPaths { { { 0, 1, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 0, 2, 1 },
        { 2, 1, 0 }, { 1, 0, 2 } } };
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                for (std::size_t path = 0; path < kPaths.size(); ++path) {
                    std::array<int, 3> at { i, j, k };
                    std::array<VertexId, 4> tet { id(i, j, k), 0, 0, 0 };
                    for (std::size_t step = 0; step < 3; ++step) {
                        ++at[static_cast<std::size_t>(kPaths[path][step])];
                        tet[step + 1] = id(at[0], at[1], at[2]);
                    }
                    if (path >= 3)
                        std::swap(tet[2], tet[3]);
                    mesh.nodes.insert(mesh.nodes.end(), tet.begin(), tet.end());
                    mesh.labels.push_back(label);
                }
    return mesh;
}

} // namespace retractor::mesh
