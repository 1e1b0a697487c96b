#include "mesh/cutting/store/blade.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace retractor::mesh {

namespace {

    /// A direction nearer to the line than this (sine of the angle, about 1 degree) gives no usable surface.
    constexpr double kSmallestSine = 0.02;
    /// A strip may narrow to this share of its width within the blade. The rays of a narrower strip count as crossing.
    constexpr double kNarrowestStrip = 0.02;
    /// Extension of the surface beyond its borders (mm): several of the coarsest elements of a wall.
    constexpr double kReach = 60.0;
    /// The extension stops at this share of the distance at which rays would cross.
    constexpr double kShareOfWayToCrossing = 0.9;

    std::string at_point(std::size_t i) { return "line point " + std::to_string(i); }

    void check_numbers(const Blade& blade)
    {
        if (blade.line.size() < 2)
            throw InputError("a blade needs at least two points, not " + std::to_string(blade.line.size()), "line");
        if (blade.directions.size() != 1 && blade.directions.size() != blade.line.size())
            throw InputError("a blade needs one direction, or one per point of its line, not "
                    + std::to_string(blade.directions.size()),
                "directions");
        for (std::size_t i = 0; i < blade.line.size(); ++i)
            if (!blade.line[i].allFinite())
                throw InputError("a coordinate is not finite", at_point(i));
        for (std::size_t i = 0; i < blade.directions.size(); ++i)
            if (!blade.directions[i].allFinite() || !(blade.directions[i].norm() > 0.0))
                throw InputError("a direction must be finite and not zero", "direction " + std::to_string(i));
        if (!std::isfinite(blade.depth_mm) || !(blade.depth_mm > 0.0))
            throw InputError("the depth must be positive", "depth_mm");
        if (!std::isfinite(blade.above_mm) || !(blade.above_mm >= 0.0))
            throw InputError("the height above the line must not be negative", "above_mm");
    }

    /// Gives every point a unit direction of its own.
    void spread_directions(Blade& blade)
    {
        if (blade.directions.size() == 1)
            blade.directions.assign(blade.line.size(), Vec3(blade.directions.front()));
        for (Vec3& direction : blade.directions)
            direction.normalize();
    }

    Vec3 segment(const Blade& blade, std::size_t i) { return blade.line[i + 1] - blade.line[i]; }

    void check_line(const Blade& blade)
    {
        for (std::size_t i = 0; i + 1 < blade.line.size(); ++i) {
            if (!(segment(blade, i).norm() > 0.0))
                throw InputError("a point is the same as the one before", at_point(i + 1));
            const Vec3 tangent = segment(blade, i).normalized();
            for (const std::size_t end : { i, i + 1 })
                if (tangent.cross(blade.directions[end]).norm() < kSmallestSine)
                    throw InputError("the direction runs along the line", at_point(end));
            if (blade.directions[i].dot(blade.directions[i + 1]) <= 0.0)
                throw InputError("the direction turns by 90 degrees or more to the next point", at_point(i));
            if (i > 0 && segment(blade, i - 1).normalized().dot(tangent) < -1.0 + kSmallestSine)
                throw InputError("the line turns back on itself", at_point(i));
        }
    }

    /// The smallest distance along the rays (sign +1: down, -1: up) at which two neighbouring rays cross, and the index
    /// of the first of these rays.
    std::pair<double, std::size_t> crossing_distance(const Blade& blade, double sign)
    {
        std::pair<double, std::size_t> first { std::numeric_limits<double>::infinity(), 0 };
        for (std::size_t i = 0; i + 1 < blade.line.size(); ++i) {
            const double width = segment(blade, i).norm();
            const double narrowing
                = -sign * (blade.directions[i + 1] - blade.directions[i]).dot(segment(blade, i)) / width;
            if (narrowing > 0.0 && width / narrowing < first.first)
                first = { width / narrowing, i };
        }
        return first;
    }

