#include "fem/statics/hooks_apart.h"

#include "fem/interactive/online_opening.h"
#include "fem/statics/nonlinear_region.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace retractor::fem {
namespace hooks_apart_test {

    using namespace test_support;

    constexpr double kMet = 2e-6; // mm: what rest_of_hooks_apart() leaves of a crossing, for patches of some 20 mm
    constexpr double kSettled = 1e-8; // mm, of hooks on springs of some N/mm

    TEST(HooksApart, HooksWithTissueBetweenThemDoNotFaceEachOther)
    {
        // A strip of 10 mm between two wounds, a hook on each of its sides: drawn apart, they stretch it.
        const mesh::TetMesh strip = mesh::kuhn_box(2, 4, 4, 5.0);
        std::vector<HookPatch> hooks(2);
        for (VertexId v = 0; v < static_cast<VertexId>(strip.vertex_count()); ++v) {
            if (strip.vertices(v, 0) == 0.0)
                hooks[0].nodes.push_back(v);
            if (strip.vertices(v, 0) == 10.0)
                hooks[1].nodes.push_back(v);
        }
        hooks[0].side = 1;
        hooks[1].side = -1;
        hooks[0].displacement = Vec3(-3.0, 0.0, 0.0);
        EXPECT_TRUE(facing_hooks(strip, hooks).empty());
        EXPECT_NO_THROW(check_hooks_apart(strip, hooks));
    }

    TEST(HooksApart, HooksThatTurnTogetherStayOnTheirSides)
    {
        // Two lips 1 mm apart that look at each other, and a frame that turns them both and draws them apart.
        mesh::TetMesh lips = mesh::kuhn_box(2, 4, 4, 5.0);
        const mesh::TetMesh other = lips;
        const auto first = static_cast<VertexId>(lips.vertices.rows());
        lips.vertices.conservativeResize(2 * first, 3);
        for (VertexId v = 0; v < first; ++v)
            lips.vertices.row(first + v) = other.vertices.row(v) + Vec3(11.0, 0.0, 0.0).transpose();
        for (const VertexId v : other.nodes)
            lips.nodes.push_back(first + v);
        lips.labels.insert(lips.labels.end(), other.labels.begin(), other.labels.end());
        std::vector<HookPatch> hooks(2);
        for (VertexId v = 0; v < 2 * first; ++v) {
            if (lips.vertices(v, 0) == 10.0)
                hooks[0].nodes.push_back(v);
            if (lips.vertices(v, 0) == 11.0)
                hooks[1].nodes.push_back(v);
        }
        hooks[0].side = 1;
        hooks[1].side = -1;
        const auto place = [&](double turn, double apart_mm) {
            const Mat3 R = Eigen::AngleAxisd(turn, Vec3(0.2, 0.3, 1.0).normalized()).toRotationMatrix();
            for (HookPatch& hook : hooks) {
                hook.rotation = R;
                hook.pivot = Vec3(10.5, 10.0, 10.0);
                hook.displacement = R * Vec3(-0.5 * hook.side * apart_mm, 0.0, 0.0);
            }
        };
        ASSERT_EQ(facing_hooks(lips, hooks).size(), 1U);
        for (const double turn : { 0.0, 0.5, 1.6, 3.0 }) {
            place(turn, 8.0);
            EXPECT_NO_THROW(check_hooks_apart(lips, hooks)) << turn;
            place(turn, -1.5); // through each other by 0.5 mm
            EXPECT_THROW(check_hooks_apart(lips, hooks), InputError) << turn;
        }
    }

    TEST(HooksApart, DrawnBackTheyGiveWayInTheirSharesAndSlideAlong)
    {
        const std::vector<FacingHooks> facing { { .a = 0, .b = 1, .normal = Vec3::UnitX(), .gap_mm = 1.0 } };
        std::vector<Vec3> moved { Vec3(5.0, 2.0, 0.0), Vec3(-1.0, 0.0, 3.0) }; // through each other by 5
        EXPECT_EQ(crossing_mm(facing[0], moved[0], moved[1]), 5.0);
        EXPECT_EQ(draw_back(facing, std::vector<double> { 1.0, 0.0 }, moved).size(), 1U);
        EXPECT_EQ(moved[0], Vec3(0.0, 2.0, 0.0));
        EXPECT_EQ(moved[1], Vec3(-1.0, 0.0, 3.0)) << "it stays";
        EXPECT_TRUE(draw_back(facing, std::vector<double> { 1.0, 0.0 }, moved).empty()) << "they touch";
        moved[0].x() = 4.0;
        EXPECT_EQ(draw_back(facing, std::vector<double> { 1.0, 3.0 }, moved).size(), 1U);
        EXPECT_EQ(moved[0].x(), 3.0);
        EXPECT_EQ(moved[1].x(), 2.0);
    }

