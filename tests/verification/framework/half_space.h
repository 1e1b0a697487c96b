#pragma once
// A quarter of a cylinder that stands for the half-space z > 0: rings, of which one is the circle where conditions
// change, and grow towards the far side. What is pressed moves its far side as a point load of the same size would
// [Boussinesq], so that no answer is stiffened by the body's end (a block of height H would be, by about 1.3 a / H);
// round a cut it is left free, for that is not felt far away. Units mm, N, MPa.

#include "tests/verification/framework/meshes.h"

#include <vector>

namespace retractor::verification {

/// Depth z >= 0 below the surface z = 0, outwards radius r; the circle has radius a.
struct QuarterCylinder {
    mesh::TetMesh mesh;
    double a = 0.0;

    bool in_circle(const Vec3& p) const;
    bool at_far_side(const Vec3& p) const;
    /// Faces of the surface within the circle.
    std::vector<mesh::TetFace> circle() const;
    VertexId nearest(const Vec3& at) const;
};

/// n cells of a / n, then 2 n cells that grow to the far side, 12 a away.
QuarterCylinder quarter_cylinder(int nodes_per_tet, double a, int n);

/// The planes of symmetry hold what lies in them.
Held symmetric(const QuarterCylinder& body);
/// Displacement of a unit force into the half-space z > 0 at the origin [Boussinesq 1885; Johnson, Contact mechanics,
/// 3.19].
Vec3 boussinesq(double E, double nu, const Vec3& p);
/// The far side moved by `force` times the field of a unit point load.
Held with_far_side(Held held, const QuarterCylinder& body, double E, double nu, double force);

/// An element and its meshes: cells from the middle to the circle.
struct HalfSpaceRun {
    VerificationElement element;
    std::vector<int> cells;
};
std::vector<HalfSpaceRun> half_space_runs(bool fine);

} // namespace retractor::verification