    double extent(const Blade& blade, double sign, double inside)
    {
        const auto [crossing, where] = crossing_distance(blade, sign);
        if (inside > (1.0 - kNarrowestStrip) * crossing)
            throw InputError("neighbouring rays of the blade cross " + std::to_string(crossing) + " mm "
                    + (sign > 0.0 ? "below" : "above") + " the line, within the blade",
                at_point(where));
        return inside + std::min(kReach, kShareOfWayToCrossing * (crossing - inside));
    }

    bool segment_meets_triangle(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t)
    {
        const auto hit = line_hit(p, q - p, t);
        return hit && hit->distance >= 0.0 && hit->distance <= 1.0;
    }

    Eigen::AlignedBox3d box(const std::array<Vec3, 3>& triangle)
    {
        Eigen::AlignedBox3d b(triangle[0]);
        b.extend(triangle[1]);
        b.extend(triangle[2]);
        return b;
    }

    /// Refuses a blade in which strips that are not neighbours meet, because such a blade would not have two sides.
    void check_strips(const TriMesh& surface, std::size_t triangles_per_strip)
    {
        std::vector<std::array<Vec3, 3>> t;
        std::vector<Eigen::AlignedBox3d> boxes;
        for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
            t.push_back(triangle_corners(surface.vertices, surface.triangles[i]));
            boxes.push_back(box(t.back()));
        }
        for (std::size_t i = 0; i < t.size(); ++i)
            for (std::size_t j = 0; j < t.size(); ++j) {
                const std::size_t a = i / triangles_per_strip, b = j / triangles_per_strip;
                if ((a > b ? a - b : b - a) < 2 || !boxes[i].intersects(boxes[j]))
                    continue;
                for (std::size_t e = 0; e < 3; ++e)
                    if (segment_meets_triangle(t[i][e], t[i][(e + 1) % 3], t[j]))
                        throw InputError("the blade crosses itself", at_point(std::max(a, b)));
            }
    }

    /// A grid of columns x rows with two triangles per cell, column by column; vertex = column * rows + row.
    std::vector<std::array<VertexId, 3>> grid_triangles(std::size_t columns, std::size_t rows)
    {
        std::vector<std::array<VertexId, 3>> triangles;
        for (std::size_t i = 0; i + 1 < columns; ++i)
            for (std::size_t j = 0; j + 1 < rows; ++j) {
                const auto a = static_cast<VertexId>(i * rows + j);
                const auto b = static_cast<VertexId>((i + 1) * rows + j);
                triangles.push_back({ a, b, a + 1 });
                triangles.push_back({ b, b + 1, a + 1 });
            }
        return triangles;
    }

    /// Barycentric weights of the point of a triangle nearest to p (Ericson 2005, Real-Time Collision Detection,
    /// section 5.1.5).
    std::array<double, 3> nearest_weights(const std::array<Vec3, 3>& t, const Vec3& p)
    {
        const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
        const double d1 = ab.dot(ap), d2 = ac.dot(ap);
        if (d1 <= 0.0 && d2 <= 0.0)
            return { 1.0, 0.0, 0.0 };
        const Vec3 bp = p - t[1];
        const double d3 = ab.dot(bp), d4 = ac.dot(bp);
        if (d3 >= 0.0 && d4 <= d3)
            return { 0.0, 1.0, 0.0 };
        const double vc = d1 * d4 - d3 * d2;
        if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
            const double v = d1 / (d1 - d3);
            return { 1.0 - v, v, 0.0 };
        }
        const Vec3 cp = p - t[2];
        const double d5 = ab.dot(cp), d6 = ac.dot(cp);
        if (d6 >= 0.0 && d5 <= d6)
            return { 0.0, 0.0, 1.0 };
        const double vb = d5 * d2 - d1 * d6;
        if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
            const double w = d2 / (d2 - d6);
            return { 1.0 - w, 0.0, w };
        }
        const double va = d3 * d6 - d5 * d4;
        if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
            const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return { 0.0, 1.0 - w, w };
        }
        const double sum = va + vb + vc;
        return { va / sum, vb / sum, vc / sum };
    }

    double angle_at(const std::array<Vec3, 3>& t, std::size_t i)
    {
        const Vec3 a = (t[(i + 1) % 3] - t[i]).normalized(), b = (t[(i + 2) % 3] - t[i]).normalized();
        return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
    }

    /// Index into Patch::normal of the feature that contains a point with these weights: 0-2 corner, 3-5 edge, 6 face.
    std::size_t feature(const std::array<double, 3>& w)
    {
        for (std::size_t i = 0; i < 3; ++i)
            if (w[i] == 1.0)
                return i;
        for (std::size_t e = 0; e < 3; ++e)
            if (w[(e + 2) % 3] == 0.0)
                return 3 + e;
        return 6;
    }

} // namespace