    TEST(HooksApart, ForcesAgainstEachOtherPressTheHooksTogetherAndNoFarther)
    {
        // Springs of 2 and 3 N/mm, pushed by 10 N each over a gap of 1 mm: 5 mm and 3.3 mm if nothing were in the way.
        // Together they go where the springs take what the forces leave: 2 d_a + 3 d_b = 10 - 10, d_b = d_a - 1.
        Eigen::MatrixXd R = Eigen::MatrixXd::Zero(6, 6);
        R.diagonal() << 2.0, 2.0, 2.0, 3.0, 3.0, 3.0;
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(6);
        const std::vector<FacingHooks> facing {
            { .a = 0, .b = 1, .normal = Vec3::UnitX(), .gap_mm = 1.0, .round_off_mm = 1e-9 }
        };
        const auto rest = [&](const HookDrive& a, const HookDrive& b) {
            return rest_of_hooks_apart(R, none, { a, b }, facing);
        };
        const HookDrive pushed_a { .force_N = Vec3(10.0, 1.0, 0.0) }, pushed_b { .force_N = Vec3(-10.0, 0.0, 3.0) };
        RestApart apart = rest(pushed_a, pushed_b);
        ASSERT_TRUE(apart.rest.converged);
        EXPECT_EQ(apart.meeting.size(), 1U);
        EXPECT_LT((apart.rest.displacement.head<3>() - Vec3(0.6, 0.5, 0.0)).norm(), 100 * kSettled);
        EXPECT_LT((apart.rest.displacement.tail<3>() - Vec3(-0.4, 0.0, 1.0)).norm(), 100 * kSettled);
        // A hook that is held where it is does not give way; one that only draws as hard as 4 N does.
        const HookDrive held { .displacement = Vec3(-0.5, 0.0, 0.0) };
        apart = rest(pushed_a, held);
        EXPECT_NEAR(apart.rest.displacement[0], 0.5, 100 * kSettled);
        EXPECT_EQ(apart.rest.displacement[3], -0.5);
        const HookDrive limited { .displacement = Vec3(-0.5, 0.0, 0.0), .force_limit_N = 4.0 };
        apart = rest(pushed_a, limited); // 2 d_a + 3 d_b = 10 - 4
        EXPECT_TRUE(apart.rest.yielded[1]);
        EXPECT_NEAR(2.0 * apart.rest.displacement[0] + 3.0 * apart.rest.displacement[3], 6.0, 1e-5);
        EXPECT_NEAR(apart.rest.displacement[0] - apart.rest.displacement[3], 1.0, 100 * kSettled);
        // Apart, they do not see each other.
        apart = rest(pushed_b, pushed_a);
        EXPECT_TRUE(apart.meeting.empty());
        EXPECT_EQ(apart.rest.displacement, rest_of_hooks(R, none, { pushed_b, pushed_a }).displacement);
    }

