#include "haptics/condensed/touch_surface.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace retractor::haptics {

namespace {

    Vec3 at(const Points& points, std::int32_t v) { return points.row(v).transpose(); }

    /// Nodes of a face: three corners, then the midpoints of edges 01, 12, 20 if the mesh has midpoints.
    std::vector<VertexId> face_nodes(const mesh::TetMesh& mesh, const mesh::TetFace& face)
    {
        const auto corners = mesh::face_vertices(mesh, face);
        std::vector<VertexId> nodes(corners.begin(), corners.end());
        const auto tet = mesh.tet(face.tet);
        for (std::size_t i = 0; i < 3 && mesh.nodes_per_tet == 10; ++i)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                const VertexId a = tet[static_cast<std::size_t>(mesh::kTetEdges[e][0])],
                               b = tet[static_cast<std::size_t>(mesh::kTetEdges[e][1])];
                if (std::minmax(a, b) == std::minmax(corners[i], corners[(i + 1) % 3]))
                    nodes.push_back(tet[4 + e]);
            }
        return nodes;
    }

    using SubTriangle = std::array<std::size_t, 3>;
    std::vector<SubTriangle> sub_triangles(std::size_t face_node_count)
    {
        if (face_node_count == 3)
            return { { 0, 1, 2 } };
        return { { 0, 3, 5 }, { 3, 1, 4 }, { 5, 4, 2 }, { 3, 4, 5 } };
    }

    NumberLists compress(std::vector<std::pair<std::int32_t, std::int32_t>> pairs, std::size_t items)
    {
        std::sort(pairs.begin(), pairs.end());
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
        NumberLists lists;
        lists.start.assign(items + 1, 0);
        for (const auto& [item, entry] : pairs) {
            ++lists.start[static_cast<std::size_t>(item) + 1];
            lists.entry.push_back(entry);
        }
        for (std::size_t i = 0; i < items; ++i)
            lists.start[i + 1] += lists.start[i];
        return lists;
    }

    /// Spatial hash of points by cubes.
    class Cubes {
    public:
        explicit Cubes(double size)
            : size_(size)
        {
        }
        void add(const Vec3& p, std::int32_t id) { cubes_[key(p)].push_back(id); }
        template <class F> void for_each_near(const Vec3& p, const F& f) const
        {
            const Key k = key(p);
            for (int x = -1; x <= 1; ++x)
                for (int y = -1; y <= 1; ++y)
                    for (int z = -1; z <= 1; ++z)
                        if (const auto found = cubes_.find({ k[0] + x, k[1] + y, k[2] + z }); found != cubes_.end())
                            for (const std::int32_t id : found->second)
                                f(id);
        }

    private:
        using Key = std::array<int, 3>;
        Key key(const Vec3& p) const
        {
            return { static_cast<int>(std::floor(p.x() / size_)), static_cast<int>(std::floor(p.y() / size_)),
                static_cast<int>(std::floor(p.z() / size_)) };
        }
        double size_;
        std::map<Key, std::vector<std::int32_t>> cubes_;
    };

} // namespace

WallFaces wall_faces(
    const mesh::TetMesh& mesh, std::span<const std::uint8_t> inner_wall, std::span<const std::uint8_t> fixed)
{
    RETRACTOR_ASSERT(inner_wall.size() == mesh.vertex_count() && fixed.size() == mesh.vertex_count());
    WallFaces faces;
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
        bool inner = false, held = true;
        for (const VertexId v : mesh::face_vertices(mesh, face)) {
            inner = inner || inner_wall[static_cast<std::size_t>(v)] != 0;
            held = held && fixed[static_cast<std::size_t>(v)] != 0;
        }
        if (!held)
            (inner ? faces.inner : faces.outer).push_back(face);
    }
    return faces;
}

TouchSurface::TouchSurface(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer,
    const std::vector<std::uint8_t>& fixed, double spacing)
    : spacing_(spacing)
{
    if (!(spacing > 0.0 && std::isfinite(spacing)))
        throw InputError("the spacing of the contact nodes must be positive", "touch surface");
    RETRACTOR_ASSERT(fixed.size() == mesh.vertex_count());
    take_faces(mesh, outer);
    measure_normals();
    place_contact_nodes(fixed);
    if (contact_nodes_.empty())
        throw InputError("no part of the surface can be touched", "touch surface");
    weigh_contact_nodes(mesh, outer);
    RETRACTOR_ASSERT(contact_node_neighbours_.count() == contact_nodes_.size());
    RETRACTOR_ASSERT(contact_node_vertices_.count() == contact_nodes_.size());
    RETRACTOR_ASSERT(weights_.size() == contact_node_vertices_.entry.size());
    fill_grid();
}

