#include "haptics/spheres/surface_locator.h"

#include "mesh/base/error.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace retractor::haptics {

namespace {

    void check_closed(const TriMesh& surface)
    {
        if (surface.triangles.empty())
            throw InputError("the surface has no triangles");
        if (!surface.vertices.allFinite())
            throw InputError("a vertex of the surface is not finite");
        std::set<std::pair<VertexId, VertexId>> edges;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            for (std::size_t i = 0; i < 3; ++i) {
                const VertexId a = surface.triangles[t][i], b = surface.triangles[t][(i + 1) % 3];
                if (a < 0 || a >= surface.vertices.rows())
                    throw InputError("triangle " + std::to_string(t) + " of the surface has wrong corners");
                if (!edges.emplace(a, b).second)
                    throw InputError("the surface is not closed: two triangles lie on one side of the edge from vertex "
                        + std::to_string(a) + " to " + std::to_string(b));
            }
        for (const auto& [a, b] : edges)
            if (!edges.contains({ b, a }))
                throw InputError("the surface is not closed: nothing lies beyond the edge from vertex "
                    + std::to_string(a) + " to " + std::to_string(b));
    }

} // namespace

NearestOnSurface nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const mesh::ClosestPoint closest = mesh::closest_on_triangle(p, a, b, c);
    NearestOnSurface nearest;
    nearest.weights = closest.barycentric;
    nearest.point = closest.barycentric.x() * a + closest.barycentric.y() * b + closest.barycentric.z() * c;
    nearest.distance = closest.distance;
    return nearest;
}

NearestOnSurface nearest_on_surface(
    const Vec3& p, const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles)
{
    NearestOnSurface best;
    best.distance = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        NearestOnSurface nearest = nearest_on_triangle(p, vertices.row(triangles[t][0]).transpose(),
            vertices.row(triangles[t][1]).transpose(), vertices.row(triangles[t][2]).transpose());
        if (nearest.distance < best.distance) {
            best = nearest;
            best.triangle = t;
        }
    }
    return best;
}

double enclosed_volume(const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles)
{
    double six = 0.0;
    for (const auto& [a, b, c] : triangles)
        six += Vec3(vertices.row(a).transpose())
                   .dot(Vec3(vertices.row(b).transpose()).cross(Vec3(vertices.row(c).transpose())));
    return six / 6.0;
}

SurfaceLocator::SurfaceLocator(const TriMesh& surface)
    : surface_(surface)
{
    check_closed(surface);
    low_ = surface.vertices.colwise().minCoeff().transpose();
    high_ = surface.vertices.colwise().maxCoeff().transpose();
    const Vec3 extent = high_ - low_;
    // About as many cells meet the surface as there are triangles.
    cell_ = std::max(
        extent.norm() * 1e-3, std::sqrt(extent.squaredNorm() / static_cast<double>(surface.triangles.size())));
    for (std::size_t i = 0; i < 3; ++i)
        size_[i] = 1 + static_cast<int>(extent(static_cast<Eigen::Index>(i)) / cell_);
    const auto count = [](int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); };
    cells_.resize(count(size_[0], size_[1]) * static_cast<std::size_t>(size_[2]));
    columns_.resize(count(size_[0], size_[1]));
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        Vec3 from = surface.vertices.row(surface.triangles[t][0]).transpose(), to = from;
        for (const VertexId v : surface.triangles[t]) {
            from = from.cwiseMin(surface.vertices.row(v).transpose());
            to = to.cwiseMax(surface.vertices.row(v).transpose());
        }
        const auto a = cell_of(from), b = cell_of(to);
        for (int x = a[0]; x <= b[0]; ++x)
            for (int y = a[1]; y <= b[1]; ++y) {
                const std::size_t column = static_cast<std::size_t>(x + size_[0] * y);
                columns_[column].push_back(static_cast<std::int32_t>(t));
                for (int z = a[2]; z <= b[2]; ++z)
                    cells_[column + columns_.size() * static_cast<std::size_t>(z)].push_back(
                        static_cast<std::int32_t>(t));
            }
    }
}

std::array<int, 3> SurfaceLocator::cell_of(const Vec3& p) const
{
    std::array<int, 3> cell {};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        cell[i] = static_cast<int>(
            std::clamp(std::floor((p(axis) - low_(axis)) / cell_), 0.0, static_cast<double>(size_[i] - 1)));
    }
    return cell;
}

bool SurfaceLocator::inside(const Vec3& p) const
{
    if (!((p.array() > low_.array()).all() && (p.array() < high_.array()).all()))
        return false;
    // Lattices and meshes have round coordinates. The nudge avoids rays through an edge, which would count twice or not
    // at all.
    const double nudge = 1e-7 * (high_ - low_).maxCoeff();
    const Vec3 q = p + nudge * Vec3(0.7548776662, 0.5698402910, 0.0);
    const auto cell = cell_of(q);
    bool odd = false;
    for (const std::int32_t t : columns_[static_cast<std::size_t>(cell[0] + size_[0] * cell[1])]) {
        const auto& [ia, ib, ic] = surface_.triangles[static_cast<std::size_t>(t)];
        const Vec3 a = surface_.vertices.row(ia).transpose(), b = surface_.vertices.row(ib).transpose(),
                   c = surface_.vertices.row(ic).transpose();
        const auto side = [&](const Vec3& from, const Vec3& to) {
            return (to.x() - from.x()) * (q.y() - from.y()) - (to.y() - from.y()) * (q.x() - from.x());
        };
        const double wc = side(a, b), wa = side(b, c), wb = side(c, a);
        const bool meets = (wa > 0.0 && wb > 0.0 && wc > 0.0) || (wa < 0.0 && wb < 0.0 && wc < 0.0);
        if (meets && (wa * a.z() + wb * b.z() + wc * c.z()) / (wa + wb + wc) > q.z())
            odd = !odd;
    }
    return odd;
}

double SurfaceLocator::distance_within(const Vec3& p, double most) const
{
    double least = most;
    const auto a = cell_of(p.array() - most), b = cell_of(p.array() + most);
    for (int z = a[2]; z <= b[2]; ++z)
        for (int y = a[1]; y <= b[1]; ++y)
            for (int x = a[0]; x <= b[0]; ++x)
                for (const std::int32_t t : cells_[static_cast<std::size_t>(x + size_[0] * y)
                         + columns_.size() * static_cast<std::size_t>(z)]) {
                    const auto& [ia, ib, ic] = surface_.triangles[static_cast<std::size_t>(t)];
                    least = std::min(least,
                        nearest_on_triangle(p, surface_.vertices.row(ia).transpose(),
                            surface_.vertices.row(ib).transpose(), surface_.vertices.row(ic).transpose())
                            .distance);
                }
    return least;
}

} // namespace retractor::haptics
