#include "mesh/generation/hybrid_model.h"
#include "planner/wall/unmeshed_wall.h"

#include "mesh/surface/label_surface.h"
#include "mesh/surface/wound_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::planner {
namespace unmeshed_wall_test {

    constexpr double kThickness = 20.0;
    constexpr double kRegion = 30.0, kCutDepth = 20.0;
    // It is sunk by 0.4 mm towards a corridor that lies 10 mm deep: 0.4 * 10 / 26 = 0.15 nearer; and an edge of 2.5 mm
    // is a chord of the region's border: 2.5^2 / (8 * 26) = 0.03 mm.
    constexpr double kSagMm = 0.2;

    /// A slab of muscle, 200 x 20 x 200 mm, in 2 mm voxels; outer side at y = 0, inner side at y = 20.
    mesh::LabelVolume slab()
    {
        mesh::LabelVolume labels;
        labels.grid = { .size = { 110, 20, 110 }, .spacing = { 2, 2, 2 }, .origin = { -109, -9, -109 } };
        labels.table = { { 1, "muscle", "muscle", mesh::Role::wall } };
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (int k = 0; k < 110; ++k)
            for (int j = 0; j < 20; ++j)
                for (int i = 0; i < 110; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    if (std::abs(p.x()) < 100 && std::abs(p.z()) < 100 && p.y() > 0 && p.y() < kThickness)
                        labels.voxels[labels.grid.offset(i, j, k)] = 1;
                }
        return labels;
    }

    mesh::MeshSizing sizing()
    {
        mesh::MeshSizing sizing;
        sizing.corridor = { { -20, 10, 0 }, { 20, 10, 0 } };
        sizing.region_mm = kRegion;
        return sizing;
    }

    struct Sample {
        mesh::LabelVolume labels = slab();
        TriMesh body;
        mesh::TetMesh wall;
        Sample()
        {
            const std::array<Label, 1> muscle { 1 };
            body = mesh::viewing_surface(labels, muscle, 2.5);
            wall = mesh::build_hybrid_model(labels, sizing()).wall;
        }
    };

    const Sample& sample()
    {
        static const Sample made;
        return made;
    }

    TriMesh moved_by(const Vec3& u)
    {
        const Sample& s = sample();
        const Points displacement = Points(u.transpose().replicate(s.wall.vertices.rows(), 1));
        return unmeshed_wall_region(s.body, s.labels, sizing(), s.wall, displacement, 0.0);
    }

    double from_corridor(const Vec3& p) { return (p - Vec3(std::clamp(p.x(), -20.0, 20.0), 10.0, 0.0)).norm(); }