void TouchSurface::take_faces(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer)
{
    vertex_of_node_.assign(mesh.vertex_count(), -1);
    for (const mesh::TetFace& face : outer)
        for (const VertexId v : face_nodes(mesh, face))
            vertex_of_node_[static_cast<std::size_t>(v)] = 0;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
        if (vertex_of_node_[v] == 0) {
            vertex_of_node_[v] = static_cast<std::int32_t>(nodes_.size());
            nodes_.push_back(static_cast<VertexId>(v));
        }
    rest_.resize(static_cast<Eigen::Index>(nodes_.size()), 3);
    for (std::size_t i = 0; i < nodes_.size(); ++i)
        rest_.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(nodes_[i]);
    std::vector<std::pair<std::int32_t, std::int32_t>> edges, rounds;
    for (const mesh::TetFace& face : outer) {
        const std::vector<VertexId> on_face = face_nodes(mesh, face);
        for (const SubTriangle& sub : sub_triangles(on_face.size())) {
            std::array<std::int32_t, 3> triangle {};
            for (std::size_t i = 0; i < 3; ++i)
                triangle[i] = vertex_of_node_[static_cast<std::size_t>(on_face[sub[i]])];
            for (std::size_t i = 0; i < 3; ++i) {
                edges.emplace_back(triangle[i], triangle[(i + 1) % 3]);
                edges.emplace_back(triangle[(i + 1) % 3], triangle[i]);
                rounds.emplace_back(triangle[i], static_cast<std::int32_t>(triangles_.size()));
            }
            triangles_.push_back(triangle);
        }
    }
    neighbours_ = compress(std::move(edges), nodes_.size());
    triangles_round_ = compress(std::move(rounds), nodes_.size());
}

void TouchSurface::measure_normals()
{
    normals_ = Points::Zero(rest_.rows(), 3);
    for (const auto& t : triangles_) {
        const Vec3 twice_area = (at(rest_, t[1]) - at(rest_, t[0])).cross(at(rest_, t[2]) - at(rest_, t[0]));
        for (const std::int32_t v : t)
            normals_.row(v) += twice_area.transpose();
    }
    normals_.rowwise().normalize();
}

void TouchSurface::place_contact_nodes(const std::vector<std::uint8_t>& fixed)
{
    Cubes cubes(spacing_);
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(nodes_.size()); ++v) {
        if (fixed[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(v)])] != 0)
            continue;
        const Vec3 p = at(rest_, v);
        bool taken = false;
        cubes.for_each_near(p, [&](std::int32_t s) {
            taken = taken || (contact_nodes_[static_cast<std::size_t>(s)].point - p).norm() < spacing_;
        });
        if (taken)
            continue;
        cubes.add(p, static_cast<std::int32_t>(contact_nodes_.size()));
        contact_nodes_.push_back({ v, p, at(normals_, v) });
    }
    contact_node_of_vertex_.assign(nodes_.size(), -1);
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(nodes_.size()); ++v) {
        if (fixed[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(v)])] != 0)
            continue;
        double best = std::numeric_limits<double>::infinity();
        cubes.for_each_near(at(rest_, v), [&](std::int32_t s) {
            const double d = (contact_nodes_[static_cast<std::size_t>(s)].point - at(rest_, v)).squaredNorm();
            if (d < best) {
                best = d;
                contact_node_of_vertex_[static_cast<std::size_t>(v)] = s;
            }
        });
    }
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    for (const auto& t : triangles_)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t a = contact_node_of(t[i]), b = contact_node_of(t[(i + 1) % 3]);
            if (a >= 0 && b >= 0 && a != b) {
                pairs.emplace_back(a, b);
                pairs.emplace_back(b, a);
            }
        }
    contact_node_neighbours_ = compress(std::move(pairs), contact_nodes_.size());
}

void TouchSurface::weigh_contact_nodes(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& outer)
{
    std::map<std::pair<std::int32_t, std::int32_t>, double> weight; // by contact node and mesh node: mm^2
    const auto add = [&](std::int32_t vertex, VertexId node, double value) {
        if (const std::int32_t s = contact_node_of(vertex); s >= 0)
            weight[{ s, node }] += value;
    };
    // Six points, exact for degree 4 (Dunavant 1985); a hat function times a quadratic shape function has degree 3.
    constexpr double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011, wb = 0.109951743655322;
    for (const mesh::TetFace& face : outer) {
        const std::vector<VertexId> on_face = face_nodes(mesh, face);
        constexpr std::array<std::array<double, 3>, 6> kLocal { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 },
            { 0.5, 0.5, 0 }, { 0, 0.5, 0.5 }, { 0.5, 0, 0.5 } } };
        for (const SubTriangle& sub : sub_triangles(on_face.size())) {
            std::array<Vec3, 3> corner;
            std::array<std::int32_t, 3> vertex {};
            for (std::size_t i = 0; i < 3; ++i) {
                vertex[i] = vertex_of_node_[static_cast<std::size_t>(on_face[sub[i]])];
                corner[i] = at(rest_, vertex[i]);
            }
            const double area = 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
            if (on_face.size() == 3) {
                for (std::size_t i = 0; i < 3; ++i)
                    add(vertex[i], on_face[sub[i]], area / 3.0);
                continue;
            }
            for (const auto& [v, w] : { std::pair { a, wa }, std::pair { b, wb } })
                for (std::size_t k = 0; k < 3; ++k) {
                    std::array<double, 3> hat { v, v, v };
                    hat[k] = 1.0 - 2.0 * v;
                    std::array<double, 3> l {}; // barycentric coordinates in the whole face
                    for (std::size_t i = 0; i < 3; ++i)
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            l[axis] += hat[i] * kLocal[sub[i]][axis];
                    const std::array<double, 6> shape { l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1),
                        l[2] * (2 * l[2] - 1), 4 * l[0] * l[1], 4 * l[1] * l[2], 4 * l[2] * l[0] };
                    for (std::size_t i = 0; i < 3; ++i)
                        for (std::size_t n = 0; n < 6; ++n)
                            add(vertex[i], on_face[n], w * area * hat[i] * shape[n]);
                }
        }
    }
    std::vector<double> total(contact_nodes_.size(), 0.0);
    for (const auto& [key, value] : weight)
        total[static_cast<std::size_t>(key.first)] += value;
    contact_node_vertices_.start.assign(contact_nodes_.size() + 1, 0);
    for (const auto& [key, value] : weight) { // ordered by contact node
        ++contact_node_vertices_.start[static_cast<std::size_t>(key.first) + 1];
        contact_node_vertices_.entry.push_back(key.second);
        weights_.push_back(value / total[static_cast<std::size_t>(key.first)]);
    }
    for (std::size_t s = 0; s < contact_nodes_.size(); ++s)
        contact_node_vertices_.start[s + 1] += contact_node_vertices_.start[s];
}

