#pragma once
// Surfaces and eyes for the tests of what is seen, and the closed form for a round hole over a disc.

#include "planner/measures/sight/exposure.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace retractor::planner::sight_scenes {

inline constexpr double kPi = std::numbers::pi;
inline constexpr int kSegments = 360; ///< of a circle: its polygon lacks 5e-5 of the area

inline void add_quad(TriMesh& mesh, VertexId a, VertexId b, VertexId c, VertexId d)
{
    mesh.triangles.push_back({ a, b, c });
    mesh.triangles.push_back({ a, c, d });
}

/// A flat ring in the plane z, facing up; inner radius 0: a disc.
inline TriMesh ring(double inner, double outer, double z)
{
    TriMesh mesh;
    mesh.vertices.resize(2 * kSegments, 3);
    for (int s = 0; s < kSegments; ++s) {
        const double a = 2.0 * kPi * s / kSegments;
        mesh.vertices.row(2 * s) << inner * std::cos(a), inner * std::sin(a), z;
        mesh.vertices.row(2 * s + 1) << outer * std::cos(a), outer * std::sin(a), z;
    }
    for (int s = 0; s < kSegments; ++s) {
        const int n = (s + 1) % kSegments;
        add_quad(mesh, 2 * s, 2 * s + 1, 2 * n + 1, 2 * n);
    }
    return mesh;
}

inline TriMesh sphere(double radius, int rings)
{
    TriMesh mesh;
    const int across = 2 * rings;
    mesh.vertices.resize((rings - 1) * across + 2, 3);
    const auto id = [&](int r, int s) { return (r - 1) * across + s % across; };
    for (int r = 1; r < rings; ++r)
        for (int s = 0; s < across; ++s) {
            const double t = kPi * r / rings, a = 2.0 * kPi * s / across;
            mesh.vertices.row(id(r, s)) << radius * std::sin(t) * std::cos(a), radius * std::sin(t) * std::sin(a),
                radius * std::cos(t);
        }
    const int north = (rings - 1) * across, south = north + 1;
    mesh.vertices.row(north) << 0, 0, radius;
    mesh.vertices.row(south) << 0, 0, -radius;
    for (int s = 0; s < across; ++s) {
        mesh.triangles.push_back({ north, id(1, s), id(1, s + 1) });
        mesh.triangles.push_back({ south, id(rings - 1, s + 1), id(rings - 1, s) });
        for (int r = 1; r + 1 < rings; ++r)
            add_quad(mesh, id(r, s), id(r + 1, s), id(r + 1, s + 1), id(r, s + 1));
    }
    return mesh;
}

inline TriMesh box(const Vec3& low, const Vec3& high)
{
    TriMesh mesh;
    mesh.vertices.resize(8, 3);
    for (int v = 0; v < 8; ++v)
        for (int axis = 0; axis < 3; ++axis)
            mesh.vertices(v, axis) = (v >> axis & 1) != 0 ? high[axis] : low[axis];
    add_quad(mesh, 0, 2, 3, 1);
    add_quad(mesh, 4, 5, 7, 6);
    add_quad(mesh, 0, 1, 5, 4);
    add_quad(mesh, 2, 6, 7, 3);
    add_quad(mesh, 0, 4, 6, 2);
    add_quad(mesh, 1, 3, 7, 5);
    return mesh;
}

inline TriMesh moved(TriMesh mesh, const Eigen::Isometry3d& pose)
{
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        mesh.vertices.row(v) = (pose * Vec3(mesh.vertices.row(v).transpose())).transpose();
    return mesh;
}

inline Occluder wall(TriMesh surface)
{
    Occluder occluder;
    occluder.name = "wall";
    occluder.surface = std::move(surface);
    return occluder;
}

inline ViewCone from_above(double distance, double half_angle_deg, int eyes)
{
    ViewCone cone;
    cone.eye_distance_mm = distance;
    cone.half_angle_deg = half_angle_deg;
    cone.eyes = eyes;
    return cone;
}

/// Area of the part of a disc of radius R at the origin inside a circle of radius r whose centre is d away.
inline double lens(double R, double r, double d)
{
    if (d >= R + r)
        return 0.0;
    if (d <= std::abs(R - r))
        return kPi * std::min(R, r) * std::min(R, r);
    const double a = std::acos((d * d + r * r - R * R) / (2 * d * r)),
                 b = std::acos((d * d + R * R - r * r) / (2 * d * R));
    return r * r * (a - std::sin(2 * a) / 2) + R * R * (b - std::sin(2 * b) / 2);
}

// The scene of most tests: a disc of radius 20 at z = 0, a plate at z = 60 with a coaxial hole, the eye at 400.
inline constexpr double kDisc = 20.0, kPlate = 60.0, kEye = 400.0;

/// What one eye sees: the hole's shadow on the disc's plane is a circle too, by central projection.
inline double seen_through_hole(double hole, const Vec3& eye)
{
    const double scale = eye.z() / (eye.z() - kPlate);
    const double shift = std::hypot(eye.x(), eye.y()) * (scale - 1.0);
    return lens(kDisc, hole * scale, shift) / (kPi * kDisc * kDisc);
}

} // namespace retractor::planner::sight_scenes
