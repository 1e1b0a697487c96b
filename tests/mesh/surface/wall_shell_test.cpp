#include "mesh/surface/wall_shell.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

namespace retractor::mesh {
namespace wall_shell_test {

    constexpr double kPi = std::numbers::pi;

    TriMesh torus(double ring, double tube, int around_ring, int around_tube)
    {
        TriMesh surface;
        surface.vertices.resize(static_cast<Eigen::Index>(around_ring) * around_tube, 3);
        const auto id
            = [&](int i, int j) { return static_cast<VertexId>((i % around_ring) * around_tube + j % around_tube); };
        for (int i = 0; i < around_ring; ++i)
            for (int j = 0; j < around_tube; ++j) {
                const double a = 2.0 * kPi * i / around_ring, b = 2.0 * kPi * j / around_tube;
                const double r = ring + tube * std::cos(b);
                surface.vertices.row(id(i, j)) << r * std::cos(a), r * std::sin(a), tube * std::sin(b);
                surface.triangles.push_back({ id(i, j), id(i + 1, j), id(i + 1, j + 1) });
                surface.triangles.push_back({ id(i, j), id(i + 1, j + 1), id(i, j + 1) });
            }
        return surface;
    }

    double volume(const TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += tet_volume(mesh, t);
        return sum;
    }

    TEST(WallShell, ATorusHasTheWallOfItsClosedForm)
    {
        constexpr double kRing = 40.0, kTube = 12.0, kWall = 2.0;
        const double exact = 2.0 * kPi * kPi * kRing * (kTube * kTube - (kTube - kWall) * (kTube - kWall));
        double before = 0.0;
        for (const int n : { 1, 2 }) {
            const WallShell shell = make_wall_shell(torus(kRing, kTube, 48 * n, 16 * n), kWall);
            check_mesh(shell.mesh); // no element inside out
            EXPECT_EQ(shell.thinned, 0U);
            EXPECT_EQ(shell.thinnest_mm, kWall);
            const double error = std::abs(volume(shell.mesh) / exact - 1.0);
            // Chords of 16 sides have 0.97 of a circle's area; the order is two.
            EXPECT_LT(error, 0.05 / (n * n));
            if (n == 2) {
                EXPECT_LT(error, before / 3.0);
            }
            before = error;
        }
    }

    TEST(WallShell, ItIsOneClosedLayerInsideAndOutside)
    {
        const TriMesh surface = torus(40.0, 12.0, 48, 16);
        const WallShell shell = make_wall_shell(surface, 2.0, 7);
        const auto n = static_cast<VertexId>(surface.vertices.rows());
        std::size_t outside = 0, inside = 0;
        for (const TetFace& face : boundary_faces(shell.mesh)) {
            int inner = 0;
            for (const VertexId v : face_vertices(shell.mesh, face))
                inner += v >= n ? 1 : 0;
            ASSERT_TRUE(inner == 0 || inner == 3); // nothing between them is open
            (inner == 0 ? outside : inside) += 1;
        }
        EXPECT_EQ(outside, surface.triangles.size());
        EXPECT_EQ(inside, surface.triangles.size());
        EXPECT_EQ(shell.mesh.labels.front(), 7);
    }

    TEST(WallShell, ANarrowOrganHasAThinnerWall)
    {
        const WallShell shell = make_wall_shell(torus(40.0, 2.0, 160, 12), 2.0);
        check_mesh(shell.mesh);
        EXPECT_EQ(shell.thinned, shell.mesh.vertex_count() / 2);
        EXPECT_LT(shell.thinnest_mm, 1.3); // 0.3 of its width of 4 mm
        EXPECT_GT(shell.thinnest_mm, 0.7); // chords of 12 sides
    }

    TEST(WallShell, BadThicknessIsRefused)
    {
        const TriMesh surface = torus(40.0, 12.0, 24, 8);
        for (const double bad : { 0.0, -1.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_THROW(make_wall_shell(surface, bad), InputError) << bad;
    }

    /// Cells of a 3 x 3 x 3 box that stay, each six tetrahedra; kuhn_box numbers elements cell by cell, x fastest.
    TetMesh cells(auto stays)
    {
        TetMesh mesh = kuhn_box(3, 3, 3, 1.0), rest;
        rest.vertices = mesh.vertices;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : mesh.tet(t))
                middle += 0.25 * mesh.vertices.row(v).transpose();
            if (!stays(static_cast<int>(middle.x()), static_cast<int>(middle.y()), static_cast<int>(middle.z())))
                continue;
            for (const VertexId v : mesh.tet(t))
                rest.nodes.push_back(v);
            rest.labels.push_back(1);
        }
        return rest;
    }

    double enclosed(const TriMesh& surface)
    {
        double sum = 0.0;
        for (const auto& [a, b, c] : surface.triangles)
            sum += Vec3(surface.vertices.row(a)).dot(Vec3(surface.vertices.row(b)).cross(Vec3(surface.vertices.row(c))))
                / 6.0;
        return sum;
    }

    constexpr double kRound = 1e-12;

    TEST(LargestClosedSurface, CavitiesAreLeftOut)
    {
        const TriMesh surface
            = largest_closed_surface(cells([](int i, int j, int k) { return i + j + k != 3 || i != 1 || j != 1; }));
        EXPECT_NEAR(enclosed(surface), 27.0, kRound);
        EXPECT_EQ(surface.triangles.size(), 9U * 6U * 2U);
        EXPECT_EQ(surface.vertices.rows(), 56); // of 64, 8 inside
    }

    TEST(LargestClosedSurface, BodiesThatTouchAlongAnEdgeComeApart)
    {
        // Two cells in a row, and a third that touches them along an edge.
        const TriMesh surface = largest_closed_surface(
            cells([](int i, int j, int k) { return k == 0 && ((j == 0 && i <= 1) || (j == 1 && i == 2)); }));
        EXPECT_NEAR(enclosed(surface), 2.0, kRound);
        EXPECT_EQ(surface.vertices.rows(), 12);
    }

    TEST(LargestClosedSurface, ABodyThatTouchesItselfIsOneSurfaceWithDoubledEdges)
    {
        // A ring of seven cells round an empty one, with a corner cell gone: the ring's ends touch along an edge.
        const TriMesh surface = largest_closed_surface(
            cells([](int i, int j, int k) { return k == 0 && !(i == 1 && j == 1) && !(i == 0 && j == 0); }));
        EXPECT_NEAR(enclosed(surface), 7.0, kRound);
        std::set<std::pair<VertexId, VertexId>> edges;
        for (const auto& triangle : surface.triangles)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_TRUE(edges.emplace(triangle[c], triangle[(c + 1) % 3]).second) << "twice in one sense";
        for (const auto& [a, b] : edges)
            EXPECT_EQ(edges.count({ b, a }), 1U);
    }

    TEST(LargestClosedSurface, NothingHasNone) { EXPECT_TRUE(largest_closed_surface(TetMesh {}).triangles.empty()); }

} // namespace wall_shell_test
} // namespace retractor::mesh
