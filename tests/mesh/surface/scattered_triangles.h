#pragma once
// A surface for searches: triangles that do not hang together.

#include "mesh/base/geometry.h"

#include <random>

namespace retractor::test_support {

/// Small triangles in a cube of 20 mm; every fiftieth is as large as the cube.
inline TriMesh scattered_triangles(int count, std::mt19937& random)
{
    std::uniform_real_distribution<double> place(0.0, 20.0), small(-1.0, 1.0);
    TriMesh mesh;
    mesh.vertices.resize(3 * count, 3);
    for (int t = 0; t < count; ++t) {
        const Vec3 middle(place(random), place(random), place(random));
        for (int i = 0; i < 3; ++i)
            mesh.vertices.row(3 * t + i)
                = (t % 50 == 0 ? Vec3(place(random), place(random), place(random))
                               : Vec3(middle + Vec3(small(random), small(random), small(random))))
                      .transpose();
        mesh.triangles.push_back({ 3 * t, 3 * t + 1, 3 * t + 2 });
    }
    return mesh;
}

} // namespace retractor::test_support