    TEST(WallBeyond, IsTheBodysSurfaceWithoutTheRegion)
    {
        const TriMesh rest = moved_by(Vec3::Zero());
        ASSERT_FALSE(rest.triangles.empty());
        ASSERT_EQ(rest.labels.size(), rest.triangles.size());
        double nearest = 1e9;
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
            const Vec3 p = rest.vertices.row(v).transpose();
            nearest = std::min(nearest, from_corridor(p));
            if (std::abs(p.x()) < 90 && std::abs(p.z()) < 90) { // away from the slab's edges
                EXPECT_NEAR(std::min(std::abs(p.y()), std::abs(p.y() - kThickness)), 0.0, 0.6);
            }
        }
        EXPECT_LT(nearest, kRegion); // it reaches under the tetrahedra,
        EXPECT_GT(nearest, kRegion - 4.0 - kSagMm); // but not far: 4 mm
        for (const Label label : rest.labels)
            ASSERT_EQ(label, 1);
    }

    TEST(WallBeyond, BoneWithoutACoverIsDrawnAsSkin)
    {
        mesh::LabelVolume labels = sample().labels;
        labels.table = { { 1, "muscle", "muscle", mesh::Role::wall }, { 2, "skin", "skin", mesh::Role::wall },
            { 3, "rib_left_1", "bone", mesh::Role::wall } };
        for (std::size_t v = 0; v < labels.voxels.size(); ++v)
            if (labels.voxels[v] == 1 && v % 110 > 90) // all of one end
                labels.voxels[v] = 3;
        const TriMesh rest = unmeshed_wall_region(sample().body, labels, sizing(), sample().wall, {}, 0.0);
        EXPECT_EQ(std::count(rest.labels.begin(), rest.labels.end(), Label { 3 }), 0);
        EXPECT_GT(std::count(rest.labels.begin(), rest.labels.end(), Label { 2 }), 0);
    }

    TEST(WallBeyond, GoesAlongAtTheRimAndRestsFarAway)
    {
        const Vec3 u(0.0, 0.0, 8.0);
        const TriMesh rest = moved_by(Vec3::Zero()), moved = moved_by(u);
        ASSERT_EQ(rest.vertices.rows(), moved.vertices.rows());
        double rim = 0.0, middle = 0.0;
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
            const Vec3 by = (moved.vertices.row(v) - rest.vertices.row(v)).transpose();
            const double d = from_corridor(rest.vertices.row(v).transpose());
            EXPECT_LE(by.norm(), u.norm() + 1e-6);
            if (d < kRegion - 0.5) {
                EXPECT_LT((by - u).norm(), 0.2);
                ++rim;
            } else if (d > kRegion + 16.0 && d < kRegion + 24.0) {
                EXPECT_GT(by.z(), 0.15 * u.z()); // on its way from one to the other
                EXPECT_LT(by.z(), 0.75 * u.z());
                ++middle;
            } else if (d > kRegion + 50.0) {
                EXPECT_LT(by.norm(), 1e-9);
            }
        }
        EXPECT_GT(rim, 10);
        EXPECT_GT(middle, 10);
    }

    TEST(WallBeyond, MeetsTheTetrahedraWithoutAStep)
    {
        // A body's surface that lies 1.5 mm inside that of the tetrahedra on both sides.
        constexpr double kStepMm = 1.5, kSunkMm = 0.2, kMeetMm = 25.0;
        TriMesh body = sample().body;
        for (Eigen::Index v = 0; v < body.vertices.rows(); ++v)
            body.vertices(v, 1) += body.vertices(v, 1) < 0.5 * kThickness ? kStepMm : -kStepMm;
        const double inside = drawn_rim_width_mm(kRegion, kCutDepth), end = kRegion - 0.5 * inside;
        const TriMesh rest = unmeshed_wall_region(body, sample().labels, sizing(), sample().wall, {}, inside);
        // The tetrahedra's own surface lies up to half a voxel, 1 mm, off the slab's, so means are compared.
        constexpr double kMeanMm = 0.3;
        double under = 0.0, beside = 0.0, far = 0.0;
        int count_under = 0, count_beside = 0, count_far = 0;
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
            const Vec3 p = rest.vertices.row(v).transpose();
            if (std::abs(p.x()) > 80 || std::abs(p.z()) > 80) // the slab's edges
                continue;
            const double deep = std::min(p.y(), kThickness - p.y()), d = from_corridor(p);
            if (d < end - 0.5) {
                under += deep;
                ++count_under;
            } else if (d > end + 0.5 && d < end + 3.0) {
                beside += deep;
                ++count_beside;
            } else if (d > end + kMeetMm + 1.0) {
                far += deep;
                ++count_far;
            }
        }
        EXPECT_NEAR(under / count_under, kSunkMm, kMeanMm);
        EXPECT_NEAR(beside / count_beside, 0.0, kMeanMm);
        EXPECT_NEAR(far / count_far, kStepMm, kMeanMm);
    }

    TEST(WallBeyond, LeavesNoRimOutWhereTheCutMayReach)
    {
        EXPECT_EQ(drawn_rim_width_mm(50.0, 40.0), 15.0);
        EXPECT_EQ(drawn_rim_width_mm(50.0, 60.0), 10.0);
        EXPECT_EQ(drawn_rim_width_mm(50.0, 90.0), 0.0);
        EXPECT_NEAR(drawn_rim_width_mm(20.0, 10.0), 5.0, 1e-12);
    }

    TEST(WallBeyond, StandsBesideAWallWithoutItsRim)
    {
        const TriMesh boundary = mesh::deformed_boundary(sample().wall, {});
        const TriMesh drawn = without_rim(boundary, boundary, sizing(), drawn_rim_width_mm(kRegion, kCutDepth));
        EXPECT_LT(drawn.triangles.size(), boundary.triangles.size());
        ASSERT_EQ(drawn.labels.size(), drawn.triangles.size());
        const double limit = kRegion - drawn_rim_width_mm(kRegion, kCutDepth);
        for (const auto& triangle : drawn.triangles) {
            double nearest = kRegion;
            for (const VertexId v : triangle)
                nearest = std::min(nearest, from_corridor(drawn.vertices.row(v).transpose()));
            ASSERT_LT(nearest, limit);
        }
        // The surface beyond begins under the wall that is drawn: no gap.
        const TriMesh rest = unmeshed_wall_region(
            sample().body, sample().labels, sizing(), sample().wall, {}, drawn_rim_width_mm(kRegion, kCutDepth));
        double begin = kRegion;
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v)
            begin = std::min(begin, from_corridor(rest.vertices.row(v).transpose()));
        EXPECT_LT(begin, limit - 2.0);
    }

    TEST(WallBeyond, IsEmptyWhereTheTetrahedraAreAll)
    {
        mesh::MeshSizing whole = sizing();
        whole.region_mm = 0.0;
        EXPECT_TRUE(
            unmeshed_wall_region(sample().body, sample().labels, whole, sample().wall, {}, 0.0).triangles.empty());
        EXPECT_TRUE(unmeshed_wall_region({}, sample().labels, sizing(), sample().wall, {}, 0.0).triangles.empty());
    }

} // namespace unmeshed_wall_test
} // namespace retractor::planner