SweptBlade::SweptBlade(const Blade& blade)
    : blade_(blade)
{
    check_numbers(blade_);
    spread_directions(blade_);
    check_line(blade_);
    build_grid(kReach);
    build_normals();
    build_strips();
}

void SweptBlade::build_grid(double reach)
{
    const double up = extent(blade_, -1.0, blade_.above_mm), down = extent(blade_, 1.0, blade_.depth_mm);
    // The line is a row of the grid, so that the line lies on the surface also where the rays are not in one plane.
    std::vector<double> inner { 0.0, blade_.depth_mm };
    if (blade_.above_mm > 0.0)
        inner.insert(inner.begin(), -blade_.above_mm);
    depth_ = inner;
    depth_.insert(depth_.begin(), -up);
    depth_.push_back(down);

    const std::size_t n = blade_.line.size();
    std::vector<Vec3> line = blade_.line, direction = blade_.directions;
    along_.assign(1, 0.0);
    for (std::size_t i = 0; i + 1 < n; ++i)
        along_.push_back(along_.back() + segment(blade_, i).norm());
    line.insert(line.begin(), line.front() - reach * segment(blade_, 0).normalized());
    line.push_back(line.back() + reach * segment(blade_, n - 2).normalized());
    direction.insert(direction.begin(), Vec3(direction.front()));
    direction.push_back(Vec3(direction.back()));

    const auto sweep = [](const std::vector<Vec3>& p, const std::vector<Vec3>& d, const std::vector<double>& rows) {
        TriMesh mesh;
        mesh.vertices.resize(static_cast<Eigen::Index>(p.size() * rows.size()), 3);
        for (std::size_t i = 0; i < p.size(); ++i)
            for (std::size_t j = 0; j < rows.size(); ++j)
                mesh.vertices.row(static_cast<Eigen::Index>(i * rows.size() + j)) = (p[i] + rows[j] * d[i]).transpose();
        mesh.triangles = grid_triangles(p.size(), rows.size());
        return mesh;
    };
    surface_ = sweep(blade_.line, blade_.directions, inner);
    check_strips(surface_, 2 * (inner.size() - 1));
    along_.insert(along_.begin(), -reach);
    along_.push_back(along_.back() + reach);
    extended_ = sweep(line, direction, depth_);
}

/// Index of an edge of the grid. An edge goes from a vertex to the next vertex on the ray, to the vertex across the
/// strip, or to the vertex before that. Each lower vertex has three indices, in the order of the upper vertices.
std::size_t SweptBlade::edge_index(VertexId a, VertexId b) const
{
    const auto least = static_cast<std::size_t>(std::min(a, b)), step = static_cast<std::size_t>(std::abs(a - b));
    RETRACTOR_ASSERT(step == 1 || step == depth_.size() || step + 1 == depth_.size());
    return 3 * least + (step == 1 ? 0 : step == depth_.size() ? 2 : 1);
}