    TEST(HooksApart, ManyHooksOfAllKindsDoNotPassThroughEachOther)
    {
        // Four pairs on tissue that joins them all, each facing its neighbours too.
        constexpr int kHooks = 8, kScenes = 40;
        std::srand(5);
        int met = 0;
        for (int scene = 0; scene < kScenes; ++scene) {
            SCOPED_TRACE(scene);
            const Eigen::MatrixXd a = Eigen::MatrixXd::Random(3 * kHooks, 3 * kHooks);
            const Eigen::MatrixXd R = a * a.transpose() + Eigen::MatrixXd::Identity(3 * kHooks, 3 * kHooks);
            std::vector<FacingHooks> facing;
            for (std::size_t i = 0; i < kHooks; i += 2)
                for (std::size_t j = 1; j < kHooks; j += 2)
                    if (std::max(i, j) - std::min(i, j) <= 3)
                        facing.push_back({ .a = i,
                            .b = j,
                            .normal = (Vec3::UnitX() + 0.2 * Vec3::Random()).normalized(),
                            .gap_mm = 0.3,
                            .round_off_mm = 1e-8 });
            std::vector<HookDrive> drives;
            for (int h = 0; h < kHooks; ++h) {
                HookDrive& drive = drives.emplace_back(HookDrive { .displacement = 3.0 * Vec3::Random() });
                switch ((h + scene) % 4) {
                case 0:
                    drive.force_N = 5.0 * Vec3::Random();
                    break;
                case 1:
                    drive.force_limit_N = 2.0;
                    break;
                case 2:
                    drive.grip_N_per_mm = 1.5;
                    break;
                default:
                    break;
                }
            }
            const RestApart apart = rest_of_hooks_apart(R, Eigen::VectorXd::Random(3 * kHooks), drives, facing);
            ASSERT_TRUE(apart.rest.converged);
            const std::vector<Vec3> moved = per_hook(apart.rest.displacement);
            for (const FacingHooks& pair : facing)
                EXPECT_LT(crossing_mm(pair, moved[pair.a], moved[pair.b]), kMet);
            for (const FacingHooks& pair : apart.meeting)
                EXPECT_GT(crossing_mm(pair, moved[pair.a], moved[pair.b]), -kMet) << "they hold each other: they touch";
            met += static_cast<int>(apart.meeting.size());
        }
        EXPECT_GT(met, kScenes);
    }

    /// A block on its back that is cut along the middle of its top, with a hook on each lip of the cut.
    struct HookedCut {
        mesh::CutSession session { mesh::kuhn_box(8, 8, 4, 4.0) };
        std::vector<Material> materials { test_support::material(1.0, 0.3), test_support::material(0.02, 0.4) };
        Supports supports;
        std::vector<OnlineHook> hooks { { .name = "left", .side = 1, .nodes = {}, .drive = {} },
            { .name = "right", .side = -1, .nodes = {}, .drive = {} } };
        double into_left = 0.0; ///< +1 or -1: the way along y from the wound into the left lip

        HookedCut()
        {
            const mesh::CutResult cut = session.cut({ .line = { Vec3(5.0, 16.0, 16.0), Vec3(27.0, 16.0, 16.0) },
                .directions = { -Vec3::UnitZ() },
                .depth_mm = 9.0 });
            EXPECT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
            for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
                if (session.has_vertex(v) && session.position(v).z() < 1e-9)
                    supports.fixed.push_back(v);
            for (const mesh::LipFace& lip : session.lips()) {
                const auto tet = session.tet(lip.face.tet).nodes;
                OnlineHook& hook = hooks[lip.side > 0 ? 0 : 1];
                for (const int corner : mesh::kTetFaces[static_cast<std::size_t>(lip.face.corner)])
                    hold(hook, tet[static_cast<std::size_t>(corner)]);
                if (lip.side > 0)
                    into_left += session.position(tet[static_cast<std::size_t>(lip.face.corner)]).y() - 16.0;
            }
            into_left = into_left > 0.0 ? 1.0 : -1.0;
        }

        void hold(OnlineHook& hook, VertexId v) const
        {
            const Vec3 p = session.position(v);
            if (std::abs(p.x() - 16.0) < 5.0 && p.z() > 9.0
                && std::find(hook.nodes.begin(), hook.nodes.end(), v) == hook.nodes.end())
                hook.nodes.push_back(v);
        }

        Vec3 left(double mm) const { return Vec3(0.0, mm * into_left, 0.0); }

        OnlineOpening opening(const HookDrive& of_left, const HookDrive& of_right)
        {
            OnlineOpening made(session, materials, supports, {});
            hooks[0].drive = of_left;
            hooks[1].drive = of_right;
            for (const OnlineHook& hook : hooks)
                (void)made.attach(hook);
            return made;
        }
    };

