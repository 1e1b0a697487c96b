#include "planner/approach/bearing_points.h"

#include "mesh/base/geometry.h"
#include "planner/approach/intercostal_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace retractor::planner {
namespace bearing_points_test {

    constexpr Label kMuscle = 1, kBone = 2;
    constexpr double kTolerance = 1e-9; // of coordinates of some ten millimetres

    mesh::LabelTable labels()
    {
        return { { .id = kMuscle, .name = "muscle", .material = "muscle", .role = mesh::Role::wall },
            { .id = kBone, .name = "rib", .material = "bone", .role = mesh::Role::wall } };
    }

    using IsBone = std::function<bool(const Vec3&)>;

    /// A block of 20 mm along x (away from the blade), 60 mm along y (the incision) and 30 mm along z (out of the
    /// body). Voxels whose centre satisfies `is_bone` are bone.
    mesh::LabelVolume block(double voxel_mm, const IsBone& is_bone)
    {
        mesh::LabelVolume volume;
        const auto voxels = [&](double length) { return static_cast<int>(std::lround(length / voxel_mm)); };
        volume.grid.size = { voxels(20.0), voxels(60.0), voxels(30.0) };
        volume.grid.spacing = Vec3::Constant(voxel_mm);
        volume.grid.origin = Vec3::Constant(0.5 * voxel_mm);
        volume.table = labels();
        for (int k = 0; k < volume.grid.size[2]; ++k)
            for (int j = 0; j < volume.grid.size[1]; ++j)
                for (int i = 0; i < volume.grid.size[0]; ++i)
                    volume.voxels.push_back(is_bone(volume.grid.world(Vec3(i, j, k))) ? kBone : kMuscle);
        return volume;
    }