void SweptBlade::build_normals()
{
    std::vector<Vec3> at_vertex(static_cast<std::size_t>(extended_.vertices.rows()), Vec3::Zero());
    std::vector<bool> on_border(at_vertex.size(), false);
    struct Edge {
        Vec3 normals = Vec3::Zero(); ///< sum of the normals of the edge's faces
        int faces = 0;
    };
    std::vector<Edge> at_edge(3 * at_vertex.size());
    for (std::size_t i = 0; i < extended_.triangles.size(); ++i) {
        const auto& v = extended_.triangles[i];
        const auto t = triangle_corners(extended_.vertices, extended_.triangles[i]);
        const Vec3 normal = unit_normal(t);
        for (std::size_t k = 0; k < 3; ++k) {
            at_vertex[static_cast<std::size_t>(v[k])] += angle_at(t, k) * normal;
            Edge& edge = at_edge[edge_index(v[k], v[(k + 1) % 3])];
            edge.normals += normal;
            ++edge.faces;
        }
    }
    for (const auto& v : extended_.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (at_edge[edge_index(v[k], v[(k + 1) % 3])].faces == 1)
                on_border[static_cast<std::size_t>(v[k])] = on_border[static_cast<std::size_t>(v[(k + 1) % 3])] = true;

    reach_squared_ = (extended_.vertices.colwise().maxCoeff() - extended_.vertices.colwise().minCoeff()).squaredNorm();
    const std::size_t rows = depth_.size();
    for (std::size_t i = 0; i < extended_.triangles.size(); ++i) {
        const auto& v = extended_.triangles[i];
        Patch patch;
        patch.corner = triangle_corners(extended_.vertices, extended_.triangles[i]);
        patch.normal[6] = unit_normal(patch.corner);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto id = static_cast<std::size_t>(v[k]);
            const Edge& edge = at_edge[edge_index(v[k], v[(k + 1) % 3])];
            patch.normal[k] = at_vertex[id].normalized();
            patch.border[k] = on_border[id];
            patch.normal[3 + k] = edge.normals.normalized();
            patch.border[3 + k] = edge.faces == 1;
            patch.along[k] = along_[id / rows];
            patch.depth[k] = depth_[id % rows];
        }
        const Vec3 first = (patch.corner[1] - patch.corner[0]).normalized();
        patch.frame.row(0) = first.transpose();
        patch.frame.row(1) = patch.normal[6].cross(first).transpose();
        patch.frame.row(2) = patch.normal[6].transpose();
        for (const Vec3& corner : patch.corner) {
            const Vec3 at = patch.frame * (corner - patch.corner[0]);
            patch.extent = { std::min(patch.extent[0], at.x()), std::max(patch.extent[1], at.x()),
                std::min(patch.extent[2], at.y()), std::max(patch.extent[3], at.y()) };
        }
        patches_.push_back(patch);
    }
}

void SweptBlade::build_strips()
{
    Vec3 down = Vec3::Zero();
    for (const Vec3& direction : blade_.directions)
        down += direction;
    Vec3 off = Vec3::Zero();
    for (const Patch& patch : patches_)
        off += patch.normal[6];
    if (down.cross(off).norm() > 0.0) { // otherwise the blade turns all round, and any frame will do
        frame_.row(1) = down.normalized().transpose();
        frame_.row(2) = (off - off.dot(down) / down.squaredNorm() * down).normalized().transpose();
        frame_.row(0) = Vec3(frame_.row(1)).cross(Vec3(frame_.row(2))).transpose();
    }
    const std::size_t per_strip = 2 * (depth_.size() - 1);
    RETRACTOR_ASSERT(per_strip <= kMostPatches && patches_.size() % per_strip == 0);
    for (std::size_t first = 0; first < patches_.size(); first += per_strip) {
        Strip strip { first, first + per_strip, {} };
        for (std::size_t i = first; i < strip.last; ++i)
            for (const Vec3& corner : patches_[i].corner)
                strip.box.extend(Vec3(frame_ * corner));
        strips_.push_back(strip);
    }
    for (std::size_t first = 0; first < strips_.size(); first += kBlock) {
        Strip block { first, std::min(first + kBlock, strips_.size()), {} };
        for (std::size_t s = first; s < block.last; ++s)
            block.box.extend(strips_[s].box);
        blocks_.push_back(block);
    }
}

