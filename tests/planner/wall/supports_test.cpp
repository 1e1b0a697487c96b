#include "planner/wall/supports.h"

#include "fem/model/pre_strain.h"
#include "planner/wall/rib_joints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace retractor::planner {
namespace supports_test {

    constexpr Label kSkin = 1;
    constexpr Label kSpine = 2;
    constexpr Label kLung = 3;

    /// A slab of wall that fills x in [0, 40], y in [0, 20], z in [0, 20] of an image that reaches 10 mm further in y
    /// and z and to x = 60; the wall goes on from x = 40 to 60, beyond the mesh. Lung lies under it (z < 0).
    mesh::LabelVolume slab()
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 71, 41, 41 };
        labels.grid.origin = { -10.0, -10.0, -10.0 };
        labels.table = { { kSkin, "skin", "skin", mesh::Role::wall }, { kSpine, "spine", "bone", mesh::Role::wall },
            { kLung, "lung_left", "lung", mesh::Role::voxel } };
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (int k = 0; k < 41; ++k)
            for (int j = 0; j < 41; ++j)
                for (int i = 0; i < 71; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    const bool across = p.y() >= 0.0 && p.y() <= 20.0;
                    if (across && p.x() >= 0.0 && p.z() >= 0.0 && p.z() <= 20.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = kSkin;
                    else if (across && p.z() < 0.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = kLung;
                }
        return labels;
    }

    TEST(Supports, TheCutOffBorderIsHeldAndTheRestIsFree)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(8, 4, 4, 5.0, kSkin); // to x = 40
        const auto held = wall_supports(mesh, slab(), {}, {}, true);
        std::set<VertexId> set(held.begin(), held.end());
        std::size_t inner_border = 0;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 p = mesh.vertices.row(v);
            const bool on_edge = p.y() == 0.0 || p.y() == 20.0 || p.z() == 0.0 || p.z() == 20.0;
            if (p.x() == 40.0 && !on_edge) {
                EXPECT_TRUE(set.count(v)) << p.transpose();
                ++inner_border;
            }
            if (p.x() < 40.0) {
                EXPECT_FALSE(set.count(v)) << p.transpose();
            }
        }
        EXPECT_EQ(inner_border, 9u);
        EXPECT_TRUE(wall_supports(mesh, slab(), {}, {}, false).empty());
        // A spine that is nowhere near holds nothing: the border still has to.
        const std::array<Label, 1> spine { kSpine };
        EXPECT_EQ(wall_supports(mesh, slab(), spine, {}, true), held);
    }

    TEST(Supports, WhereTheWallWasCutOffItHasNoSkinThoughNothingHoldsIt)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(8, 4, 4, 5.0, kSkin); // to x = 40
        const std::vector<VertexId> cut_off = cut_off_vertices(mesh, slab());
        std::vector<VertexId> end;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 0) == 40.0)
                end.push_back(v);
        EXPECT_EQ(cut_off, end);
        constexpr double kFar = 20.0; // from its true end, at x = 0
        const std::array<Label, 1> skin { kSkin };
        const std::vector<Vec3> normals = fem::surface_normals(mesh, skin, cut_off);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (mesh.vertices(mesh.tet(t)[0], 0) > kFar) {
                EXPECT_NEAR(normals[static_cast<std::size_t>(t)].x(), 0.0, 1e-12) << "element " << t;
            }
    }

    /// A rib along x whose head stands 2 mm off a spine that fills x < 0.
    mesh::LabelVolume rib_and_spine()
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 71, 21, 21 };
        labels.grid.origin = { -10.0, 0.0, 0.0 };
        labels.table
            = { { kSkin, "rib_left_5", "bone", mesh::Role::wall }, { kSpine, "spine", "bone", mesh::Role::wall } };
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (int k = 0; k < 21; ++k)
            for (int j = 0; j < 21; ++j)
                for (int i = 0; i < 71; ++i)
                    if (const double x = labels.grid.world(Vec3(i, j, k)).x(); x < 0.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = kSpine;
                    else if (x >= 2.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = kSkin;
        return labels;
    }

    TEST(Supports, ARibHangsOnItsJoint)
    {
        const std::array<Label, 1> spine { kSpine };
        const std::array<Label, 1> whole { kSkin };
        for (const double edge : { 5.0, 4.0, 2.0 }) {
            const auto cells = [&](double length) { return static_cast<int>(std::lround(length / edge)); };
            mesh::TetMesh rib = mesh::kuhn_box(cells(40.0), cells(20.0), cells(20.0), edge, kSkin);
            rib.vertices.col(0).array() += 2.0;
            EXPECT_TRUE(wall_supports(rib, rib_and_spine(), spine, whole, false).empty()) << edge;
            double stiffness = 0.0;
            Vec3 centre = Vec3::Zero();
            const RibJoints joints = rib_joints(rib, rib_and_spine(), spine);
            const std::vector<fem::BeddedVertex>& joint = joints.springs;
            for (const fem::BeddedVertex& spring : joint) {
                const Vec3 place = point_at(rib.vertices, spring.vertex);
                EXPECT_GT(spring.stiffness, 0.0);
                EXPECT_LE(place.x() + 1.0, kJointReachMm); // the spine's last voxels stand at x = -1
                stiffness += spring.stiffness;
                centre += spring.stiffness / kJointN_per_mm * place;
            }
            double turning = 0.0; // mean over the three axes
            for (const fem::BeddedVertex& spring : joint)
                turning
                    += 2.0 / 3.0 * spring.stiffness * (point_at(rib.vertices, spring.vertex) - centre).squaredNorm();
            EXPECT_NEAR(stiffness, kJointN_per_mm, 1e-6 * kJointN_per_mm) << edge;
            if (!joints.hinges.empty()) // so broad a block may have two places: see rib_joints_test.cpp
                continue;
            // Springs that add less than a billionth are left out.
            EXPECT_NEAR(turning, kJointNmm_per_rad, 1e-6 * kJointNmm_per_rad) << edge;
            EXPECT_LT((centre.tail<2>() - Eigen::Vector2d(10.0, 10.0)).norm(), 0.15 * edge)
                << edge; // the mesh is not symmetric
        }
    }

    TEST(Supports, APartOfABoneWithoutItsHeadHasNoJoint)
    {
        mesh::TetMesh rib = mesh::kuhn_box(10, 4, 4, 5.0, kSkin);
        rib.vertices.col(0).array() += 2.0 + kJointReachMm;
        const std::array<Label, 1> spine { kSpine };
        EXPECT_TRUE(rib_joints(rib, rib_and_spine(), spine).springs.empty());
        EXPECT_TRUE(rib_joints(rib, rib_and_spine(), {}).springs.empty());
    }

    /// The end of a cartilage has few vertices, most of them on its rim, where normals do not point at the sternum.
    TEST(Supports, TheWholeEndOfACartilageIsHeldOnASternumThatIsNotMeshed)
    {
        mesh::LabelVolume labels = rib_and_spine(); // fills y and z from 0 to 20
        labels.table[0] = { kSkin, "costal_cartilages", "cartilage", mesh::Role::wall };
        labels.table[1] = { kSpine, "sternum", "bone", mesh::Role::wall };
        const std::array<Label, 1> whole { kSkin };
        for (const double edge : { 20.0, 10.0, 5.0 }) {
            const auto cells = [&](double length) { return static_cast<int>(std::lround(length / edge)); };
            mesh::TetMesh cartilage = mesh::kuhn_box(cells(40.0), cells(20.0), cells(20.0), edge, kSkin);
            cartilage.vertices.col(0).array() += 0.5;
            const auto held = wall_supports(cartilage, labels, {}, whole, true);
            const std::set<VertexId> set(held.begin(), held.end());
            for (VertexId v = 0; v < static_cast<VertexId>(cartilage.vertex_count()); ++v)
                if (cartilage.vertices(v, 0) == 0.5) {
                    EXPECT_TRUE(set.contains(v)) << cartilage.vertices.row(v) << ", edges of " << edge;
                }
        }
    }

    TEST(Supports, AWholeBoneThatLeavesTheImageIsNotHeldThereWhenItHasAJoint)
    {
        mesh::TetMesh rib = mesh::kuhn_box(10, 4, 4, 5.0, kSkin);
        rib.vertices.col(0).array() += 2.0;
        mesh::LabelVolume labels = rib_and_spine();
        const std::array<Label, 1> spine { kSpine };
        const std::array<Label, 1> whole { kSkin };
        EXPECT_TRUE(wall_supports(rib, labels, spine, whole, true).empty()); // its far end and sides leave the image
        const auto without_spine = wall_supports(rib, labels, {}, whole, true);
        EXPECT_TRUE(std::any_of(without_spine.begin(), without_spine.end(),
            [&](VertexId v) { return rib.vertices(v, 0) > 2.0 * kJointGapMm; }));
    }

    TEST(Supports, AShoulderBladeHangsInTheMuscleRoundIt)
    {
        // A bone in the middle of muscle; the mesh is the bone alone.
        mesh::LabelVolume labels;
        labels.grid.size = { 61, 41, 41 };
        labels.grid.origin = { -5.0, -10.0, -10.0 };
        labels.table
            = { { kSkin, "scapula_left", "bone", mesh::Role::wall }, { kSpine, "muscle", "muscle", mesh::Role::wall } };
        labels.voxels.assign(labels.grid.voxel_count(), kSpine);
        mesh::TetMesh bone = mesh::kuhn_box(10, 4, 4, 5.0, kSkin);
        for (int k = 0; k < 41; ++k)
            for (int j = 0; j < 41; ++j)
                for (int i = 0; i < 61; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    if (p.x() >= 0.0 && p.x() <= 50.0 && p.y() >= 0.0 && p.y() <= 20.0 && p.z() >= 0.0 && p.z() <= 20.0)
                        labels.voxels[labels.grid.offset(i, j, k)] = kSkin;
                }
        const std::array<Label, 1> whole { kSkin };
        double stiffness = 0.0;
        for (const fem::BeddedVertex& bedded : girdle_beds(bone, labels, whole)) {
            EXPECT_GT(bedded.stiffness, 0.0);
            stiffness += bedded.stiffness;
        }
        // Normals at edges and corners are sums of those of the faces, so that these count a little less than their
        // area.
        const double area = 2.0 * (50.0 * 20.0 + 50.0 * 20.0 + 20.0 * 20.0);
        EXPECT_NEAR(stiffness, kBedModulus * area, 0.12 * kBedModulus * area);
        EXPECT_TRUE(girdle_beds(bone, labels, {}).empty()); // not kept whole: the wall goes on round it
        labels.table[0].name = "rib_left_5";
        EXPECT_TRUE(girdle_beds(bone, labels, whole).empty()); // it has its joint
        labels.table[0].name = "scapula_left";
        for (Label& voxel : labels.voxels)
            voxel = voxel == kSpine ? Label { 0 } : voxel;
        EXPECT_TRUE(girdle_beds(bone, labels, whole).empty()); // nothing to rest on
    }

    TEST(Supports, TheSpineSideIsHeld)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(2, 1, 1, 10.0, kSkin);
        for (TetId t = 0; t < 6; ++t)
            mesh.labels[static_cast<std::size_t>(t)] = kSpine;
        const std::array<Label, 1> spine { kSpine };
        const auto held = wall_supports(mesh, slab(), spine, {}, false);
        EXPECT_EQ(held.size(), 8u);
        for (const VertexId v : held)
            EXPECT_LE(mesh.vertices(v, 0), 10.0);
    }

    TEST(Supports, WhereTheImageEndsTheWallIsHeld)
    {
        mesh::LabelVolume labels = slab();
        labels.grid.origin.x() = 0.0; // the image now begins where the mesh does
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 4, 5.0, kSkin);
        const auto held = wall_supports(mesh, labels, {}, {}, true);
        const std::set<VertexId> set(held.begin(), held.end());
        EXPECT_TRUE(set.count(2 * 25 + 2 * 5)); // the middle of the face x = 0
    }

} // namespace supports_test
} // namespace retractor::planner