    /// The same block as tetrahedra.
    mesh::TetMesh meshed_block(double edge_mm, const IsBone& is_bone)
    {
        const auto cells = [&](double length) { return static_cast<int>(std::lround(length / edge_mm)); };
        mesh::TetMesh mesh = mesh::kuhn_box(cells(20.0), cells(60.0), cells(30.0), edge_mm, kMuscle);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                middle += 0.25 * corner;
            if (is_bone(middle))
                mesh.labels[static_cast<std::size_t>(t)] = kBone;
        }
        return mesh;
    }

    /// A blade in the plane x = 0, with a hook in its middle that pulls towards the block.
    Approach with_hook(double width_mm = 10.0)
    {
        Approach approach;
        approach.name = "straight";
        approach.incision = { Vec3(0.0, 0.0, 30.0), Vec3(0.0, 60.0, 30.0) };
        approach.directions = { -Vec3::UnitZ(), -Vec3::UnitZ() };
        approach.depth_mm = 30.0;
        approach.hooks = { { .name = "hook",
            .side = 1,
            .along_mm = 31.3,
            .depth_mm = 14.2,
            .patch_width_mm = width_mm,
            .direction = Vec3::UnitX(),
            .opening_mm = 10.0 } };
        return approach;
    }

    std::vector<Vec3> places(const mesh::LabelVolume& labels, const Approach& approach)
    {
        return bearing_points(labels, approach, approach.hooks.front());
    }

    bool flat(const Vec3& p) { return p.x() > 5.0; }

    TEST(BearingPoints, TheMiddleOfAFlatBoneBearsAtEveryResolution)
    {
        for (const double voxel : { 1.0, 0.5 }) {
            const auto found = places(block(voxel, flat), with_hook());
            ASSERT_EQ(found.size(), 1U) << voxel;
            EXPECT_LT((found[0] - Vec3(5.0, 31.3, 30.0 - 14.2)).norm(), kTolerance) << voxel;
        }
    }

    TEST(BearingPoints, BoneTooFarBehindThePatchDoesNotBear)
    {
        EXPECT_EQ(places(block(0.5, [](const Vec3& p) { return p.x() > kBearingMm - 0.5; }), with_hook()).size(), 1U);
        EXPECT_TRUE(places(block(0.5, [](const Vec3& p) { return p.x() > kBearingMm + 0.5; }), with_hook()).empty());
    }

    static_assert(kMostBelowUpperRibMm < kBearingMm, "a blade bears on the upper rib through what a cut leaves");

    TEST(BearingPoints, BoneBesideThePatchDoesNotBear)
    {
        // The patch reaches from z = 8.3 to 23.3.
        EXPECT_TRUE(places(block(0.5, [](const Vec3& p) { return flat(p) && p.z() < 7.5; }), with_hook()).empty());
    }

    TEST(BearingPoints, ARoundRibBearsAtItsCrown)
    {
        // A rib along the incision, of 5 mm radius, with its crown 4 mm behind the patch, at the height 17.
        const auto rib = [](const Vec3& p) { return std::hypot(p.x() - 9.0, p.z() - 17.0) < 5.0; };
        for (const double voxel : { 1.0, 0.5 }) {
            const auto found = places(block(voxel, rib), with_hook());
            ASSERT_EQ(found.size(), 1U) << voxel;
            EXPECT_LT((found[0] - Vec3(4.0, 31.3, 17.0)).norm(), voxel) << voxel;
        }
    }

    TEST(BearingPoints, AWidePatchBearsAtSeveralPlacesButNotWhereTheBoneCurvesAway)
    {
        EXPECT_EQ(places(block(0.5, flat), with_hook(40.0)).size(), 2U);
        // From y = 31 on, under the second strip of the patch, the bone lies 2.5 mm farther behind: a rigid patch does
        // not reach it.
        const auto stepped = [](const Vec3& p) { return p.x() > (p.y() < 31.0 ? 5.0 : 7.5); };
        EXPECT_EQ(places(block(0.5, stepped), with_hook(40.0)).size(), 1U);
    }

    TEST(BearingPoints, APatchOnBoneItselfHasNone)
    {
        const mesh::LabelVolume bone = block(0.5, [](const Vec3&) { return true; });
        Approach approach = with_hook();
        EXPECT_TRUE(places(bone, approach).empty());
        find_bearing_points(approach, bone);
        EXPECT_EQ(approach.hooks.front().bears_on, std::vector<std::string> { "rib" }) << "the lip itself is bone";
    }

    TEST(BearingPoints, ABladeThatSparesARibMayGrazeItsEdge)
    {
        Approach approach = with_hook();
        // The block begins 1 mm in front of the blade.
        mesh::LabelVolume grazed = block(0.5, [](const Vec3& p) { return p.x() > 1.0; });
        grazed.grid.origin.x() -= 2.0;
        EXPECT_TRUE(places(grazed, approach).empty());
        approach.uncut_labels = { "rib" };
        EXPECT_EQ(places(grazed, approach).size(), 1U);
    }

    TEST(BearingPoints, InsertedPointsAreVerticesOfTheBone)
    {
        Approach approach = with_hook(40.0);
        find_bearing_points(approach, block(0.5, flat));
        const HookSpec& hook = approach.hooks.front();
        ASSERT_EQ(hook.bearing.size(), 2U);
        EXPECT_EQ(hook.bears_on, std::vector<std::string> { "rib" });
        for (const double edge : { 5.0, 2.5 }) {
            mesh::TetMesh wall = meshed_block(edge, flat);
            insert_bearing_points(wall, labels(), approach);
            EXPECT_NO_THROW(mesh::check_mesh(wall));
            const std::vector<VertexId> vertices = bearing_vertices(wall, labels(), hook);
            ASSERT_EQ(vertices.size(), 2U) << edge;
            for (const VertexId v : vertices) {
                EXPECT_EQ(wall.vertices(v, 0), 5.0) << edge;
                double nearest = edge;
                for (const Vec3& point : hook.bearing)
                    nearest = std::min(nearest, (point_at(wall.vertices, v) - point).norm());
                // No vertex is added within a fifth of an element of an edge or a corner.
                EXPECT_LT(nearest, 0.35 * edge) << edge;
            }
        }
    }

} // namespace bearing_points_test
} // namespace retractor::planner
