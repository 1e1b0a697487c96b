#include "mesh/surface/label_surface.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace retractor::mesh {
namespace label_surface_test {

    constexpr double kPi = std::numbers::pi;

    double volume(const TriMesh& mesh)
    {
        double v = 0.0;
        for (const auto& t : mesh.triangles)
            v += mesh.vertices.row(t[0]).dot(mesh.vertices.row(t[1]).cross(mesh.vertices.row(t[2]))) / 6.0;
        return v;
    }

    double area(const TriMesh& mesh)
    {
        double a = 0.0;
        for (const auto& t : mesh.triangles)
            a += 0.5
                * (mesh.vertices.row(t[1]) - mesh.vertices.row(t[0]))
                      .cross(mesh.vertices.row(t[2]) - mesh.vertices.row(t[0]))
                      .norm();
        return a;
    }

    /// Every directed edge occurs once and its reverse once: closed, manifold and consistently oriented.
    bool closed_manifold(const TriMesh& mesh)
    {
        std::map<std::pair<VertexId, VertexId>, int> edges;
        for (const auto& t : mesh.triangles)
            for (std::size_t i = 0; i < 3; ++i)
                ++edges[{ t[i], t[(i + 1) % 3] }];
        for (const auto& [edge, count] : edges) {
            const auto back = edges.find({ edge.second, edge.first });
            if (count != 1 || back == edges.end() || back->second != 1)
                return false;
        }
        return !mesh.triangles.empty();
    }

    int pieces(const TriMesh& mesh)
    {
        std::vector<VertexId> parent(static_cast<std::size_t>(mesh.vertices.rows()));
        for (std::size_t v = 0; v < parent.size(); ++v)
            parent[v] = static_cast<VertexId>(v);
        const auto root = [&](VertexId v) {
            while (parent[static_cast<std::size_t>(v)] != v)
                v = parent[static_cast<std::size_t>(v)];
            return v;
        };
        for (const auto& t : mesh.triangles) {
            parent[static_cast<std::size_t>(root(t[0]))] = root(t[1]);
            parent[static_cast<std::size_t>(root(t[1]))] = root(t[2]);
        }
        std::set<VertexId> roots;
        for (const auto& t : mesh.triangles)
            roots.insert(root(t[0]));
        return static_cast<int>(roots.size());
    }

    /// A cube of `n` voxels a side centred on the world's origin.
    ImageGrid cube_grid(int n, double spacing)
    {
        ImageGrid grid { .size = { n, n, n }, .spacing = Vec3::Constant(spacing) };
        grid.origin = -grid.world(Vec3::Constant(0.5 * (n - 1)));
        return grid;
    }

