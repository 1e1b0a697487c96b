#include "haptics/servo/surface_proxy.h"

#include "mesh/base/error.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr int kMostSteps = 64; ///< triangles that a proxy crosses in one tick
    constexpr int kMostCells = 4096; ///< that a finger's way is looked at in
    constexpr double kTrianglesPerCell = 4.0;

    std::vector<std::array<std::int32_t, 3>> neighbours_of(const std::vector<std::array<VertexId, 3>>& triangles)
    {
        std::vector<std::array<std::int32_t, 3>> neighbours(triangles.size(), { -1, -1, -1 });
        std::map<std::pair<VertexId, VertexId>, std::pair<std::int32_t, int>> open;
        for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles.size()); ++t)
            for (int i = 0; i < 3; ++i) {
                const auto& tri = triangles[static_cast<std::size_t>(t)];
                const VertexId a = tri[static_cast<std::size_t>((i + 1) % 3)],
                               b = tri[static_cast<std::size_t>((i + 2) % 3)];
                const auto key = std::minmax(a, b);
                const auto [entry, fresh] = open.try_emplace(key, t, i);
                if (fresh)
                    continue;
                auto& [other, corner] = entry->second;
                if (other < 0)
                    throw InputError("an edge has more than two triangles", "triangle " + std::to_string(t));
                neighbours[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)] = other;
                neighbours[static_cast<std::size_t>(other)][static_cast<std::size_t>(corner)] = t;
                other = -1;
            }
        return neighbours;
    }

    void check(const TriMesh& surface, const SurfaceProxyOptions& options)
    {
        if (surface.triangles.empty())
            throw InputError("the surface has no triangle");
        if (!surface.vertices.allFinite())
            throw InputError("the surface has a vertex that is not finite");
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            for (const VertexId v : surface.triangles[t])
                if (v < 0 || v >= surface.vertices.rows())
                    throw InputError("a vertex does not exist", "triangle " + std::to_string(t));
        if (options.fingers == 0)
            throw InputError("there are no fingers");
        if (!(options.friction >= 0.0) || !std::isfinite(options.friction))
            throw InputError("the coefficient of friction must not be negative");
    }

} // namespace

SurfaceProxy::SurfaceProxy(const TriMesh& surface, const SurfaceProxyOptions& options)
    : options_(options)
    , triangles_(surface.triangles)
{
    check(surface, options);
    neighbours_ = neighbours_of(triangles_);
    fingers_.resize(options.fingers);
    publish(surface.vertices);
    refresh();
}

void SurfaceProxy::publish(const Points& vertices)
{
    Moment& moment = surfaces_.draft();
    if (moment.vertices.rows() != 0 && moment.vertices.rows() != vertices.rows())
        throw InputError("the surface has " + std::to_string(moment.vertices.rows()) + " vertices, not "
            + std::to_string(vertices.rows()));
    build(moment, vertices);
    surfaces_.publish();
}

void SurfaceProxy::build(Moment& m, const Points& vertices) const
{
    m.vertices = vertices;
    m.normals.setZero(vertices.rows(), 3);
    m.low = vertices.colwise().minCoeff().transpose();
    const Vec3 size = vertices.colwise().maxCoeff().transpose() - m.low;
    const double count = std::max(1.0, static_cast<double>(triangles_.size()) / kTrianglesPerCell);
    m.cell = std::max({ std::sqrt(size.x() * size.y() + size.y() * size.z() + size.z() * size.x()) / std::sqrt(count),
        size.maxCoeff() / 128.0, 1e-6 });
    for (std::size_t a = 0; a < 3; ++a)
        m.cells[a] = static_cast<std::int32_t>(size[static_cast<Eigen::Index>(a)] / m.cell) + 1;
    m.begin.assign(static_cast<std::size_t>(m.cells[0]) * static_cast<std::size_t>(m.cells[1])
                * static_cast<std::size_t>(m.cells[2])
            + 1,
        0);
    const auto for_cells = [&](std::size_t t, auto&& what) {
        std::array<std::int32_t, 3> first {}, last {};
        for (int a = 0; a < 3; ++a) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (const VertexId v : triangles_[t]) {
                low = std::min(low, vertices(v, a));
                high = std::max(high, vertices(v, a));
            }
            const auto place = static_cast<std::size_t>(a);
            first[place] = static_cast<std::int32_t>((low - m.low[a]) / m.cell);
            last[place] = std::min(m.cells[place] - 1, static_cast<std::int32_t>((high - m.low[a]) / m.cell));
        }
        for (std::int32_t z = first[2]; z <= last[2]; ++z)
            for (std::int32_t y = first[1]; y <= last[1]; ++y)
                for (std::int32_t x = first[0]; x <= last[0]; ++x)
                    what(static_cast<std::size_t>((z * m.cells[1] + y) * m.cells[0] + x));
    };
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto& tri = triangles_[t];
        const Vec3 a = vertices.row(tri[0]), b = vertices.row(tri[1]), c = vertices.row(tri[2]);
        const Vec3 weighted = (b - a).cross(c - a); // by area
        for (const VertexId v : tri)
            m.normals.row(v) += weighted.transpose();
        for_cells(t, [&](std::size_t cell) { ++m.begin[cell + 1]; });
    }
    for (std::size_t c = 1; c < m.begin.size(); ++c)
        m.begin[c] += m.begin[c - 1];
    m.triangles.resize(static_cast<std::size_t>(m.begin.back()));
    m.fill.assign(m.begin.begin(), m.begin.end());
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for_cells(t, [&](std::size_t cell) {
            m.triangles[static_cast<std::size_t>(m.fill[cell]++)] = static_cast<std::int32_t>(t);
        });
    for (Eigen::Index v = 0; v < m.normals.rows(); ++v)
        if (const double length = m.normals.row(v).norm(); length > 0.0)
            m.normals.row(v) /= length;
}

