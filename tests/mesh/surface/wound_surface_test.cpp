#include "mesh/surface/wound_surface.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace retractor::mesh {
namespace wound_surface_test {

    double volume(const TriMesh& mesh)
    {
        double v = 0.0;
        for (const auto& t : mesh.triangles)
            v += mesh.vertices.row(t[0]).dot(mesh.vertices.row(t[1]).cross(mesh.vertices.row(t[2]))) / 6.0;
        return v;
    }

    /// A box of 4 x 2 x 2 mm: label 1 in its left half, 2 in its right half.
    TetMesh two_tissues()
    {
        TetMesh mesh = kuhn_box(4, 2, 2, 1.0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            double x = 0.0;
            for (const VertexId v : mesh.tet(t))
                x += mesh.vertices(v, 0) / 4.0;
            mesh.labels[static_cast<std::size_t>(t)] = x < 2.0 ? 1 : 2;
        }
        return mesh;
    }

    TEST(WoundSurface, BoundaryEnclosesTheDeformedVolume)
    {
        const TetMesh mesh = two_tissues();
        Points stretch = Points::Zero(mesh.vertices.rows(), 3);
        stretch.col(0) = 0.5 * mesh.vertices.col(0); // 4 mm become 6 mm
        const TetSurface out = boundary_surface(mesh, stretch);
        EXPECT_NEAR(volume(out.surface), 24.0, 1e-12);
        EXPECT_EQ(out.surface.triangles.size(), 2U * (2 * (4 * 2) + 2 * (4 * 2) + 2 * (2 * 2)));
        EXPECT_EQ(out.surface.labels.size(), out.surface.triangles.size());
        for (std::size_t v = 0; v < out.vertex_of.size(); ++v) {
            const auto row = out.surface.vertices.row(static_cast<Eigen::Index>(v));
            EXPECT_EQ((row - mesh.vertices.row(out.vertex_of[v]) - stretch.row(out.vertex_of[v])).norm(), 0.0);
        }
        EXPECT_NEAR(volume(deformed_boundary(mesh, {})), 16.0, 1e-12);
    }

    TEST(WoundSurface, QuadraticFacesFollowTheirMidpoints)
    {
        const TetMesh mesh = with_midpoints(two_tissues());
        // Bending y by x^2: exact at all nodes, and the volume stays (a shear).
        Points bend = Points::Zero(mesh.vertices.rows(), 3);
        bend.col(1) = 0.1 * mesh.vertices.col(0).array().square();
        const TetSurface out = boundary_surface(mesh, bend);
        EXPECT_EQ(out.surface.triangles.size(), 4U * boundary_faces(mesh).size());
        EXPECT_NEAR(volume(out.surface), 16.0, 1e-9);
    }

    TEST(WoundSurface, TissueSurfaceIsClosedInsideTheWall)
    {
        const TetMesh mesh = two_tissues();
        const std::array<Label, 1> one { 1 };
        const TetSurface part = tissue_surface(mesh, {}, one);
        EXPECT_NEAR(volume(part.surface), 8.0, 1e-12);
        EXPECT_EQ(part.surface.labels, std::vector<Label>(part.surface.triangles.size(), 1));
        const std::array<Label, 2> both { 1, 2 };
        EXPECT_EQ(tissue_surface(mesh, {}, both).surface.triangles.size(), boundary_faces(mesh).size());
        EXPECT_TRUE(tissue_surface(mesh, {}, {}).surface.triangles.empty());
    }

    TEST(WoundSurface, RefusesBadDisplacement)
    {
        const TetMesh mesh = two_tissues();
        EXPECT_THROW(deformed_boundary(mesh, Points::Zero(3, 3)), InputError);
        Points bad = Points::Zero(mesh.vertices.rows(), 3);
        bad(2, 1) = std::nan("");
        try {
            deformed_boundary(mesh, bad);
            FAIL();
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "vertex 2");
        }
    }

} // namespace wound_surface_test
} // namespace retractor::mesh