    template <class Inside> LabelVolume labelled(const ImageGrid& grid, Label label, Inside&& inside)
    {
        LabelVolume labels { grid, std::vector<Label>(grid.voxel_count(), 0), {} };
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i)
                    if (inside(grid.world(Vec3(i, j, k))))
                        labels.voxels[grid.offset(i, j, k)] = label;
        return labels;
    }

    LabelVolume ball(const ImageGrid& grid, double radius)
    {
        return labelled(grid, 3, [&](const Vec3& p) { return p.norm() <= radius; });
    }

    constexpr std::array<Label, 1> kBall { 3 };

    /// The half-level of a smoothed ball lies s^2 / R inside the ball: the mean curvature 2/R times s^2/2.
    double smoothed_radius(double radius, double sigma) { return radius - sigma * sigma / radius; }

    TEST(LabelSurface, BallConvergesToTheSmoothedBall)
    {
        constexpr double kRadius = 10.3, kSigma = 1.0;
        const double r = smoothed_radius(kRadius, kSigma);
        double last = 1.0;
        for (const double h : { 1.0, 0.5, 0.25 }) {
            const int n = static_cast<int>(std::ceil(2.0 * (kRadius + 2.0) / h));
            const TriMesh mesh = label_surface(ball(cube_grid(n, h), kRadius), kBall, kSigma);
            EXPECT_TRUE(closed_manifold(mesh));
            EXPECT_EQ(pieces(mesh), 1);
            const double volume_error = std::abs(volume(mesh) / (4.0 / 3.0 * kPi * r * r * r) - 1.0);
            const double area_error = std::abs(area(mesh) / (4.0 * kPi * r * r) - 1.0);
            RecordProperty("volume_error_h" + std::to_string(h), std::to_string(volume_error));
            RecordProperty("area_error_h" + std::to_string(h), std::to_string(area_error));
            // Voxelising a ball is itself a lattice-point problem: the error falls with h, not evenly.
            EXPECT_LT(volume_error, 0.012 * h) << h;
            EXPECT_LT(area_error, 0.012 * h) << h;
            last = volume_error;
        }
        EXPECT_LT(last, 0.002);
    }

    TEST(LabelSurface, MovesWithTheGrid)
    {
        const ImageGrid straight = cube_grid(26, 1.0);
        const TriMesh reference = label_surface(ball(straight, 9.0), kBall, 1.0);
        const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
        for (const double mirror : { 1.0, -1.0 }) {
            LabelVolume moved = ball(straight, 9.0);
            moved.grid.direction = turn * Vec3(mirror, 1.0, 1.0).asDiagonal();
            moved.grid.origin = Vec3(100, -50, 20);
            const TriMesh mesh = label_surface(moved, kBall, 1.0);
            ASSERT_EQ(mesh.vertices.rows(), reference.vertices.rows());
            EXPECT_TRUE(closed_manifold(mesh));
            EXPECT_NEAR(volume(mesh), volume(reference), 1e-6 * volume(reference)); // outward, also when mirrored
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); v += 97) {
                const Vec3 index = straight.index(reference.vertices.row(v).transpose());
                EXPECT_NEAR((Vec3(mesh.vertices.row(v).transpose()) - moved.grid.world(index)).norm(), 0.0, 1e-9);
            }
        }
    }

    TEST(LabelSurface, AnisotropicVoxelsAreSmoothedInMillimetres)
    {
        ImageGrid grid { .size = { 40, 40, 14 }, .spacing = Vec3(0.7, 0.7, 2.0) };
        grid.origin = -grid.world(Vec3(19.5, 19.5, 6.5));
        const TriMesh mesh = label_surface(ball(grid, 10.0), kBall, 1.5);
        const double r = smoothed_radius(10.0, 1.5);
        EXPECT_TRUE(closed_manifold(mesh));
        EXPECT_NEAR(volume(mesh) / (4.0 / 3.0 * kPi * r * r * r), 1.0, 0.02);
    }

    TEST(LabelSurface, UnionHasNoInnerWall)
    {
        LabelVolume labels = ball(cube_grid(26, 1.0), 9.0);
        const double whole = area(label_surface(labels, kBall, 1.0));
        for (std::size_t v = 0; v < labels.voxels.size() / 2; ++v)
            if (labels.voxels[v] == 3)
                labels.voxels[v] = 4;
        EXPECT_NEAR(area(label_surface(labels, std::array<Label, 2> { 3, 4 }, 1.0)), whole, 1e-9);
    }

    TEST(LabelSurface, ClosedAtTheImageBorder)
    {
        const ImageGrid grid = cube_grid(20, 1.0);
        const LabelVolume full = labelled(grid, 3, [](const Vec3&) { return true; });
        const TriMesh mesh = label_surface(full, kBall, 0.0);
        EXPECT_TRUE(closed_manifold(mesh));
        EXPECT_NEAR(volume(mesh), 8000.0, 80.0); // the voxels' own box, its edges cut at 45 degrees
        EXPECT_TRUE(closed_manifold(label_surface(full, kBall, 1.0)));
    }

    TEST(LabelSurface, ThinPartsSurvive)
    {
        const ImageGrid grid = cube_grid(31, 1.0);
        const auto thin = [&](auto&& inside) { return label_surface(labelled(grid, 3, inside), kBall, 1.0); };
        // One voxel thick sheet of 21 x 21 voxels; one voxel thin rod of 21; 2 x 2 rod (which smoothing erases as
        // well).
        const TriMesh sheet = thin(
            [](const Vec3& p) { return std::abs(p.z()) < 0.5 && std::abs(p.x()) < 10.5 && std::abs(p.y()) < 10.5; });
        EXPECT_TRUE(closed_manifold(sheet));
        EXPECT_EQ(pieces(sheet), 1);
        EXPECT_NEAR(volume(sheet), 441.0, 0.15 * 441.0);
        const TriMesh rod = thin(
            [](const Vec3& p) { return std::abs(p.z()) < 0.5 && std::abs(p.x()) < 0.5 && std::abs(p.y()) < 10.5; });
        EXPECT_EQ(pieces(rod), 1);
        EXPECT_GT(rod.vertices.col(1).maxCoeff() - rod.vertices.col(1).minCoeff(), 20.0);
        const TriMesh thicker = thin([](const Vec3& p) {
            return p.z() > -0.5 && p.z() < 1.5 && p.x() > -0.5 && p.x() < 1.5 && std::abs(p.y()) < 10.5;
        });
        EXPECT_EQ(pieces(thicker), 1);
        EXPECT_GT(volume(thicker), 0.5 * 84.0);
        // A thin vessel leaving a thick one stays joined to it.
        const TriMesh branch = thin([](const Vec3& p) {
            return p.norm() < 6.0 || (std::abs(p.z()) < 0.5 && std::abs(p.x()) < 0.5 && p.y() > 0.0 && p.y() < 13.0);
        });
        EXPECT_EQ(pieces(branch), 1);
        EXPECT_GT(branch.vertices.col(1).maxCoeff(), 12.0);
    }

    TEST(LabelSurface, NothingToShow)
    {
        const LabelVolume labels = ball(cube_grid(10, 1.0), 3.0);
        EXPECT_TRUE(label_surface(labels, std::array<Label, 1> { 9 }).triangles.empty());
        EXPECT_TRUE(label_surface(labels, {}).triangles.empty());
    }

    TEST(ViewingSurface, JoinsSmallVoxelsAndKeepsTheShape)
    {
        const LabelVolume fine = ball(cube_grid(90, 0.7), 20.0);
        Ledger ledger;
        Job job;
        job.ledger = &ledger;
        const TriMesh look = viewing_surface(fine, kBall, 2.5, job);
        EXPECT_TRUE(closed_manifold(look));
        EXPECT_TRUE(ledger.has("viewing surface"));
        const double r = smoothed_radius(20.0, 2.5);
        const double exact = 4.0 / 3.0 * kPi * r * r * r;
        EXPECT_NEAR(volume(look), exact, 0.02 * exact); // joining voxels smooths a little more
        const TriMesh sharp = label_surface(fine, kBall, 2.5);
        EXPECT_LT(4 * look.triangles.size(), 2 * sharp.triangles.size());
        const Vec3 middle = 0.5 * (look.vertices.colwise().minCoeff() + look.vertices.colwise().maxCoeff()).transpose();
        const Vec3 expected
            = 0.5 * (sharp.vertices.colwise().minCoeff() + sharp.vertices.colwise().maxCoeff()).transpose();
        EXPECT_LT((middle - expected).norm(), 0.1); // blocks are centred on their voxels
    }

    TEST(ViewingSurface, SmoothsThinPartsAwayAndRefusesBadInput)
    {
        const LabelVolume speck = ball(cube_grid(20, 1.0), 1.5);
        EXPECT_FALSE(label_surface(speck, kBall, 2.5).triangles.empty());
        EXPECT_TRUE(viewing_surface(speck, kBall, 2.5).triangles.empty());
        EXPECT_TRUE(viewing_surface(speck, {}, 2.5).triangles.empty());
        EXPECT_THROW(viewing_surface(speck, kBall, -1.0), InputError);
    }

    TEST(LabelSurface, RecordsThePart)
    {
        Ledger ledger;
        Job job;
        job.ledger = &ledger;
        const TriMesh mesh = label_surface(ball(cube_grid(10, 1.0), 3.0), kBall, 1.0, job);
        EXPECT_FALSE(mesh.triangles.empty());
        EXPECT_TRUE(ledger.has("label surface"));
    }

    TEST(LabelSurface, RefusesBadInput)
    {
        const LabelVolume labels = ball(cube_grid(10, 1.0), 3.0);
        const std::vector<std::uint8_t> mask(5, 1);
        EXPECT_THROW(mask_surface(labels.grid, mask), InputError);
        EXPECT_THROW(label_surface(labels, kBall, -1.0), InputError);
        EXPECT_THROW(label_surface(labels, kBall, std::nan("")), InputError);
        LabelVolume flat = labels;
        flat.grid.spacing[1] = 0.0;
        EXPECT_THROW(label_surface(flat, kBall), InputError);
    }

} // namespace label_surface_test
} // namespace retractor::mesh