double SweptBlade::Patch::least_distance(const Vec3& point) const
{
    const Vec3 at = frame * (point - corner[0]);
    const double x = at.x() - std::clamp(at.x(), extent[0], extent[1]);
    const double y = at.y() - std::clamp(at.y(), extent[2], extent[3]);
    return x * x + y * y + at.z() * at.z();
}

SweptBlade::Nearest SweptBlade::nearest(const Vec3& point) const
{
    // Of triangles at equal distance the first counts. Round-off of the bounds must not leave the first triangle out.
    constexpr double kSlack = 1e-9;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const Vec3 in_frame = frame_ * point;
    const auto least_of = [&](const std::vector<Strip>& strips, std::size_t first, std::size_t last) {
        std::size_t nearest = first;
        double least = kFar;
        for (std::size_t s = first; s < last; ++s)
            if (const double bound = strips[s].box.squaredExteriorDistance(in_frame); bound < least) {
                least = bound;
                nearest = s;
            }
        return nearest;
    };
    Nearest best;
    double best_distance = kFar, enough = kFar;
    const auto look = [&](std::size_t i) {
        const auto& corner = patches_[i].corner;
        const auto w = nearest_weights(corner, point);
        const Vec3 q = w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2];
        const double distance = (point - q).squaredNorm();
        if (distance > best_distance || (distance == best_distance && i > best.triangle))
            return;
        best = { i, w, q };
        best_distance = distance;
        enough = distance * (1.0 + kSlack) + kSlack * kSlack * reach_squared_;
    };
    // The search begins with the strip that is probably nearest, and with the probably nearest patch of the strip.
    // Their distance excludes most of the rest.
    const Strip& block = blocks_[least_of(blocks_, 0, blocks_.size())];
    const std::size_t home = least_of(strips_, block.first, block.last);
    std::array<double, kMostPatches> bounds {};
    const std::size_t first = strips_[home].first, count = strips_[home].last - first;
    for (std::size_t i = 0; i < count; ++i)
        bounds[i] = patches_[first + i].least_distance(point);
    const auto guess = static_cast<std::size_t>(
        std::min_element(bounds.begin(), bounds.begin() + static_cast<std::ptrdiff_t>(count)) - bounds.begin());
    look(first + guess);
    for (std::size_t i = 0; i < count; ++i)
        if (i != guess && bounds[i] <= enough)
            look(first + i);
    for (const Strip& some : blocks_) {
        if (some.box.squaredExteriorDistance(in_frame) > enough)
            continue;
        for (std::size_t s = some.first; s < some.last; ++s) {
            if (s == home || strips_[s].box.squaredExteriorDistance(in_frame) > enough)
                continue;
            for (std::size_t i = strips_[s].first; i < strips_[s].last; ++i)
                if (patches_[i].least_distance(point) <= enough)
                    look(i);
        }
    }
    return best;
}

BladeCoordinates SweptBlade::coordinates(const Vec3& point) const
{
    const Nearest n = nearest(point);
    const Patch& patch = patches_[n.triangle];
    BladeCoordinates c;
    for (std::size_t k = 0; k < 3; ++k) {
        c.along += n.weights[k] * patch.along[k];
        c.depth += n.weights[k] * patch.depth[k];
    }
    const std::size_t f = feature(n.weights);
    const double height = patch.normal[f].dot(point - n.point);
    // The plane continues beyond a border, so that the side stays continuous there too. Within a face the height is
    // measured from the face's plane, which is exact to round-off also very near the surface.
    if (f == 6)
        c.side = patch.normal[6].dot(point - patch.corner[0]);
    else if (patch.border[f])
        c.side = height;
    else
        c.side = std::copysign((point - n.point).norm(), height);
    return c;
}

const std::array<Vec3, 3>& SweptBlade::nearest_triangle(const Vec3& point) const
{
    return patches_[nearest(point).triangle].corner;
}