Vec3 SurfaceProxy::corner(std::int32_t triangle, int i) const noexcept
{
    return now_->vertices.row(triangles_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(i)]).transpose();
}

Vec3 SurfaceProxy::flat_normal(std::int32_t triangle) const noexcept
{
    const Vec3 a = corner(triangle, 0);
    const Vec3 n = (corner(triangle, 1) - a).cross(corner(triangle, 2) - a);
    const double length = n.norm();
    return length > 0.0 ? Vec3(n / length) : Vec3(Vec3::Zero());
}

Vec3 SurfaceProxy::normal_at(std::int32_t triangle, const Vec3& weights) const noexcept
{
    if (!options_.shaded)
        return flat_normal(triangle);
    Vec3 n = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
        n += weights[i]
            * now_->normals.row(triangles_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(i)])
                  .transpose();
    const double length = n.norm();
    return length > 0.0 ? Vec3(n / length) : flat_normal(triangle);
}

/// @return false when the box is beyond the grid, or so large that it is none of a tick's
template <class What> bool SurfaceProxy::for_triangles_in(const Vec3& low, const Vec3& high, What&& what) const noexcept
{
    const Moment& m = *now_;
    std::array<std::int32_t, 3> first {}, last {};
    long cells = 1;
    for (int a = 0; a < 3; ++a) {
        const auto place = static_cast<std::size_t>(a);
        const double from = (low[a] - m.low[a]) / m.cell, to = (high[a] - m.low[a]) / m.cell;
        if (!(to >= 0.0) || !(from <= static_cast<double>(m.cells[place])))
            return false;
        first[place] = static_cast<std::int32_t>(std::clamp(from, 0.0, static_cast<double>(m.cells[place] - 1)));
        last[place] = static_cast<std::int32_t>(std::clamp(to, 0.0, static_cast<double>(m.cells[place] - 1)));
        cells *= last[place] - first[place] + 1;
    }
    if (cells > kMostCells)
        return false;
    for (std::int32_t z = first[2]; z <= last[2]; ++z)
        for (std::int32_t y = first[1]; y <= last[1]; ++y)
            for (std::int32_t x = first[0]; x <= last[0]; ++x) {
                const auto cell = static_cast<std::size_t>((z * m.cells[1] + y) * m.cells[0] + x);
                for (std::int32_t i = m.begin[cell]; i < m.begin[cell + 1]; ++i)
                    what(m.triangles[static_cast<std::size_t>(i)]);
            }
    return true;
}

bool SurfaceProxy::find_crossing(const Vec3& from, const Vec3& to, ProxyContact& contact) const noexcept
{
    const Vec3 way = to - from;
    double nearest = 2.0;
    for_triangles_in(from.cwiseMin(to), from.cwiseMax(to), [&](std::int32_t t) {
        // [Moeller, Trumbore 1997], from outside only.
        const Vec3 a = corner(t, 0), e1 = corner(t, 1) - a, e2 = corner(t, 2) - a, p = way.cross(e2);
        const double det = e1.dot(p);
        if (!(det > 0.0))
            return;
        const Vec3 s = from - a, q = s.cross(e1);
        const double u = s.dot(p) / det, v = way.dot(q) / det, share = e2.dot(q) / det;
        if (u < 0.0 || v < 0.0 || u + v > 1.0 || share < 0.0 || share > 1.0 || share >= nearest)
            return;
        nearest = share;
        contact.triangle = t;
        contact.weights = Vec3(1.0 - u - v, u, v);
        contact.proxy = from + share * way;
    });
    return nearest <= 1.0;
}

