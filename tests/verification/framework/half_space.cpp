#include "tests/verification/framework/half_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kFar = 12.0; // radius and height of the body, in radii of the circle
    constexpr double kOnSurface = 1e-9;

    double graded(double cell, int n, double a)
    {
        const double t = cell / n;
        return t <= 1.0 ? a * t : a * std::pow(kFar, 0.5 * (t - 1.0));
    }

} // namespace

bool QuarterCylinder::in_circle(const Vec3& p) const
{
    return p.z() < kOnSurface && std::hypot(p.x(), p.y()) < a * (1.0 + 1e-6);
}

bool QuarterCylinder::at_far_side(const Vec3& p) const
{
    return p.z() > a * kFar * (1.0 - 1e-9) || std::hypot(p.x(), p.y()) > a * kFar * (1.0 - 1e-3);
}

std::vector<mesh::TetFace> QuarterCylinder::circle() const
{
    return faces_where(mesh, [&](const Vec3& p) { return in_circle(p); });
}

VertexId QuarterCylinder::nearest(const Vec3& at) const
{
    VertexId found = 0;
    (mesh.vertices.rowwise() - at.transpose()).rowwise().squaredNorm().minCoeff(&found);
    return found;
}

QuarterCylinder quarter_cylinder(int nodes_per_tet, double a, int n)
{
    QuarterCylinder body;
    body.a = a;
    body.mesh = mapped_box(nodes_per_tet, 3 * n, 3 * n, 3 * n, [&](const Vec3& p) -> Vec3 {
        const double ring = std::max(p.x(), p.y());
        if (ring < kOnSurface)
            return { 0.0, 0.0, graded(p.z(), n, a) };
        const double angle
            = p.x() >= p.y() ? 0.25 * std::numbers::pi * p.y() / ring : std::numbers::pi * (0.5 - 0.25 * p.x() / ring);
        const double r = graded(ring, n, a);
        return { r * std::cos(angle), r * std::sin(angle), graded(p.z(), n, a) };
    });
    return body;
}

Held symmetric(const QuarterCylinder& body)
{
    Held held = hold_nothing(body.mesh);
    for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v)
        for (int axis = 0; axis < 2; ++axis)
            if (body.mesh.vertices(v, axis) < kOnSurface)
                hold(held, v, axis);
    return held;
}

Vec3 boussinesq(double E, double nu, const Vec3& p)
{
    const double R = p.norm(), r = std::hypot(p.x(), p.y());
    const double scale = (1.0 + nu) / (2.0 * std::numbers::pi * E);
    const double outwards
        = r < kOnSurface ? 0.0 : scale * (r * p.z() / (R * R * R) - (1.0 - 2.0 * nu) * r / (R * (R + p.z())));
    const double down = scale * (p.z() * p.z() / (R * R * R) + 2.0 * (1.0 - nu) / R);
    return { r < kOnSurface ? 0.0 : outwards * p.x() / r, r < kOnSurface ? 0.0 : outwards * p.y() / r, down };
}

Held with_far_side(Held held, const QuarterCylinder& body, double E, double nu, double force)
{
    for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v) {
        const Vec3 p = body.mesh.vertices.row(v).transpose();
        if (body.at_far_side(p)) {
            const Vec3 u = force * boussinesq(E, nu, p);
            for (int axis = 0; axis < 3; ++axis)
                if (!(axis < 2 && p[axis] < kOnSurface))
                    hold(held, v, axis, u[axis]);
        }
    }
    return held;
}

std::vector<HalfSpaceRun> half_space_runs(bool fine)
{
    std::vector<HalfSpaceRun> all { { VerificationElement::p1, { 2, 4, 6 } },
        { VerificationElement::locking_free, { 2, 3, 4 } }, { VerificationElement::nodal, { 2, 3, 4 } },
        { VerificationElement::p2, { 1, 2, 3 } } };
    if (fine) {
        all[0].cells.push_back(8);
        all[1].cells.push_back(6);
        all[2].cells.push_back(6);
        all[3].cells.push_back(4);
    }
    return all;
}

} // namespace retractor::verification
