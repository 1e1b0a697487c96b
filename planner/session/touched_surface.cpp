#include "planner/session/touched_surface.h"

#include "haptics/spheres/surface_locator.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::planner {

namespace {

    struct Meeting {
        double distance = 0.0;
        Vec3 weights = Vec3::Zero();
    };

    /// Where a ray meets a triangle, front faces only.
    std::optional<Meeting> meet(const Ray& ray, const std::array<Vec3, 3>& p)
    {
        if (!((p[1] - p[0]).cross(p[2] - p[0]).dot(ray.direction) < 0.0))
            return std::nullopt;
        const auto hit = line_hit(ray.origin, ray.direction, p);
        if (!hit || !(hit->distance > 0.0))
            return std::nullopt;
        return Meeting { hit->distance, { 1.0 - hit->u - hit->v, hit->u, hit->v } };
    }

    /// Distance from a point to the surface; negative behind the surface. When an edge is nearest, the face that the
    /// point lies most squarely before or behind decides the sign.
    double signed_distance(const Vec3& from, const std::vector<std::array<Vec3, 3>>& faces)
    {
        constexpr double kSame = 1e-9; // mm
        double least = std::numeric_limits<double>::infinity(), squarest = 0.0;
        for (const auto& p : faces) {
            const haptics::NearestOnSurface nearest = haptics::nearest_on_triangle(from, p[0], p[1], p[2]);
            if (nearest.distance > least + kSame)
                continue;
            const double height = (p[1] - p[0]).cross(p[2] - p[0]).normalized().dot(from - nearest.point);
            if (nearest.distance < least - kSame || std::abs(height) > std::abs(squarest))
                squarest = height;
            least = std::min(least, nearest.distance);
        }
        return squarest < 0.0 ? -least : least;
    }

    void add_circle(std::vector<std::array<Vec3, 2>>& pieces, const haptics::ElasticTemplate& s, int a, int b)
    {
        constexpr int kPieces = 48;
        const auto at = [&](int i) -> Vec3 {
            const double angle = 2.0 * std::numbers::pi * i / kPieces;
            return s.centre + s.half_size.x() * (std::cos(angle) * s.axes.col(a) + std::sin(angle) * s.axes.col(b));
        };
        for (int i = 0; i < kPieces; ++i)
            pieces.push_back({ at(i), at(i + 1) });
    }

} // namespace

std::optional<SurfacePlace> place_under(const TriMesh& surface, const Points& normals, const Ray& ray)
{
    std::optional<SurfacePlace> place;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& t : surface.triangles) {
        const auto p = triangle_corners(surface.vertices, t);
        const auto met = meet(ray, p);
        if (!met || met->distance >= nearest)
            continue;
        nearest = met->distance;
        const Vec3 smooth = (normals.row(t[0]) * met->weights[0] + normals.row(t[1]) * met->weights[1]
            + normals.row(t[2]) * met->weights[2])
                                .transpose();
        const double length = smooth.norm();
        place = SurfacePlace { ray.origin + nearest * ray.direction,
            length > 0.0 ? Vec3(smooth / length) : Vec3((p[1] - p[0]).cross(p[2] - p[0]).normalized()) };
    }
    return place;
}

Vec3 seated_on(const Points& shown, const std::vector<std::array<VertexId, 3>>& triangles, const Vec3& centre,
    double radius, const Vec3& outward)
{
    const double reach = 3.0 * radius;
    std::vector<std::array<Vec3, 3>> near;
    for (const auto& t : triangles) {
        const auto p = triangle_corners(shown, t);
        const Vec3 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
        if ((centre - low).minCoeff() > -reach && (high - centre).minCoeff() > -reach
            && (p[1] - p[0]).cross(p[2] - p[0]).dot(outward) > 0.0)
            near.push_back(p);
    }
    constexpr int kRounds = 8;
    Vec3 at = centre;
    for (int round = 0; round < kRounds; ++round) {
        const double least = signed_distance(at, near);
        if (least >= radius * (1.0 - 1e-3) || (at - centre).norm() >= 2.0 * radius)
            break;
        at += std::min(radius - least, radius) * outward;
    }
    return at;
}

std::vector<std::array<Vec3, 2>> outline_of(const haptics::ElasticTemplate& shape)
{
    std::vector<std::array<Vec3, 2>> pieces;
    if (shape.shape == haptics::ElasticTemplate::Shape::sphere) {
        add_circle(pieces, shape, 0, 1);
        add_circle(pieces, shape, 1, 2);
        add_circle(pieces, shape, 2, 0);
        return pieces;
    }
    const auto corner = [&](int i) -> Vec3 {
        const Vec3 sign((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
        return shape.centre + shape.axes * sign.cwiseProduct(shape.half_size);
    };
    for (int i = 0; i < 8; ++i)
        for (const int bit : { 1, 2, 4 })
            if ((i & bit) == 0)
                pieces.push_back({ corner(i), corner(i | bit) });
    return pieces;
}

} // namespace retractor::planner
