#include "planner/session/retractor/blade_bearing.h"

#include "mesh/tetrahedra/tet_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace retractor::planner {
namespace blade_bearing_test {

    constexpr double kRoundOff = 1e-9; // mm or rad, of sizes of some ten
    constexpr Label kMuscle = 1, kBone = 2;
    constexpr double kEdgeMm = 2.0;

    /// A block of 20 mm along x, away from the blade in the plane x = 0, 60 mm along y, the wound, and 40 mm into the
    /// body along z. Bone lies between the given depths from 4 mm behind the lip on.
    mesh::CutSession block(double from_mm, double to_mm)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(10, 30, 20, kEdgeMm, kMuscle);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                middle += 0.25 * corner;
            if (middle.x() > 4.0 && middle.z() > from_mm && middle.z() < to_mm)
                mesh.labels[static_cast<std::size_t>(t)] = kBone;
        }
        return mesh::CutSession(std::move(mesh));
    }

    /// A blade of 40 x 30 mm on all nodes of the lip that lie under it.
    HookPlacement blade(const mesh::CutSession& session)
    {
        HookPlacement placement { .centre = { 0.0, 30.0, 15.0 },
            .along = Vec3::UnitY(),
            .inward = Vec3::UnitZ(),
            .pull = Vec3::UnitX(),
            .width_mm = 40.0,
            .height_mm = 30.0,
            .arm = { 0.0, 30.0, 0.0 } };
        for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
            if (const Vec3 p = session.position(v); p.x() == 0.0 && std::abs(p.y() - 30.0) <= 20.0 && p.z() <= 30.0)
                placement.nodes.push_back(v);
        return placement;
    }

    TEST(BladeBearing, ABladeBearsAtTheLevelOfTheBoneBehindTheLip)
    {
        for (const double from : { 6.0, 14.0, 18.0 }) {
            const mesh::CutSession session = block(from, from + 8.0);
            HookPlacement placement = blade(session);
            EXPECT_TRUE(bear_on_bone(placement, session, std::vector { kBone }));
            EXPECT_NEAR(placement.lever_mm, from + 4.0, 0.5 * kEdgeMm);
            EXPECT_NEAR(placement.reach_mm, 30.0, kRoundOff);
            ASSERT_GE(placement.nodes.size(), 3U);
            double width = 0.0, highest = 30.0;
            for (const VertexId v : placement.nodes) {
                EXPECT_LE(session.position(v).z() - placement.lever_mm, 8.0);
                highest = std::min(highest, session.position(v).z());
                width = std::max(width, std::abs(session.position(v).y() - 30.0));
            }
            EXPECT_NEAR(width, 20.0, kRoundOff) << "over its whole width";
            EXPECT_NEAR(highest, 0.0, kRoundOff) << "with the skin before it";
        }
    }

    TEST(BladeBearing, BoneOfTheLipOppositeDoesNotCount)
    {
        // A block on both sides of the lip in x = 20: bone 4 mm behind it, and bone before it at another level.
        mesh::TetMesh mesh = mesh::kuhn_box(20, 30, 20, kEdgeMm, kMuscle);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                middle += 0.25 * corner;
            const bool behind = middle.x() > 24.0 && middle.z() > 6.0 && middle.z() < 14.0,
                       before = middle.x() < 20.0 && middle.z() > 20.0 && middle.z() < 28.0;
            if (behind || before)
                mesh.labels[static_cast<std::size_t>(t)] = kBone;
        }
        const mesh::CutSession session(std::move(mesh));
        HookPlacement placement { .centre = { 20.0, 30.0, 15.0 },
            .along = Vec3::UnitY(),
            .inward = Vec3::UnitZ(),
            .pull = Vec3::UnitX(),
            .width_mm = 40.0,
            .height_mm = 30.0,
            .arm = { 19.0, 30.0, 0.0 } };
        for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
            if (const Vec3 p = session.position(v);
                p.x() == 20.0 && std::abs(p.y() - 30.0) <= 20.0 && p.z() <= 18.0) // the upper half of the lip
                placement.nodes.push_back(v);
        EXPECT_TRUE(bear_on_bone(placement, session, std::vector { kBone }));
        EXPECT_NEAR(placement.lever_mm, 10.0, 0.5 * kEdgeMm);
        EXPECT_NEAR(placement.arm.x(), 20.0, kRoundOff) << "over its lip";
        EXPECT_NEAR(placement.height_mm, 18.0, kRoundOff) << "no deeper than its lip";
    }

    TEST(BladeBearing, WithoutBoneNearItABladeBearsOnTheWholeLip)
    {
        const mesh::CutSession soft = block(1.0, 0.0);
        HookPlacement placement = blade(soft);
        const std::size_t all = placement.nodes.size();
        EXPECT_FALSE(bear_on_bone(placement, soft, std::vector { kBone }));
        EXPECT_EQ(placement.nodes.size(), all);
        EXPECT_NEAR(placement.lever_mm, 15.0, kRoundOff);
        const mesh::CutSession bone_below = block(32.0, 40.0); // deeper than the blade
        placement = blade(bone_below);
        EXPECT_FALSE(bear_on_bone(placement, bone_below, std::vector { kBone }));
        EXPECT_EQ(placement.nodes.size(), all);
    }

    TEST(BladeBearing, ABladeTurnsToTheEndOfItsPlayOrUntilTheBladesMeet)
    {
        constexpr double kPlay = 15.0 * std::numbers::pi / 180.0;
        const HookPlacement first { .lever_mm = 25.0, .reach_mm = 40.0 }, second { .lever_mm = 10.0, .reach_mm = 30.0 };
        EXPECT_EQ(blade_turn(first, 0.0, kPlay), 0.0) << "between closed lips there is no room";
        EXPECT_NEAR(blade_turn(first, 40.0, kPlay), kPlay, kRoundOff);
        EXPECT_NEAR(40.0 * std::sin(blade_turn(first, 10.0, kPlay)), 5.0, kRoundOff) << "the ends meet";
        EXPECT_NEAR(behind_arm_mm(first, 40.0, kPlay), 25.0 * std::sin(kPlay), kRoundOff);
        EXPECT_EQ(blade_turn(HookPlacement {}, 40.0, kPlay), 0.0) << "a hook is no blade";
        for (const double arms : { 0.0, 3.0, 18.0, 22.0, 60.0 }) {
            const double apart = arms - behind_arm_mm(first, arms, kPlay) - behind_arm_mm(second, arms, kPlay);
            EXPECT_NEAR(opening_of_arms({ &first, &second }, apart, kPlay), arms, kRoundOff);
        }
        EXPECT_NEAR(opening_of_arms({ &first, &second }, 7.0, 0.0), 7.0, kRoundOff) << "without play";
    }

} // namespace blade_bearing_test
} // namespace retractor::planner
