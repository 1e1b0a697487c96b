#pragma once
// Gradients of the four linear shape functions of a tetrahedron, inline because the assembly needs them four times
// per element.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>

namespace retractor::fem {

struct CornerGradients {
    std::array<Vec3, 4> of; ///< gradient of each corner's shape function, 1/mm
    double volume = 0.0; ///< mm^3; not positive when the element is inverted
};

inline CornerGradients corner_gradients(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3)
{
    const Vec3 e1 = p1 - p0, e2 = p2 - p0, e3 = p3 - p0;
    const Vec3 n1 = e2.cross(e3), n2 = e3.cross(e1), n3 = e1.cross(e2);
    const double six_volumes = e1.dot(n1);
    CornerGradients g;
    g.of[1] = n1 / six_volumes;
    g.of[2] = n2 / six_volumes;
    g.of[3] = n3 / six_volumes;
    g.of[0] = -(g.of[1] + g.of[2] + g.of[3]);
    g.volume = six_volumes / 6.0;
    return g;
}

} // namespace retractor::fem
