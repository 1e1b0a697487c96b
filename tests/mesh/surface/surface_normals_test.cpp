#include "mesh/surface/surface_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::mesh {
namespace surface_normals_test {

    constexpr double kRoundOff = 4 * std::numeric_limits<double>::epsilon();

    /// The corner of a cube at the origin: three faces, two triangles each, seen from outside at negative coordinates.
    TriMesh cube_corner()
    {
        TriMesh mesh;
        mesh.vertices.resize(7, 3);
        mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1;
        mesh.triangles = { { 0, 2, 4 }, { 0, 4, 1 }, { 0, 3, 5 }, { 0, 5, 2 }, { 0, 1, 6 }, { 0, 6, 3 } };
        return mesh;
    }

    TEST(VertexNormals, PointAlongTheDiagonalAtACubesCorner)
    {
        const Points normals = vertex_normals(cube_corner());
        const Vec3 diagonal = Vec3::Constant(-1.0 / std::sqrt(3.0));
        EXPECT_LT((normals.row(0).transpose() - diagonal).norm(), kRoundOff);
        EXPECT_LT((normals.row(4).transpose() - Vec3(0, 0, -1)).norm(), kRoundOff) << "of one face alone";
    }

    TEST(VertexNormals, WeighTrianglesByArea)
    {
        TriMesh mesh; // three times the area in the plane z = 0 as in the plane x = 0
        mesh.vertices.resize(4, 3);
        mesh.vertices << 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0, 1;
        mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        const Vec3 expected = Vec3(1, 0, 3).normalized();
        EXPECT_LT((vertex_normals(mesh).row(0).transpose() - expected).norm(), kRoundOff);
    }

    TEST(VertexNormals, AreZeroWhereNoTriangleIsOrTheyCancel)
    {
        TriMesh mesh;
        mesh.vertices = Points::Random(4, 3);
        mesh.triangles = { { 0, 1, 2 }, { 0, 2, 1 } };
        const Points normals = vertex_normals(mesh);
        EXPECT_EQ(normals.row(3).norm(), 0.0);
        EXPECT_EQ(normals.row(0).norm(), 0.0);
    }

} // namespace surface_normals_test
} // namespace retractor::mesh