    /// Answered exactly and by the columns: the lips' hooks touch, and the answer is an equilibrium.
    void expect_meeting(OnlineOpening& opening)
    {
        constexpr double kResidual = 1e-8, kSame = 1e-6; // as answers promise; rest_of_hooks()
        OnlineAnswer exact = opening.answer();
        opening.complete(exact);
        ASSERT_EQ(exact.status, OnlineStatus::solved) << exact.message;
        ASSERT_EQ(exact.meeting.size(), 1U);
        EXPECT_LT(exact.residual, kResidual);
        EXPECT_NEAR(crossing_mm(exact.meeting[0], exact.hook_displacements[0], exact.hook_displacements[1]), 0.0, kMet);
        (void)opening.prepare_drag();
        const OnlineAnswer dragged = opening.drag_answer();
        EXPECT_EQ(dragged.meeting.size(), 1U);
        EXPECT_LE((dragged.displacement - exact.displacement).lpNorm<Eigen::Infinity>(),
            kSame * exact.displacement.lpNorm<Eigen::Infinity>());
    }

    TEST(HooksApart, OnlineHooksOfAllKindsStopWhereTheirLipsMeet)
    {
        HookedCut cut;
        // Both are drawn past each other, by 2 mm each.
        OnlineOpening opening = cut.opening({ .displacement = cut.left(-2.0) }, { .displacement = cut.left(2.0) });
        ASSERT_EQ(opening.facing_hooks().size(), 1U);
        expect_meeting(opening);
        EXPECT_LT(opening.answer().hook_displacements[0].norm(), kMet) << "both give way alike";
        // By forces of which the one is the stronger: they go on together.
        const HookDrive pushed { .force_N = cut.left(-0.6) }, weaker { .force_N = cut.left(0.2) };
        OnlineOpening forced = cut.opening(pushed, weaker);
        expect_meeting(forced);
        EXPECT_LT(forced.answer().hook_displacements[1].dot(cut.left(1.0)), -0.01);
        // At a limit, and through a soft grip, against a hook that is held.
        for (const HookDrive& drive : { HookDrive { .displacement = cut.left(-3.0), .force_limit_N = 0.5 },
                 HookDrive { .displacement = cut.left(-3.0), .grip_N_per_mm = 0.3 } }) {
            OnlineOpening held = cut.opening(drive, {});
            expect_meeting(held);
        }
        // Drawn apart, they are where they were told.
        OnlineOpening open = cut.opening({ .displacement = cut.left(2.0) }, { .displacement = cut.left(-2.0) });
        const OnlineAnswer apart = open.answer();
        EXPECT_TRUE(apart.meeting.empty());
        EXPECT_EQ(apart.hook_displacements[0], cut.left(2.0));
    }

    TEST(HooksApart, InNonlinearTissueTheyStopToo)
    {
        HookedCut cut;
        mesh::SlotMap map;
        const mesh::TetMesh mesh = cut.session.compact_mesh(&map);
        const auto compact = [&](std::vector<VertexId> ids) {
            for (VertexId& v : ids)
                v = map.compact_vertex[static_cast<std::size_t>(v)];
            return ids;
        };
        std::vector<HookPatch> patches;
        for (const OnlineHook& hook : cut.hooks)
            patches.push_back({ hook.name, hook.side, compact(hook.nodes) });
        NonlinearRegion field(mesh, cut.materials, { compact(cut.supports.fixed), {} }, patches,
            std::vector<std::uint8_t>(mesh.tet_count(), 1), { .elasticity = Elasticity::corotational_linear });
        const HookDrive pushed { .force_N = cut.left(-0.6) }, weaker { .force_N = cut.left(0.2) };
        const HookDrive through { .displacement = cut.left(-2.0) }, held {};
        for (const auto& drives : { std::vector { pushed, weaker }, std::vector { through, held } }) {
            (void)field.drag(drives);
            const NearFrame rest = field.settle();
            ASSERT_EQ(rest.status, NearStatus::settled) << rest.message;
            ASSERT_EQ(rest.meeting.size(), 1U);
            EXPECT_NEAR(
                crossing_mm(rest.meeting[0], rest.hook_displacements[0], rest.hook_displacements[1]), 0.0, kMet);
        }
        (void)field.drag(std::vector<HookDrive> { held, held });
        EXPECT_TRUE(field.settle().meeting.empty());
    }

} // namespace hooks_apart_test
} // namespace retractor::fem
