#include "planner/wall/rim_motion.h"

#include "planner/wall/bones_through_skin.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace retractor::planner {
namespace rim_motion_test {

    constexpr double kRoundOff = 1e-9; // mm

    /// A box of 40 x 20 x 20 mm with one corner at the origin.
    mesh::TetMesh box() { return mesh::kuhn_box(8, 4, 4, 5.0, 1); }

    std::vector<VertexId> end_vertices(const mesh::TetMesh& mesh, double x)
    {
        std::vector<VertexId> end;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 0) == x)
                end.push_back(v);
        return end;
    }

    TEST(RimMotion, IsTheLargestMotionOfTheRimThatNothingHolds)
    {
        const mesh::TetMesh mesh = box();
        std::vector<VertexId> cut_off = end_vertices(mesh, 40.0);
        const std::vector<VertexId> at_image = end_vertices(mesh, 0.0);
        cut_off.insert(cut_off.end(), at_image.begin(), at_image.end());
        Points displacement = Points::Zero(mesh.vertices.rows(), 3);
        displacement.col(1) = 0.1 * mesh.vertices.col(1) + 0.01 * mesh.vertices.col(0); // largest at y = 20
        mesh::ImageGrid grid;
        grid.size = { 100, 100, 100 };
        grid.origin = { -1.0, -30.0, -30.0 }; // the image ends beside x = 0
        const std::vector<Vec3> line { { 0.0, 0.0, 10.0 }, { 0.0, 20.0, 10.0 } };
        const std::vector<std::uint8_t> is_rim = rim_flags(mesh, rim_places(mesh, cut_off, { line, 40.0 }, grid));
        // A region that goes on beyond the mesh has no rim inside the image, and neither has one without a limit.
        for (const double beyond : { 80.0, 0.0 }) {
            const auto flags = rim_flags(mesh, rim_places(mesh, cut_off, { line, beyond }, grid));
            const RimMotions none = rim_motions(mesh, displacement, {}, flags, grid);
            EXPECT_EQ(none.region.moved_mm, 0.0);
            EXPECT_NEAR(none.image.moved_mm, 2.0, kRoundOff);
        }
        const RimMotions free = rim_motions(mesh, displacement, {}, is_rim, grid);
        EXPECT_NEAR(free.region.moved_mm, 2.0 + 0.4, kRoundOff);
        EXPECT_NEAR(free.region.at.x(), 40.0, kRoundOff);
        EXPECT_NEAR(free.region.at.y(), 20.0, kRoundOff);
        EXPECT_EQ(free.region.label, 1);
        EXPECT_NEAR(free.image.moved_mm, 2.0, kRoundOff);
        const RimMotions held = rim_motions(mesh, displacement, end_vertices(mesh, 40.0), is_rim, grid);
        EXPECT_EQ(held.region.moved_mm, 0.0);
        EXPECT_EQ(held.region.label, 0);
    }

    TEST(RimMotion, TheReachIsThatOfTheFarthestVertexThatMoves)
    {
        const mesh::TetMesh mesh = box();
        Points displacement = Points::Zero(mesh.vertices.rows(), 3);
        displacement.col(2) = 2.0 - 0.04 * mesh.vertices.col(0).array(); // 1 mm at x = 25
        const std::array<Vec3, 2> line { Vec3(0.0, 0.0, 0.0), Vec3(0.0, 20.0, 0.0) };
        EXPECT_NEAR(moving_reach(mesh, displacement, line, 1.1), std::hypot(20.0, 20.0), kRoundOff);
        EXPECT_NEAR(moving_reach(mesh, displacement, line, -1.0), std::hypot(40.0, 20.0), kRoundOff);
        EXPECT_EQ(moving_reach(mesh, displacement, line, 3.0), 0.0);
    }

    constexpr Label kSkin = 1, kBone = 2;
    const mesh::LabelTable kTable { { kSkin, "skin", "skin", mesh::Role::wall },
        { kBone, "rib_left_6", "bone", mesh::Role::wall } };

    /// A bare bone of 100 x 10 x 10 mm, 8 mm below a flat skin at z = 18 that is drawn, and not meshed.
    struct BareBone {
        mesh::TetMesh wall = mesh::kuhn_box(20, 2, 2, 5.0, kBone);
        Points displacement = Points::Zero(wall.vertices.rows(), 3);
        TriMesh skin;

        explicit BareBone(double edge_mm)
        {
            const auto n = static_cast<VertexId>(240.0 / edge_mm);
            skin.vertices.resize(static_cast<Eigen::Index>(n + 1) * (n + 1), 3);
            for (VertexId j = 0; j <= n; ++j)
                for (VertexId i = 0; i <= n; ++i)
                    skin.vertices.row(j * (n + 1) + i) << -70.0 + i * edge_mm, -115.0 + j * edge_mm, 18.0;
            for (VertexId j = 0; j < n; ++j)
                for (VertexId i = 0; i < n; ++i) {
                    const VertexId a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
                    skin.triangles.push_back({ a, b, d });
                    skin.triangles.push_back({ a, d, c });
                }
            skin.labels.assign(skin.triangles.size(), kSkin);
        }

        std::vector<PiercingBone> found() const
        {
            return bones_through_skin(
                wall, displacement, std::vector<std::uint8_t>(wall.vertex_count(), 1), skin, kTable);
        }
    };

    TEST(BonesThroughSkin, ABareBoneThatTurnsOutOfTheSkinIsNamedWithItsDistance)
    {
        for (const double edge : { 3.0, 4.7, 8.0 }) {
            BareBone bone(edge);
            EXPECT_TRUE(bone.found().empty());
            bone.displacement.col(2) = 0.41 * bone.wall.vertices.col(0); // 41 mm up at x = 100: 33 mm out of the skin
            const std::vector<PiercingBone> out = bone.found();
            ASSERT_EQ(out.size(), 1u) << edge;
            EXPECT_EQ(out.front().name, "rib_left_6");
            EXPECT_NEAR(out.front().out_mm, 33.0, kRoundOff) << edge;
            EXPECT_NEAR(out.front().at.x(), 100.0, kRoundOff);
            bone.displacement.col(2) *= -1.0; // into the body
            EXPECT_TRUE(bone.found().empty());
        }
    }

    /// In a whole wall the skin is meshed. A coarse skin may run below a bare bone at rest: only motion counts.
    TEST(BonesThroughSkin, ABoneThatIsOutsideAtRestCountsByItsMotion)
    {
        constexpr double kOutMm = 3.0, kMovedMm = 5.0, kThickMm = 5.0;
        mesh::TetMesh wall = mesh::kuhn_box(20, 2, 2, 5.0, kBone); // up to z = 10
        const auto of_bone = static_cast<VertexId>(wall.vertex_count());
        const mesh::TetMesh skin = mesh::kuhn_box(48, 48, 1, kThickMm, kSkin);
        wall.vertices.conservativeResize(of_bone + skin.vertices.rows(), 3);
        wall.vertices.bottomRows(skin.vertices.rows())
            = skin.vertices.rowwise() + Eigen::RowVector3d(-70.0, -115.0, 10.0 - kOutMm - kThickMm);
        for (TetId t = 0; t < static_cast<TetId>(skin.tet_count()); ++t) {
            for (const VertexId v : skin.tet(t))
                wall.nodes.push_back(of_bone + v);
            wall.labels.push_back(kSkin);
        }
        std::vector<std::uint8_t> is_rim(wall.vertex_count(), 0);
        std::fill_n(is_rim.begin(), of_bone, std::uint8_t { 1 });
        Points displacement = Points::Zero(wall.vertices.rows(), 3);
        EXPECT_TRUE(bones_through_skin(wall, displacement, is_rim, {}, kTable).empty());
        displacement.topRows(of_bone).col(2).setConstant(kMovedMm);
        const std::vector<PiercingBone> out = bones_through_skin(wall, displacement, is_rim, {}, kTable);
        ASSERT_EQ(out.size(), 1u);
        EXPECT_NEAR(out.front().out_mm, kMovedMm, kRoundOff);
    }

    TEST(BonesThroughSkin, AnOpenEdgeOfTheSkinSaysNothing)
    {
        BareBone bone(4.0);
        bone.displacement.col(0).setConstant(300.0); // beyond the end of what is drawn
        bone.displacement.col(2).setConstant(12.0);
        EXPECT_TRUE(bone.found().empty());
    }

    TEST(BonesThroughSkin, BoneThatIsNoRimOrHasTissueRoundItIsNotJudged)
    {
        BareBone bone(4.0);
        bone.displacement.col(2).setConstant(20.0);
        ASSERT_FALSE(bone.found().empty());
        EXPECT_TRUE(bones_through_skin(
            bone.wall, bone.displacement, std::vector<std::uint8_t>(bone.wall.vertex_count(), 0), bone.skin, kTable)
                        .empty());
    }

} // namespace rim_motion_test
} // namespace retractor::planner