Vec3 SweptBlade::normal(const Vec3& point) const { return patches_[nearest(point).triangle].normal[6]; }

Vec3 SweptBlade::project(const Vec3& point) const { return nearest(point).point; }

Vec3 SweptBlade::at(double along, double depth) const
{
    const auto cell = [](const std::vector<double>& knots, double x) {
        const auto after = std::upper_bound(knots.begin() + 1, knots.end() - 1, x);
        const auto i = static_cast<std::size_t>(after - knots.begin()) - 1;
        return std::pair { i, std::clamp((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0) };
    };
    const auto [i, u] = cell(along_, along);
    const auto [j, v] = cell(depth_, depth);
    const auto corner = [&, rows = depth_.size()](std::size_t column, std::size_t row) {
        return Vec3(extended_.vertices.row(static_cast<Eigen::Index>(column * rows + row)));
    };
    if (u + v <= 1.0)
        return (1.0 - u - v) * corner(i, j) + u * corner(i + 1, j) + v * corner(i, j + 1);
    return (u + v - 1.0) * corner(i + 1, j + 1) + (1.0 - v) * corner(i + 1, j) + (1.0 - u) * corner(i, j + 1);
}

Eigen::AlignedBox3d SweptBlade::box(double from_along, double to_along) const
{
    Eigen::AlignedBox3d box;
    const auto add_ray = [&](double along) {
        for (const double depth : { -blade_.above_mm, 0.0, blade_.depth_mm })
            box.extend(at(along, depth));
    };
    add_ray(from_along);
    add_ray(to_along);
    for (const double along : along_) // bends in between
        if (along > from_along && along < to_along)
            add_ray(along);
    return box;
}

std::vector<SweptBlade::Crease> SweptBlade::creases(double least_angle_deg) const
{
    const double cosine = std::cos(least_angle_deg * std::numbers::pi / 180.0);
    const auto rows = static_cast<VertexId>(depth_.size()), columns = static_cast<VertexId>(along_.size());
    const auto within = [&](VertexId v) { return v / rows > 0 && v / rows + 1 < columns && v % rows + 1 < rows; };
    struct Sides {
        std::array<std::size_t, 2> triangle {};
        std::size_t count = 0;
    };
    std::vector<Sides> sides_of(3 * static_cast<std::size_t>(extended_.vertices.rows()));
    for (std::size_t i = 0; i < extended_.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            Sides& sides = sides_of[edge_index(extended_.triangles[i][k], extended_.triangles[i][(k + 1) % 3])];
            RETRACTOR_ASSERT(sides.count < 2);
            sides.triangle[sides.count++] = i;
        }
    const std::array<VertexId, 3> steps { 1, rows - 1, rows };
    std::vector<Crease> creases;
    for (std::size_t e = 0; e < sides_of.size(); ++e) {
        const auto first = static_cast<VertexId>(e / 3);
        const std::pair<VertexId, VertexId> edge { first, first + steps[e % 3] };
        if (sides_of[e].count != 2 || !within(edge.first) || !within(edge.second))
            continue;
        const std::array<Vec3, 2> sides { patches_[sides_of[e].triangle[0]].normal[6],
            patches_[sides_of[e].triangle[1]].normal[6] };
        if (sides[0].dot(sides[1]) >= cosine)
            continue;
        const Vec3 from = extended_.vertices.row(edge.first), to = extended_.vertices.row(edge.second);
        const Vec3 direction = (to - from).normalized();
        creases.push_back({ from, direction, (to - from).norm(), direction.cross(sides[0] + sides[1]).normalized(),
            0.5
                * (along_[static_cast<std::size_t>(edge.first / rows)]
                    + along_[static_cast<std::size_t>(edge.second / rows)]),
            edge.first / rows == edge.second / rows });
    }
    return creases;
}

double SweptBlade::length() const { return along_[along_.size() - 2]; }
double SweptBlade::depth() const { return blade_.depth_mm; }
const TriMesh& SweptBlade::surface() const { return surface_; }

} // namespace retractor::mesh
