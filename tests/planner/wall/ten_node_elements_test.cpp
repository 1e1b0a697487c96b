#include "planner/wall/ten_node_elements.h"

#include "mesh/tetrahedra/tet_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace retractor::planner {
namespace ten_node_elements_test {

    constexpr Label kMuscle = 1, kBone = 2;

    mesh::LabelTable table()
    {
        using mesh::Role;
        return { { kMuscle, "muscle", "muscle", Role::wall }, { kBone, "sternum", "bone", Role::wall } };
    }

    /// A wall of 120 x 40 x 120 mm in cubes of 10 mm with its lips at z = 0: one lip at x < 60, the other at x > 60, so
    /// that the front of the cut is the line x = 60, z = 0. Bone lies at x > 80.
    struct Wall {
        mesh::TetMesh mesh = mesh::kuhn_box(12, 4, 12, 10.0);
        std::vector<mesh::LipFace> lips {};

        explicit Wall(bool with_bone)
        {
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                mesh.labels[static_cast<std::size_t>(t)] = with_bone && middle(t).x() > 80.0 ? kBone : kMuscle;
            for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
                const auto corners = mesh::face_vertices(mesh, face);
                if (std::ranges::all_of(corners, [&](VertexId v) { return mesh.vertices(v, 2) == 0.0; }))
                    lips.push_back({ .face = face, .side = middle(face.tet).x() < 60.0 ? -1 : 1 });
            }
        }

        Vec3 middle(TetId t) const
        {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                middle += 0.25 * corner;
            return middle;
        }

        bool has_vertex(TetId t, const auto& holds) const
        {
            return std::ranges::any_of(mesh.tet(t), [&](VertexId v) { return holds(mesh.vertices.row(v)); });
        }
        bool touches_lip(TetId t) const
        {
            return has_vertex(t, [](const auto& p) { return p.z() == 0.0; });
        }
        bool touches_front(TetId t) const
        {
            return has_vertex(t, [](const auto& p) { return p.z() == 0.0 && p.x() == 60.0; });
        }
        bool touches_bone(TetId t) const
        {
            return has_vertex(t, [](const auto& p) { return p.x() >= 80.0; });
        }
        bool is_bone(TetId t) const { return mesh.labels[static_cast<std::size_t>(t)] == kBone; }
        bool is_far(TetId t) const
        {
            return !has_vertex(t, [](const auto& p) { return p.z() <= kTenNodesWithinMm + 10.0; });
        }
    };

    TEST(TenNodeElements, AreThoseAtBoneAndLipsWithoutTheFrontOfTheCut)
    {
        const Wall wall(true);
        const std::vector<std::uint8_t> marked = ten_node_elements(wall.mesh, wall.lips, table(), SoftLips::ten_nodes);
        ASSERT_EQ(marked.size(), wall.mesh.tet_count());
        for (TetId t = 0; t < static_cast<TetId>(wall.mesh.tet_count()); ++t) {
            const bool is_marked = marked[static_cast<std::size_t>(t)] != 0;
            const bool wanted
                = (wall.touches_bone(t) || wall.touches_lip(t)) && (wall.is_bone(t) || !wall.touches_front(t));
            if (!wanted || wall.is_far(t)) {
                EXPECT_FALSE(is_marked) << wall.middle(t).transpose();
            } else if (wall.middle(t).z() < kTenNodesWithinMm - 10.0) {
                EXPECT_TRUE(is_marked) << wall.middle(t).transpose();
            }
        }
    }

    TEST(TenNodeElements, LeaveSoftLipsOutWhereBladesBearOnCutBone)
    {
        const Wall wall(true);
        const std::vector<std::uint8_t> all = ten_node_elements(wall.mesh, wall.lips, table(), SoftLips::ten_nodes),
                                        fewer = ten_node_elements(wall.mesh, wall.lips, table(), SoftLips::four_nodes);
        for (TetId t = 0; t < static_cast<TetId>(wall.mesh.tet_count()); ++t) {
            const auto i = static_cast<std::size_t>(t);
            EXPECT_LE(fewer[i], all[i]);
            if (wall.is_bone(t)) {
                EXPECT_EQ(fewer[i], all[i]) << "bone bends as before";
            } else if (wall.touches_lip(t)) {
                EXPECT_EQ(fewer[i], 0) << wall.middle(t).transpose();
            } else if (wall.middle(t).z() > 25.0) { // two elements away from the lip
                EXPECT_EQ(fewer[i], all[i]) << wall.middle(t).transpose();
            }
        }
    }

    TEST(TenNodeElements, LeaveOutFlatSoftElementsAndThoseThatShareAnEdgeWithThem)
    {
        Wall wall(true);
        // One soft element beside the bone, 30 mm from the lips, is pressed flat: a corner moves towards the others.
        TetId flat = -1;
        for (TetId t = 0; t < static_cast<TetId>(wall.mesh.tet_count()) && flat < 0; ++t)
            if (!wall.is_bone(t) && wall.touches_bone(t) && wall.middle(t).z() > 30.0 && wall.middle(t).z() < 40.0)
                flat = t;
        ASSERT_GE(flat, 0);
        const auto corners = wall.mesh.tet(flat);
        const Eigen::RowVector3d across = (wall.mesh.vertices.row(corners[1]) + wall.mesh.vertices.row(corners[2])
                                              + wall.mesh.vertices.row(corners[3]))
            / 3.0;
        wall.mesh.vertices.row(corners[0]) += 0.95 * (across - wall.mesh.vertices.row(corners[0]));
        const std::vector<std::uint8_t> all = ten_node_elements(wall.mesh, wall.lips, table(), SoftLips::ten_nodes),
                                        fewer = ten_node_elements(wall.mesh, wall.lips, table(), SoftLips::four_nodes);
        EXPECT_EQ(all[static_cast<std::size_t>(flat)], 1);
        for (TetId t = 0; t < static_cast<TetId>(wall.mesh.tet_count()); ++t) {
            const auto other = wall.mesh.tet(t);
            const auto shared = std::ranges::count_if(
                other, [&](VertexId v) { return std::ranges::find(corners, v) != corners.end(); });
            if (!wall.is_bone(t) && shared >= 2) {
                EXPECT_EQ(fewer[static_cast<std::size_t>(t)], 0) << wall.middle(t).transpose();
            }
        }
    }

    TEST(TenNodeElements, AreAllInAWallWithoutBone)
    {
        const Wall wall(false);
        for (const SoftLips soft : { SoftLips::ten_nodes, SoftLips::four_nodes }) {
            const std::vector<std::uint8_t> marked = ten_node_elements(wall.mesh, wall.lips, table(), soft);
            EXPECT_EQ(std::ranges::count(marked, 1), static_cast<std::ptrdiff_t>(wall.mesh.tet_count()));
        }
    }

    TEST(TenNodeElements, ReachAnyDistanceWhereThereIsNoLip)
    {
        const Wall wall(true);
        const std::vector<std::uint8_t> marked = ten_node_elements(wall.mesh, {}, table(), SoftLips::ten_nodes);
        for (TetId t = 0; t < static_cast<TetId>(wall.mesh.tet_count()); ++t)
            EXPECT_EQ(marked[static_cast<std::size_t>(t)] != 0, wall.touches_bone(t)) << wall.middle(t).transpose();
        EXPECT_EQ(lip_points(wall.mesh, {}).rows(), 0);
        EXPECT_EQ(lip_points(wall.mesh, wall.lips).rows(), 13 * 5);
    }

} // namespace ten_node_elements_test
} // namespace retractor::planner
