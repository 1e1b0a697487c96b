#include "mesh/tetrahedra/tet_mesh.h"

#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace retractor::mesh {
namespace tet_mesh_test {

    // Sums of a few thousand terms of size 1: a generous multiple of round-off.
    constexpr double kSumTolerance = 1e-10;

    double total_volume(const TetMesh& mesh)
    {
        double volume = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            volume += tet_volume(mesh, t);
        return volume;
    }

    TEST(TetMesh, CornersComeInNodeOrder)
    {
        TetMesh mesh;
        mesh.vertices.resize(4, 3);
        mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3;
        mesh.nodes = { 1, 2, 0, 3 };
        mesh.labels = { 1 };
        const std::array<Vec3, 4> corners = tet_corners(mesh, 0);
        for (std::size_t c = 0; c < 4; ++c)
            EXPECT_EQ(corners[c], Vec3(mesh.vertices.row(mesh.nodes[c]).transpose())) << c;
        const std::array<Vec3, 3> face = triangle_corners(mesh.vertices, { 3, 0, 2 });
        EXPECT_EQ(face[0], Vec3(0, 0, 3));
        EXPECT_EQ(face[2], Vec3(0, 2, 0));
    }

    TEST(TetMesh, KuhnBoxFillsItsBoxWithPositiveElements)
    {
        const TetMesh box = kuhn_box(4, 3, 2, 2.5);
        EXPECT_EQ(box.tet_count(), 4u * 3u * 2u * 6u);
        EXPECT_NO_THROW(check_mesh(box));
        EXPECT_NEAR(total_volume(box), 10.0 * 7.5 * 5.0, kSumTolerance);
        EXPECT_EQ(boundary_faces(box).size(), 2u * 2u * (4 * 3 + 4 * 2 + 3 * 2));
        const auto pieces = connected_pieces(box);
        EXPECT_EQ(std::accumulate(pieces.begin(), pieces.end(), 0), 0);
    }

    TEST(TetMesh, BoundaryFacesPointOutwards)
    {
        const TetMesh box = kuhn_box(2, 2, 2, 1.0);
        double volume = 0.0; // by the divergence theorem
        for (const TetFace& face : boundary_faces(box)) {
            const auto v = face_vertices(box, face);
            const Vec3 a = box.vertices.row(v[0]);
            const Vec3 b = box.vertices.row(v[1]);
            const Vec3 c = box.vertices.row(v[2]);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        EXPECT_NEAR(volume, 8.0, kSumTolerance);
    }

    TEST(TetMesh, DihedralAnglesOfTheRegularTetrahedron)
    {
        const auto angles = dihedral_angles_deg({ 1, 1, 1 }, { 1, -1, -1 }, { -1, 1, -1 }, { -1, -1, 1 });
        for (const double angle : angles)
            EXPECT_NEAR(angle, std::acos(1.0 / 3.0) * 180.0 / M_PI, 1e-9);
    }

    TEST(TetMesh, MidpointsSitOnTheEdgesInVtkOrder)
    {
        const TetMesh quadratic = with_midpoints(kuhn_box(2, 1, 1, 3.0));
        EXPECT_EQ(quadratic.nodes_per_tet, 10);
        for (TetId t = 0; t < static_cast<TetId>(quadratic.tet_count()); ++t) {
            const auto n = quadratic.tet(t);
            for (std::size_t e = 0; e < 6; ++e) {
                const auto& edge = kTetEdges[e];
                const Eigen::RowVector3d middle = 0.5
                    * (quadratic.vertices.row(n[static_cast<std::size_t>(edge[0])])
                        + quadratic.vertices.row(n[static_cast<std::size_t>(edge[1])]));
                EXPECT_EQ((quadratic.vertices.row(n[4 + e]) - middle).norm(), 0.0);
            }
        }
        EXPECT_THROW(with_midpoints(quadratic), InputError);
    }

    TEST(TetMesh, BadMeshesAreRefusedByName)
    {
        TetMesh nan = kuhn_box(1, 1, 1, 1.0);
        nan.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
        try {
            check_mesh(nan);
            FAIL() << "NaN was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "vertex 3");
        }
        TetMesh inverted = kuhn_box(1, 1, 1, 1.0);
        std::swap(inverted.nodes[4], inverted.nodes[5]);
        try {
            check_mesh(inverted);
            FAIL() << "an inverted element was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "element 1");
        }
        TetMesh dangling = kuhn_box(1, 1, 1, 1.0);
        dangling.nodes[2] = 99;
        EXPECT_THROW(check_mesh(dangling), InputError);
        TetMesh doubled = kuhn_box(1, 1, 1, 1.0);
        for (int copy = 0; copy < 2; ++copy) {
            doubled.nodes.insert(
                doubled.nodes.end(), { doubled.nodes[0], doubled.nodes[1], doubled.nodes[2], doubled.nodes[3] });
            doubled.labels.push_back(1);
        }
        EXPECT_THROW(boundary_faces(doubled), InputError);
    }

} // namespace tet_mesh_test
} // namespace retractor::mesh
