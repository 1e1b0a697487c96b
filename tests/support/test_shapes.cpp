#include "tests/support/test_shapes.h"

#include <cmath>
#include <numbers>

namespace retractor::test_support {

TriMesh box_surface(const Vec3& low, const Vec3& high)
{
    TriMesh box;
    box.vertices.resize(8, 3);
    for (int v = 0; v < 8; ++v)
        for (int axis = 0; axis < 3; ++axis)
            box.vertices(v, axis) = ((v >> axis) & 1) != 0 ? high(axis) : low(axis);
    box.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 }, { 2, 6, 3 },
        { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
    return box;
}

TriMesh ball_surface(const Vec3& centre, double radius, int rings)
{
    TriMesh ball;
    const int around = 2 * rings, inner = rings - 1;
    ball.vertices.resize(inner * around + 2, 3);
    for (int r = 0; r < inner; ++r)
        for (int a = 0; a < around; ++a) {
            const double theta = std::numbers::pi * (r + 1) / rings, phi = 2.0 * std::numbers::pi * a / around;
            ball.vertices.row(r * around + a) = (centre
                + radius * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)))
                                                    .transpose();
        }
    const int north = inner * around, south = north + 1;
    ball.vertices.row(north) = (centre + radius * Vec3::UnitZ()).transpose();
    ball.vertices.row(south) = (centre - radius * Vec3::UnitZ()).transpose();
    for (int a = 0; a < around; ++a) {
        const int b = (a + 1) % around, last = (inner - 1) * around;
        ball.triangles.push_back({ north, a, b });
        ball.triangles.push_back({ south, last + b, last + a });
        for (int r = 0; r + 1 < inner; ++r) {
            ball.triangles.push_back({ r * around + a, (r + 1) * around + a, (r + 1) * around + b });
            ball.triangles.push_back({ r * around + a, (r + 1) * around + b, r * around + b });
        }
    }
    return ball;
}

} // namespace retractor::test_support