bool SurfaceProxy::find_near(const Fingertip& tip, ProxyContact& contact) const noexcept
{
    double nearest = tip.radius;
    const Vec3 reach = Vec3::Constant(tip.radius);
    for_triangles_in(tip.position - reach, tip.position + reach, [&](std::int32_t t) {
        const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const Vec3 w = mesh::closest_on_triangle(tip.position, a, b, c).barycentric;
        const Vec3 point = w[0] * a + w[1] * b + w[2] * c, out = tip.position - point;
        if (!(out.norm() < nearest) || !(out.dot(normal_at(t, w)) > 0.0)) // from outside only
            return;
        nearest = out.norm();
        contact.triangle = t;
        contact.weights = w;
        contact.proxy = point;
    });
    return contact.triangle >= 0;
}

void SurfaceProxy::walk(ProxyContact& contact, const Vec3& goal) const noexcept
{
    // Down the distance to the goal, from triangle to triangle; each step ends at the nearest point of its triangle.
    double distance = std::numeric_limits<double>::infinity();
    std::int32_t triangle = contact.triangle;
    for (int step = 0; step < kMostSteps; ++step) {
        const Vec3 w = mesh::closest_on_triangle(goal, corner(triangle, 0), corner(triangle, 1), corner(triangle, 2))
                           .barycentric;
        const Vec3 point = w[0] * corner(triangle, 0) + w[1] * corner(triangle, 1) + w[2] * corner(triangle, 2);
        const double here = (point - goal).norm();
        if (!(here < distance - 1e-12))
            return;
        distance = here;
        contact.triangle = triangle;
        contact.weights = w;
        contact.proxy = point;
        // Across the edge that holds it back; on a corner, the side whose neighbour comes nearer.
        std::int32_t best = -1;
        double nearest = distance;
        for (int i = 0; i < 3; ++i) {
            const std::int32_t next = neighbours_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(i)];
            if (w[i] > 1e-12 || next < 0)
                continue;
            const Vec3 n
                = mesh::closest_on_triangle(goal, corner(next, 0), corner(next, 1), corner(next, 2)).barycentric;
            const double there
                = (n[0] * corner(next, 0) + n[1] * corner(next, 1) + n[2] * corner(next, 2) - goal).norm();
            if (there < nearest) {
                nearest = there;
                best = next;
            }
        }
        if (best < 0)
            return;
        triangle = best;
    }
}

const ProxyContact& SurfaceProxy::move(std::size_t finger, const Fingertip& tip) noexcept
{
    Finger& f = fingers_[finger];
    ProxyContact& c = f.contact;
    if (tip.placed)
        f = {};
    const auto let_go = [&] {
        c = {};
        f.last = tip.position;
    };
    if (!f.started) {
        f.started = true;
        f.last = tip.position;
    }
    if (!c.touching) {
        ProxyContact found;
        if (!find_crossing(f.last, tip.position, found) && !find_near(tip, found)) {
            f.last = tip.position;
            return c;
        }
        c = found;
        c.touching = true;
    } else {
        // The surface has moved under it.
        c.proxy = c.weights[0] * corner(c.triangle, 0) + c.weights[1] * corner(c.triangle, 1)
            + c.weights[2] * corner(c.triangle, 2);
    }
    Vec3 normal = normal_at(c.triangle, c.weights);
    const Vec3 lowest = tip.position - tip.radius * normal;
    const double pressed = (c.proxy - lowest).dot(normal);
    const Vec3 pull = (lowest - c.proxy) + pressed * normal; // along the surface
    const double hold = options_.friction * std::max(0.0, pressed);
    if (const double along = pull.norm(); along > hold) {
        // Dry friction: the proxy follows until what is left holds it.
        const Vec3 goal = c.proxy + (1.0 - hold / along) * pull - std::max(0.0, pressed) * normal;
        walk(c, goal);
        normal = normal_at(c.triangle, c.weights);
    }
    c.normal = normal;
    c.depth = (c.proxy - (tip.position - tip.radius * normal)).dot(normal);
    if (!(c.depth > 0.0))
        let_go();
    f.last = tip.position;
    return c;
}

} // namespace retractor::haptics
