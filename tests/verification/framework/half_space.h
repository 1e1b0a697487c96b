#pragma once
// A quarter of a cylinder that represents the half-space z > 0. Elements form rings that grow towards the far side;
// one ring ends at the circle on which the boundary conditions change. Under an indenter the far side moves like the
// half-space under a point load of the same force [Boussinesq], so that the body's end does not stiffen the answer (a
// fixed end at depth H would stiffen it by about 1.3 a / H). Round a cut the far side is free, because a cut has no
// effect far away. Units mm, N, MPa.

#include "tests/verification/framework/meshes.h"

#include <vector>

namespace retractor::verification {

/// The mesh, with depth z >= 0 below the surface z = 0 and radius r from the axis. The circle has radius a.
struct QuarterCylinder {
    mesh::TetMesh mesh;
    double a = 0.0;

    bool in_circle(const Vec3& p) const;
    bool at_far_side(const Vec3& p) const;
    /// Faces of the surface inside the circle.
    std::vector<mesh::TetFace> circle() const;
    VertexId nearest(const Vec3& at) const;
};

/// A quarter cylinder with n cells of size a / n inside the circle and 2 n growing cells from there to the far side
/// at 12 a.
QuarterCylinder quarter_cylinder(int nodes_per_tet, double a, int n);

/// Holds the nodes in the planes of symmetry within these planes.
Held symmetric(const QuarterCylinder& body);
/// Displacement at p of a unit force into the half-space z > 0 at the origin, mm/N [Boussinesq 1885; Johnson, Contact
/// mechanics, eq. 3.19].
Vec3 boussinesq(double E, double nu, const Vec3& p);
/// Prescribes at the far side `force` times the field of a unit point load.
Held with_far_side(Held held, const QuarterCylinder& body, double E, double nu, double force);

/// An element and its meshes, by the number of cells from the middle to the circle.
struct HalfSpaceRun {
    VerificationElement element;
    std::vector<int> cells;
};
std::vector<HalfSpaceRun> half_space_runs(bool fine);

} // namespace retractor::verification