void TouchSurface::fill_grid()
{
    const Vec3 low = rest_.colwise().minCoeff().transpose() - Vec3::Constant(kReach),
               high = rest_.colwise().maxCoeff().transpose() + Vec3::Constant(kReach);
    constexpr double kCells = 96.0, kFinest = 2.0; // cells along the longest side; smallest cell, mm
    cell_ = std::max(kFinest, (high - low).maxCoeff() / kCells);
    grid_low_ = low;
    for (std::size_t axis = 0; axis < 3; ++axis)
        cells_[axis] = static_cast<int>(std::ceil((high - low)[static_cast<Eigen::Index>(axis)] / cell_));
    const auto index = [&](int x, int y, int z) {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y))
            * static_cast<std::size_t>(cells_[0])
            + static_cast<std::size_t>(x);
    };
    nearest_.assign(index(0, 0, cells_[2]), -1);
    const auto middle
        = [&](int x, int y, int z) -> Vec3 { return grid_low_ + cell_ * Vec3(x + 0.5, y + 0.5, z + 0.5); };
    const auto offer = [&](int x, int y, int z, std::int32_t v) {
        std::int32_t& now = nearest_[index(x, y, z)];
        const Vec3 m = middle(x, y, z);
        if (v >= 0 && (now < 0 || (at(rest_, v) - m).squaredNorm() < (at(rest_, now) - m).squaredNorm()))
            now = v;
    };
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(nodes_.size()); ++v) {
        const Vec3 c = (at(rest_, v) - grid_low_) / cell_;
        offer(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()), v);
    }
    // Cells take over the vertices of their neighbours in two forward and two backward sweeps. The result is exact
    // enough to start a walk.
    for (int sweep = 0; sweep < 4; ++sweep) {
        const int step = sweep % 2 == 0 ? 1 : -1;
        const auto first = [&](std::size_t axis) { return step > 0 ? 0 : cells_[axis] - 1; };
        const auto inside = [&](int i, std::size_t axis) { return i >= 0 && i < cells_[axis]; };
        for (int z = first(2); inside(z, 2); z += step)
            for (int y = first(1); inside(y, 1); y += step)
                for (int x = first(0); inside(x, 0); x += step)
                    for (int dz = -1; dz <= 1; ++dz)
                        for (int dy = -1; dy <= 1; ++dy)
                            for (int dx = -1; dx <= 1; ++dx)
                                if (inside(x + dx, 0) && inside(y + dy, 1) && inside(z + dz, 2))
                                    offer(x, y, z, nearest_[index(x + dx, y + dy, z + dz)]);
    }
}

std::int32_t TouchSurface::near(const Vec3& point) const noexcept
{
    const Vec3 c = (point - grid_low_) / cell_;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        if (!(c[axis] >= 0.0 && c[axis] < cells_[static_cast<std::size_t>(axis)]))
            return -1;
    const auto x = static_cast<std::size_t>(c.x()), y = static_cast<std::size_t>(c.y()),
               z = static_cast<std::size_t>(c.z());
    return nearest_[(z * static_cast<std::size_t>(cells_[1]) + y) * static_cast<std::size_t>(cells_[0]) + x];
}

std::size_t TouchSurface::bytes() const
{
    return static_cast<std::size_t>(rest_.size() + normals_.size()) * sizeof(double)
        + triangles_.size() * sizeof(triangles_[0])
        + (neighbours_.entry.size() + triangles_round_.entry.size() + contact_node_vertices_.entry.size()
              + nearest_.size())
        * sizeof(std::int32_t)
        + weights_.size() * sizeof(double);
}

} // namespace retractor::haptics
