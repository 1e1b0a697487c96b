// Hooks in the surgery session: wounds that are opened, cut further while they are open, and closed again.

#include "fem/linear_algebra/sparse_cholesky.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "planner/approach/bearing_points.h"
#include "planner/session/surgery_session.h"
#include "planner/session/surgery_worker.h"
#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

namespace retractor::planner {
namespace wound_hooks_test {

    constexpr double kResidual = 1e-8; // what an answer promises
    // Two solvers on one mesh, relative to the largest displacement and force: what both promise.
    constexpr double kSameAnswer = 1e-6;
    // Positions of some 100 mm, a few operations each; also where a factor made on another thread, which comes sooner
    // or later, gives the same answer with other roundings.
    constexpr double kRoundingMm = 1e-10;
    constexpr int kPatience = 2400; // looks, 50 ms apart, for a factor that is made on another thread

    Touch at(SurgerySession& live_session, double x, double z)
    {
        const auto found = touch(*live_session.picture(), ray_down(x, z));
        if (!found)
            throw InputError("the ray misses the slab");
        return *found;
    }

    KnifeAnswer draw(
        SurgerySession& live_session, const Vec3& from, const Vec3& to, double depth_mm = 15.0, bool saws = false)
    {
        if (KnifeAnswer begun = live_session.begin_stroke(
                at(live_session, from.x(), from.z()), { .depth_mm = depth_mm, .cuts_bone = saws });
            !begun.done)
            return begun;
        const int points = std::max(1, static_cast<int>((to - from).norm() / 2.0));
        for (int i = 1; i <= points; ++i) {
            const Vec3 p = from + (to - from) * i / points;
            (void)live_session.draw_to(at(live_session, p.x(), p.z()));
        }
        return live_session.finish_stroke();
    }

    void settle(SurgerySession& live_session)
    {
        for (int i = 0; i < 1000 && live_session.moving(); ++i)
            live_session.relax(40.0);
        ASSERT_FALSE(live_session.moving());
    }

    /// What the plan's solver makes of the same hooks on the same mesh, from nothing.
    void expect_exact(SurgerySession& live_session)
    {
        settle(live_session);
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.refusal, "");
        EXPECT_LT(report.residual, kResidual);
        mesh::SlotMap map;
        const mesh::TetMesh mesh = live_session.session().compact_mesh(&map);
        SurgerySetup setup = layered_wall();
        fem::Supports supports;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (const Vec3 p = mesh.vertices.row(v); p.x() == 0.0 || p.x() == 120.0 || p.z() == 0.0 || p.z() == 120.0)
                supports.fixed.push_back(v);
        for (fem::Material& material : setup.materials)
            material.poissons_ratio = std::min(material.poissons_ratio, 0.45);
        std::vector<fem::HookPatch> patches;
        for (const HookState& hook : report.hooks) {
            fem::HookPatch patch { hook.name, hook.placement.side, {}, hook.displacement };
            for (const VertexId v : hook.placement.nodes)
                if (live_session.session().has_vertex(v))
                    patch.nodes.push_back(map.compact_vertex[static_cast<std::size_t>(v)]);
            patches.push_back(patch);
        }
        fem::Opening opening(
            mesh, setup.materials, supports, { .elasticity = fem::Elasticity::linear, .tolerance = 1e-10 });
        const fem::OpeningResult right = opening.open(patches);
        ASSERT_EQ(right.status, fem::OpeningStatus::converged) << right.message;
        const WallPicture& picture = *live_session.picture();
        double worst = 0.0;
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v) {
            const auto id = map.vertex_slot[v];
            worst = std::max(worst,
                (picture.shown.row(id) - picture.surface->rest.row(id)
                    - right.displacement.row(static_cast<Eigen::Index>(v)))
                    .norm());
        }
        EXPECT_LT(worst, kSameAnswer * right.displacement.rowwise().norm().maxCoeff());
        for (std::size_t h = 0; h < patches.size(); ++h)
            EXPECT_LT(
                (report.hooks[h].force_N - right.hook_forces_N[h]).norm(), kSameAnswer * right.hook_forces_N[h].norm());
        EXPECT_NEAR(report.strain.p99, right.strain_p99, 1e-6 * right.strain_p99);
    }

    /// A wound of 60 mm along x in the middle of the slab, with a hook on each lip in its middle.
    struct OpenWound {
        SurgerySession live_session;

        explicit OpenWound(SurgerySetup setup = layered_wall())
            : live_session(std::move(setup))
        {
            EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }).done);
            for (const double z : { 63.0, 57.0 }) {
                const KnifeAnswer placed = live_session.place_hook(at(live_session, 60.0, z));
                EXPECT_TRUE(placed.done) << placed.reason;
            }
        }
        void expect_exact() { wound_hooks_test::expect_exact(live_session); }
    };

    TEST(WoundHooks, AHookOnEachLipOpensTheWound)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        HookReport report = live_session.hooks();
        ASSERT_EQ(report.hooks.size(), 2U);
        EXPECT_EQ(report.hooks[0].name, "hook 1");
        EXPECT_EQ(report.hooks[0].placement.side, -report.hooks[1].placement.side);
        EXPECT_GT(report.hooks[0].placement.pull.z(), 0.99);
        EXPECT_LT(report.hooks[1].placement.pull.z(), -0.99);
        for (const HookState& hook : report.hooks) {
            EXPECT_GT(hook.placement.inward.y(), 0.99);
            for (const VertexId v : hook.placement.nodes) {
                const Vec3 p = live_session.session().position(v);
                EXPECT_LE(std::abs(p.x() - hook.placement.centre.x()), 5.0 + 1e-6);
                EXPECT_LE(p.y(), 15.0);
            }
        }
        EXPECT_LT(live_session.gape_mm(), kRoundingMm) << "hooks that pull by nothing open nothing";
        live_session.pull_all_hooks(4.0);
        EXPECT_TRUE(live_session.hooks_unsettled());
        EXPECT_GE(live_session.gape_mm(), 8.0 - kRoundingMm);
        wound.expect_exact();
        report = live_session.hooks();
        EXPECT_GT(report.side_N[0], 0.0);
        EXPECT_GT(report.hooks[0].force_N.z(), 0.0) << "the surgeon pulls outwards";
        EXPECT_LT(report.hooks[1].force_N.z(), 0.0);
        EXPECT_NEAR(report.side_N[0] / report.side_N[1], 1.0, 0.3) << "the slab is nearly symmetric";
        // By hand, one of them, and not straight.
        live_session.pull_hook(report.hooks[0].id, Vec3(2.0, -1.0, 7.0));
        wound.expect_exact();
        EXPECT_LT((live_session.hooks().hooks[0].displacement - Vec3(2.0, -1.0, 7.0)).norm(), kRoundingMm);
    }

    TEST(WoundHooks, FurtherCutsAndUndosFollowWhileTheWoundIsOpen)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(3.0);
        wound.expect_exact();
        // Away from the wound's edge, drawn on the open skin, and looked at after every step of the knife.
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 75.0, 68.0), { .depth_mm = 10.0 }).done);
        for (double z = 70.0; z <= 100.0; z += 5.0) {
            ASSERT_TRUE(live_session.draw_to(at(live_session, 75.0, z)).done);
            EXPECT_EQ(live_session.hooks().refusal, "");
            EXPECT_GE(live_session.gape_mm(), 6.0 - kRoundingMm);
            EXPECT_LT(live_session.hooks().residual, kResidual);
        }
        ASSERT_TRUE(live_session.finish_stroke().done);
        wound.expect_exact();
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 40.0 }, { 90.0, 0.0, 35.0 }, 20.0).done) << "far from any corridor";
        wound.expect_exact();
        live_session.pull_all_hooks(5.0);
        wound.expect_exact();
        live_session.undo();
        wound.expect_exact();
        live_session.undo();
        wound.expect_exact();
        live_session.redo();
        wound.expect_exact();
        // A stroke that is taken back.
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 30.0, 80.0), {}).done);
        for (double x = 32.0; x <= 60.0; x += 2.0)
            (void)live_session.draw_to(at(live_session, x, 80.0));
        live_session.abandon_stroke();
        wound.expect_exact();
    }

    TEST(WoundHooks, UndoingTheWoundTakesItsHooksOffAloud)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(3.0);
        live_session.undo();
        EXPECT_TRUE(live_session.hooks().hooks.empty());
        const std::string remark = live_session.take_remark();
        EXPECT_NE(remark.find("hook 1 has lost its tissue and was removed"), std::string::npos) << remark;
        EXPECT_NE(remark.find("hook 2"), std::string::npos) << remark;
        for (VertexId v = 0; v < static_cast<VertexId>(live_session.session().vertex_slots()); ++v)
            if (live_session.session().has_vertex(v)) {
                ASSERT_EQ(live_session.picture()->shown.row(v), live_session.picture()->surface->rest.row(v));
            }
        live_session.redo();
        EXPECT_EQ(live_session.gape_mm(), 0.0);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 60.0, 63.0)).done);
        EXPECT_EQ(live_session.hooks().hooks[0].name, "hook 3");
    }

    TEST(WoundHooks, APieceThatComesOffIsRefusedByNameUntilItIsUndone)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(2.0);
        settle(live_session);
        // A square through the whole slab.
        const std::array<Vec3, 5> corners { Vec3(20, 0, 80), Vec3(50, 0, 80), Vec3(50, 0, 105), Vec3(20, 0, 105),
            Vec3(20, 0, 80) };
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec3 way = (corners[i + 1] - corners[i]).normalized();
            ASSERT_TRUE(draw(live_session, corners[i] - 6.0 * way, corners[i + 1] + 6.0 * way, 40.0).done) << i;
        }
        const HookReport refused = live_session.hooks();
        EXPECT_NE(refused.refusal.find("has neither a support nor a hook"), std::string::npos) << refused.refusal;
        EXPECT_EQ(refused.hooks.size(), 2U);
        EXPECT_GE(live_session.gape_mm(), 4.0 - kRoundingMm) << "what is shown is the last answer";
        live_session.pull_all_hooks(3.0);
        EXPECT_NE(live_session.hooks().refusal, "");
        live_session.undo();
        wound.expect_exact();
        EXPECT_GE(live_session.gape_mm(), 6.0 - kRoundingMm);
    }

    TEST(WoundHooks, YieldAtTheForceThatIsGiven)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(5.0);
        const double unlimited = live_session.hooks().hooks[0].force_N.norm();
        live_session.set_yield(0.5 * unlimited);
        const HookReport report = live_session.hooks();
        EXPECT_TRUE(report.hooks[0].yielded);
        EXPECT_NEAR(report.hooks[0].force_N.norm(), 0.5 * unlimited, 1e-6 * unlimited);
        EXPECT_LT(report.hooks[0].displacement.z(), 5.0);
        wound.expect_exact();
        EXPECT_THROW(live_session.set_yield(-1.0), InputError);
        EXPECT_THROW(live_session.set_yield(std::numeric_limits<double>::quiet_NaN()), InputError);
        live_session.set_yield(std::numeric_limits<double>::infinity());
        EXPECT_NEAR(live_session.hooks().hooks[0].force_N.norm(), unlimited, 1e-6 * unlimited);
        EXPECT_FALSE(live_session.hooks().hooks[0].yielded);
    }

    TEST(WoundHooks, OneThatIsDrawnThroughAnotherStopsWhereTheirLipsMeet)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(4.0);
        EXPECT_EQ(live_session.hooks().meeting, "");
        const fem::HookId upper = live_session.hooks().hooks[0].id, lower = live_session.hooks().hooks[1].id;
        const auto moved = [&](std::size_t hook) { return live_session.hooks().hooks[hook].displacement; };
        live_session.pull_hook(lower, Vec3(2.0, 0.0, 9.0));
        EXPECT_LT((moved(0) - Vec3(0.0, 0.0, 4.0)).norm(), kRoundingMm) << "the other one stays";
        EXPECT_NEAR(moved(1).z(), 4.0, 0.2) << "the lips are as good as straight";
        EXPECT_NEAR(moved(1).x(), 2.0, 0.2) << "it slides along the other lip";
        EXPECT_EQ(live_session.hooks().meeting, "hook 1 and hook 2");
        wound.expect_exact();
        EXPECT_EQ(live_session.hooks().meeting, "hook 1 and hook 2");
        // Cuts elsewhere, undone and done again, change nothing of it.
        const Vec3 met = moved(1);
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 30.0 }, { 90.0, 0.0, 30.0 }).done);
        wound.expect_exact();
        live_session.undo();
        live_session.redo();
        wound.expect_exact();
        EXPECT_LT((moved(1) - met).norm(), kRoundingMm);
        // The hand goes back; nothing of what it had asked for is left.
        live_session.pull_hook(lower, Vec3(0.0, 0.0, 2.0));
        EXPECT_LT((moved(1) - Vec3(0.0, 0.0, 2.0)).norm(), kRoundingMm);
        EXPECT_EQ(live_session.hooks().meeting, "");
        live_session.pull_hook(upper, Vec3(0.0, 0.0, -9.0));
        EXPECT_NEAR(moved(0).z(), 2.0, 0.2);
        // Both by the slider: where none is in the way.
        live_session.pull_all_hooks(3.0);
        EXPECT_EQ(live_session.hooks().meeting, "");
        // Pushed together, both give way.
        live_session.pull_all_hooks(-3.0);
        EXPECT_EQ(live_session.hooks().meeting, "hook 1 and hook 2");
        EXPECT_NEAR(moved(0).z(), 0.0, 0.2);
        EXPECT_NEAR(moved(1).z(), 0.0, 0.2);
        // One that may slip stops there, too.
        live_session.pull_all_hooks(1.0);
        live_session.set_yield(1e3);
        live_session.pull_hook(lower, Vec3(0.0, 0.0, 9.0));
        EXPECT_NEAR(moved(1).z(), 1.0, 0.2);
        EXPECT_EQ(live_session.hooks().meeting, "hook 1 and hook 2");
    }

    TEST(WoundHooks, ALipThatIsDrawnThroughTheOtherIsSaidToOverlapIt)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }).done);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 60.0, 57.0)).done);
        const fem::HookId hook = live_session.hooks().hooks[0].id;
        live_session.pull_hook(hook, Vec3(0.0, 0.0, -5.0));
        EXPECT_LT(live_session.hooks().lip_overlap_mm, 0.5) << "opened";
        // No hook stands in its way on the other lip, whose tissue follows as little as the wound is long.
        live_session.pull_hook(hook, Vec3(1.0, 0.0, 5.0));
        EXPECT_EQ(live_session.hooks().meeting, "");
        EXPECT_GT(live_session.hooks().lip_overlap_mm, 2.0);
        EXPECT_LE(live_session.hooks().lip_overlap_mm, live_session.gape_mm());
        live_session.pull_hook(hook, Vec3::Zero());
        EXPECT_LT(live_session.hooks().lip_overlap_mm, kRoundingMm);
    }

    TEST(WoundHooks, TensionIsSetFreeUnderHooksTooAndSpringsTakeOverWithoutThem)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 40.0).done);
        live_session.set_tension(0.04);
        settle(live_session);
        const double springs = live_session.gape_mm();
        ASSERT_GT(springs, 1.0);
        // One hook that is let go where the lip rests on its own: what springs and elements make of the tension.
        ASSERT_TRUE(live_session.place_hook(at(live_session, 35.0, 62.0 + 0.5 * springs)).done);
        settle(live_session);
        EXPECT_EQ(live_session.hooks().hooks.size(), 1U);
        EXPECT_GT(live_session.hooks().hooks[0].displacement.z(), 0.1) << "it takes the lip where it lies";
        EXPECT_NEAR(live_session.gape_mm() / springs, 1.0, 0.4)
            << "one is held near its end; springs know no nu of 0.45";
        live_session.set_tension(0.02);
        settle(live_session);
        EXPECT_EQ(live_session.hooks().hooks.size(), 1U);
        const double half = live_session.gape_mm();
        EXPECT_LT(half, springs);
        live_session.set_tension(0.04);
        settle(live_session);
        EXPECT_GT(live_session.gape_mm(), half);
        live_session.take_off_hooks();
        settle(live_session);
        EXPECT_TRUE(live_session.hooks().hooks.empty());
        EXPECT_NEAR(live_session.gape_mm() / springs, 1.0, 0.1) << "springs again, from the start";
    }

    TEST(WoundHooks, ThePlannedOnesAreTakenWhereALipLiesUnderThem)
    {
        SurgerySetup setup = layered_wall();
        setup.approach.incision = { { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 } };
        setup.approach.directions.assign(2, Vec3::UnitY());
        setup.approach.depth_mm = 20.0;
        // Left of a blade that goes along x and down y is -z or +z: told by the way the hooks pull.
        for (const double pull : { 1.0, -1.0 })
            for (const double along : { 20.0, 100.0 })
                setup.approach.hooks.push_back({ .name = (pull > 0.0 ? "left " : "right ") + std::to_string(int(along)),
                    .side = pull > 0.0 ? 1 : -1,
                    .along_mm = along,
                    .depth_mm = 8.0,
                    .direction = pull * Vec3::UnitZ(),
                    .opening_mm = 6.0 });
        SurgerySession live_session(std::move(setup));
        EXPECT_NE(live_session.take_planned_hooks().reason.find("cut first"), std::string::npos);
        ASSERT_TRUE(draw(live_session, { 70.0, 0.0, 60.5 }, { 32.0, 0.0, 59.5 }, 20.0).done)
            << "the other way, and shorter";
        const KnifeAnswer taken = live_session.take_planned_hooks();
        ASSERT_TRUE(taken.done);
        EXPECT_NE(taken.reason.find("hook 'left 100'"), std::string::npos) << taken.reason;
        EXPECT_NE(taken.reason.find("hook 'right 100'"), std::string::npos) << taken.reason;
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.hooks.size(), 2U);
        EXPECT_EQ(report.hooks[0].name, "left 20");
        EXPECT_LT((report.hooks[0].displacement - Vec3(0.0, 0.0, 6.0)).norm(), kRoundingMm);
        for (const HookState& hook : report.hooks)
            for (const VertexId v : hook.placement.nodes) // the lip that faces the other one
                EXPECT_NEAR(live_session.picture()->shown(v, 2) - live_session.picture()->surface->rest(v, 2),
                    6.0 * hook.placement.pull.z(), kRoundingMm);
        EXPECT_GE(live_session.gape_mm(), 12.0 - kRoundingMm);

        // Hooks that were moved by hand go back to their plan.
        live_session.pull_all_hooks(1.0);
        EXPECT_TRUE(live_session.take_planned_hooks().done);
        ASSERT_EQ(live_session.hooks().hooks.size(), 2U);
        EXPECT_LT((live_session.hooks().hooks[0].displacement - Vec3(0.0, 0.0, 6.0)).norm(), kRoundingMm);
        live_session.take_off_hook(report.hooks[0].id);
        EXPECT_TRUE(live_session.take_planned_hooks().done) << "the one that was taken off";
        EXPECT_EQ(live_session.hooks().hooks.size(), 2U);
        live_session.take_off_hooks();
        live_session.set_tension(0.04);
        const std::string unlike = live_session.take_planned_hooks().reason;
        EXPECT_NE(unlike.find("Here the tissue is under 4 % tension, in the plan under no tension"), std::string::npos)
            << unlike;
    }

    TEST(WoundHooks, AsPlannedAHookStopsAtOneThatIsInItsWay)
    {
        SurgerySession live_session(wall_with_planned_hooks({}, 8.0));
        ASSERT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 20.0).done);
        ASSERT_TRUE(
            live_session.place_hook(at(live_session, 60.0, 57.0)).done); // where one of the planned ones would hold
        live_session.pull_hook(live_session.hooks().hooks[0].id, Vec3(0.0, 0.0, 10.0));
        const KnifeAnswer taken = live_session.take_planned_hooks();
        ASSERT_TRUE(taken.done) << taken.reason;
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.hooks.size(), 2U) << taken.reason;
        EXPECT_LT((report.hooks[0].displacement - Vec3(0.0, 0.0, 10.0)).norm(), kRoundingMm);
        EXPECT_NEAR(report.hooks[1].displacement.z(), 10.0, 0.2) << "planned: 6 mm, where the other hook's lip is now";
        EXPECT_NE(report.meeting.find("hook 1 and "), std::string::npos) << report.meeting;
    }

    constexpr double kAtForce = 1e-6; // of a force: rest_of_hooks() keeps to limits so far

    /// A wound along the planned line, opened by two planned hooks that go 6 mm and are driven so besides.
    struct PlannedWound {
        SurgerySession live_session;

        explicit PlannedWound(const HookPull& pull)
            : live_session(wall_with_planned_hooks(pull, 8.0))
        {
            EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 20.0).done);
            const KnifeAnswer taken = live_session.take_planned_hooks();
            EXPECT_TRUE(taken.done) << taken.reason;
            EXPECT_EQ(taken.reason, "");
        }
        std::vector<HookState> hooks() const { return live_session.hooks().hooks; }
        double force_N(std::size_t hook) const { return hooks()[hook].force_N.norm(); }
        double way_mm(std::size_t hook) const { return hooks()[hook].displacement.norm(); }
    };

    TEST(WoundHooks, PlannedOnesThatPullWithAForceBearItAndGoAsFarAsItTakesThem)
    {
        constexpr double kForceN = 3.0;
        PlannedWound wound({ .force_N = kForceN });
        SurgerySession& live_session = wound.live_session;
        expect_exact(live_session);
        const double way = wound.way_mm(0);
        EXPECT_GT(way, 0.5);
        for (const HookState& hook : wound.hooks()) {
            EXPECT_LT((hook.force_N - kForceN * hook.placement.pull).norm(), kAtForce * kForceN) << hook.name;
            EXPECT_GT(hook.displacement.dot(hook.placement.pull), 0.0) << hook.name;
            EXPECT_FALSE(hook.yielded);
        }
        // The slider: half the force goes half the way, in linear tissue.
        live_session.pull_hooks_by_share(0.5);
        expect_exact(live_session);
        EXPECT_NEAR(wound.force_N(0), 0.5 * kForceN, kAtForce * kForceN);
        EXPECT_NEAR(wound.way_mm(0), 0.5 * way, kAtForce * way);
        EXPECT_EQ(share_of_plan(wound.hooks()), 0.5);
        live_session.pull_hooks_by_share(1.0);
        EXPECT_NEAR(wound.way_mm(0), way, kAtForce * way);
        // A lip that is cut behind gives way to the same force; undone, it is as before.
        ASSERT_TRUE(draw(live_session, { 30.0, 0.0, 78.0 }, { 90.0, 0.0, 78.0 }, 20.0).done);
        expect_exact(live_session);
        EXPECT_NEAR(wound.force_N(0), kForceN, kAtForce * kForceN);
        EXPECT_GT(wound.way_mm(0), 1.05 * way);
        live_session.undo();
        expect_exact(live_session);
        EXPECT_NEAR(wound.way_mm(0), way, kAtForce * way);
        // The same on a solver that is made anew.
        live_session.set_tension(0.02);
        settle(live_session);
        EXPECT_NEAR(wound.force_N(0), kForceN, kAtForce * kForceN);
        EXPECT_EQ(share_of_plan(wound.hooks()), 1.0);
    }

    TEST(WoundHooks, AForceYieldsToTheLimitOfAllHooksAndIsLetGoOfInTheHand)
    {
        constexpr double kForceN = 3.0, kLimitN = 2.0;
        PlannedWound wound({ .force_N = kForceN });
        SurgerySession& live_session = wound.live_session;
        live_session.set_yield(kLimitN);
        EXPECT_NEAR(wound.force_N(0), kLimitN, kAtForce * kLimitN);
        EXPECT_TRUE(wound.hooks()[0].yielded);
        live_session.set_yield(std::numeric_limits<double>::infinity());
        EXPECT_NEAR(wound.force_N(0), kForceN, kAtForce * kForceN);
        EXPECT_FALSE(wound.hooks()[0].yielded);
        // One of them is drawn by hand: it goes where that is, and the slider drives the other.
        const Vec3 hand(0.5, 0.0, 4.0);
        live_session.pull_hook(wound.hooks()[0].id, hand);
        EXPECT_LT((wound.hooks()[0].displacement - hand).norm(), kRoundingMm);
        live_session.pull_hooks_by_share(0.25);
        expect_exact(live_session);
        EXPECT_LT((wound.hooks()[0].displacement - hand).norm(), kRoundingMm);
        EXPECT_NEAR(wound.force_N(1), 0.25 * kForceN, kAtForce * kForceN);
        EXPECT_THROW(live_session.pull_hooks_by_share(std::numeric_limits<double>::quiet_NaN()), InputError);
        // Drawn alike, by millimetres, none is left of its plan.
        live_session.pull_all_hooks(5.0);
        EXPECT_NEAR(wound.way_mm(1), 5.0, kRoundingMm);
        EXPECT_FALSE(share_of_plan(wound.hooks()).has_value());
    }

    TEST(WoundHooks, AForceStopsWhereAHookThatIsHeldIsInItsWay)
    {
        constexpr double kForceN = 3.0;
        PlannedWound wound({ .force_N = kForceN });
        SurgerySession& live_session = wound.live_session;
        const Vec3 pull = wound.hooks()[0].placement.pull;
        const auto between_mm
            = [&] { return (wound.hooks()[0].displacement - wound.hooks()[1].displacement).dot(pull); };
        // Drawn into the other one, that pulls with its force, it stops where that is.
        const double way = wound.way_mm(1);
        live_session.pull_hook(wound.hooks()[0].id, -20.0 * pull);
        EXPECT_GT(wound.hooks()[0].displacement.dot(pull), -1.5 * way);
        EXPECT_GT(between_mm(), -0.2) << "the lips are as good as straight";
        EXPECT_NE(live_session.hooks().meeting, "");
        // Let go of, the other one is on its way back to the closed wound: it stops at the one that is held.
        const Vec3 held = wound.hooks()[0].displacement;
        live_session.pull_hooks_by_share(0.0);
        settle(live_session);
        EXPECT_LT((wound.hooks()[0].displacement - held).norm(), kRoundingMm);
        EXPECT_NEAR(between_mm(), 0.0, 0.2);
        EXPECT_NE(live_session.hooks().meeting, "");
        EXPECT_LT(live_session.hooks().residual, kResidual);
        // Out of its way, it goes there.
        live_session.pull_hook(wound.hooks()[0].id, 2.0 * pull);
        EXPECT_LT(wound.force_N(1), kAtForce * kForceN);
        EXPECT_GT(between_mm(), 0.5);
        EXPECT_EQ(live_session.hooks().meeting, "");
    }

    TEST(WoundHooks, PlannedOnesYieldAtTheirOwnLimit)
    {
        const double free_N = PlannedWound({}).force_N(0), limit_N = 0.6 * free_N;
        PlannedWound wound({ .force_limit_N = limit_N });
        SurgerySession& live_session = wound.live_session;
        expect_exact(live_session);
        for (std::size_t h = 0; h < 2; ++h) {
            EXPECT_TRUE(wound.hooks()[h].yielded) << h;
            EXPECT_NEAR(wound.force_N(h), limit_N, kAtForce * limit_N);
            EXPECT_LT(wound.way_mm(h), 5.0);
        }
        // In the hand, too; where it draws less far than that takes, it holds.
        live_session.pull_all_hooks(8.0);
        EXPECT_NEAR(wound.force_N(0), limit_N, kAtForce * limit_N);
        live_session.pull_all_hooks(2.0);
        EXPECT_FALSE(wound.hooks()[0].yielded);
        EXPECT_NEAR(wound.way_mm(0), 2.0, kRoundingMm);
        // Of two limits the lower one holds.
        live_session.pull_all_hooks(8.0);
        live_session.set_yield(0.5 * limit_N);
        EXPECT_NEAR(wound.force_N(0), 0.5 * limit_N, kAtForce * limit_N);
        live_session.set_yield(2.0 * limit_N);
        EXPECT_NEAR(wound.force_N(0), limit_N, kAtForce * limit_N);
    }

    TEST(WoundHooks, ALipFollowsAPlannedOneThatGripsSoftlyByItsGrip)
    {
        constexpr double kGrip = 1.0; // N/mm
        PlannedWound wound({ .grip_N_per_mm = kGrip });
        expect_exact(wound.live_session);
        for (const HookState& hook : wound.hooks()) {
            const Vec3 left = 6.0 * hook.placement.pull - hook.displacement;
            EXPECT_GT(left.norm(), 0.1) << hook.name;
            EXPECT_LT((hook.force_N - kGrip * left).norm(), kAtForce * hook.force_N.norm()) << hook.name;
            EXPECT_FALSE(hook.yielded);
        }
    }

    RetractorKind small_retractor()
    {
        return { .kind = "small",
            .meaning = "for tests",
            .blade_width_mm = 20.0,
            .blade_depth_mm = 12.0,
            .deepest_blade_mm = 12.0,
            .greatest_opening_mm = 30.0,
            .source = "ours" };
    }

    /// A wound of 60 mm off the middle, so that one lip is stiffer, with a retractor in its middle.
    SurgerySession wound_with_retractor(double z = 45.0)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, z }, { 90.0, 0.0, z }).done);
        const KnifeAnswer placed = live_session.place_retractor(at(live_session, 60.0, z + 3.0), small_retractor());
        EXPECT_TRUE(placed.done) << placed.reason;
        return live_session;
    }

    TEST(WoundHooks, ARetractorIsCrankedAndLiesWhereItsBladesBearTheSameForce)
    {
        SurgerySession live_session = wound_with_retractor();
        HookReport report = live_session.hooks();
        ASSERT_EQ(report.retractors.size(), 1U);
        ASSERT_EQ(report.hooks.size(), 2U);
        EXPECT_EQ(report.hooks[0].name, "upper blade");
        EXPECT_EQ(report.hooks[1].name, "lower blade");
        EXPECT_LT((report.hooks[0].placement.pull + report.hooks[1].placement.pull).norm(), 1e-12);
        EXPECT_NEAR(report.retractors[0].opening_mm, 0.0, kRoundingMm);
        live_session.crank(report.hooks[1].id, 12.0);
        settle(live_session);
        report = live_session.hooks();
        const RetractorState& retractor = report.retractors.at(0);
        EXPECT_EQ(retractor.opening_mm, 12.0);
        EXPECT_LE(retractor.imbalance, RackBalance::kTolerance);
        const Vec3 &first = report.hooks[0].displacement, &second = report.hooks[1].displacement;
        EXPECT_NEAR(first.z() - second.z(), 12.0, 1e-9) << "the rack is rigid";
        EXPECT_GT(first.z(), -second.z() + 0.1) << "the lip nearer to the held side gives way less";
        EXPECT_NEAR(report.hooks[0].force_N.z(), retractor.force_N, RackBalance::kTolerance * retractor.force_N);
        EXPECT_NEAR(report.hooks[1].force_N.z(), -retractor.force_N, RackBalance::kTolerance * retractor.force_N);
        expect_exact(live_session); // with blades at these places, it is what the plan's solver finds
        // Twice as far, twice the force: linear tissue.
        live_session.crank(report.hooks[0].id, 24.0);
        settle(live_session);
        EXPECT_NEAR(live_session.hooks().retractors[0].force_N, 2.0 * retractor.force_N,
            2.0 * RackBalance::kTolerance * retractor.force_N);
        live_session.crank(report.hooks[0].id, 500.0);
        EXPECT_EQ(live_session.hooks().retractors[0].opening_mm, 30.0) << "no farther than the instrument goes";
        EXPECT_THROW(live_session.crank(report.hooks[0].id, std::numeric_limits<double>::quiet_NaN()), InputError);
    }

    TEST(WoundHooks, DeeperBladesAreTakenOnlyToReachBone)
    {
        const auto reach = [](double deepest_mm) {
            SurgerySession live_session(layered_wall()); // without bone
            EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 45.0 }, { 90.0, 0.0, 45.0 }).done);
            RetractorKind kind = small_retractor();
            kind.deepest_blade_mm = deepest_mm;
            EXPECT_TRUE(live_session.place_retractor(at(live_session, 60.0, 48.0), kind).done);
            return live_session.hooks().hooks.at(0).placement.reach_mm;
        };
        EXPECT_EQ(reach(24.0), reach(12.0));
    }

    TEST(WoundHooks, ABladeThatIsDraggedCranksAndTakenOffTakesTheOtherWithIt)
    {
        SurgerySession live_session = wound_with_retractor();
        const fem::HookId upper = live_session.hooks().hooks[0].id;
        live_session.pull_hook(upper, Vec3(3.0, -2.0, 5.0)); // what is not along the rack does nothing
        HookReport report = live_session.hooks();
        EXPECT_NEAR(report.retractors[0].opening_mm, 10.0, 1e-9);
        const Vec3 force = report.hooks[0].force_N;
        EXPECT_LT((force - force.dot(Vec3::UnitZ()) * Vec3::UnitZ()).norm(), 1e-6 * force.norm())
            << "tissue slides along the blade";
        live_session.pull_all_hooks(4.0);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 8.0, 1e-9);
        EXPECT_TRUE(live_session.place_hook(at(live_session, 40.0, 48.0)).done);
        for (const KnifeAnswer& again : { live_session.place_hook(at(live_session, 60.0, 50.0)),
                 live_session.place_retractor(at(live_session, 45.0, 48.0), small_retractor()) }) {
            EXPECT_FALSE(again.done);
            EXPECT_NE(again.reason.find("already holds"), std::string::npos) << again.reason;
        }
        live_session.take_off_hook(upper);
        report = live_session.hooks();
        EXPECT_TRUE(report.retractors.empty());
        ASSERT_EQ(report.hooks.size(), 1U);
        EXPECT_EQ(report.hooks[0].name, "hook 1");
    }

    TEST(WoundHooks, ARetractorFollowsCutsAndIsInBalanceAfterThem)
    {
        SurgerySession live_session = wound_with_retractor();
        live_session.crank(live_session.hooks().hooks[0].id, 10.0);
        settle(live_session);
        const double before_N = live_session.hooks().retractors.at(0).force_N;
        EXPECT_TRUE(draw(live_session, { 90.0, 0.0, 45.0 }, { 100.0, 0.0, 45.0 }).done);
        settle(live_session);
        HookReport report = live_session.hooks();
        ASSERT_EQ(report.retractors.size(), 1U);
        EXPECT_EQ(report.retractors[0].opening_mm, 10.0);
        EXPECT_LT(report.retractors[0].force_N, before_N) << "a longer cut opens more easily";
        EXPECT_LE(report.retractors[0].imbalance, RackBalance::kTolerance);
        live_session.set_nonlinear(true);
        for (int i = 0; i < kPatience && (live_session.moving() || live_session.hooks_unsettled()); ++i) {
            live_session.relax(40.0);
            if (live_session.waiting())
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        report = live_session.hooks();
        EXPECT_EQ(report.shown, ShownAnswer::nonlinear) << report.shown_text;
        EXPECT_LE(report.retractors.at(0).imbalance, RackBalance::kTolerance);
    }

    TEST(WoundHooks, OfACutThroughTheWallOnlyTheOuterEdgesHoldARetractor)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 2.0 * kSlabThicknessMm).done);
        const auto from_inside
            = touch(*live_session.picture(), { { 60.0, 2.0 * kSlabThicknessMm, 63.0 }, -Vec3::UnitY() });
        ASSERT_TRUE(from_inside.has_value());
        ASSERT_NEAR(from_inside->rest.y(), kSlabThicknessMm, 1e-9);
        EXPECT_FALSE(live_session.place_retractor(*from_inside, small_retractor()).done) << "20 mm around the edge";
        ASSERT_TRUE(live_session.place_retractor(at(live_session, 60.0, 63.0), small_retractor()).done);
        for (const HookState& blade : live_session.hooks().hooks) {
            EXPECT_GT(blade.placement.inward.y(), 0.99);
            EXPECT_LT(blade.placement.centre.y(), 0.5 * kSlabThicknessMm);
        }
    }

    TEST(WoundHooks, ABladeThatIsDraggedLandsWhereItWasDraggedTo)
    {
        SurgerySession live_session = wound_with_retractor(35.0); // the lower lip is much stiffer
        const fem::HookId upper = live_session.hooks().hooks[0].id;
        live_session.crank(upper, 10.0);
        settle(live_session);
        for (const double wanted_mm : { 8.0, 8.5, 9.0 }) {
            live_session.pull_hook(upper, Vec3(0.0, 0.0, wanted_mm));
            settle(live_session);
            EXPECT_NEAR(live_session.hooks().hooks[0].displacement.z(), wanted_mm, 0.3);
        }
    }

    TEST(WoundHooks, StepsOfTheHooksAreUndoneAndRedoneAmongTheCuts)
    {
        constexpr double kBackMm = 0.3; // a retractor floats until its blades bear the same force to a few hundredths
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(draw(live_session, { 20.0, 0.0, 85.0 }, { 90.0, 0.0, 85.0 }).done);
        ASSERT_TRUE(live_session.place_retractor(at(live_session, 55.0, 88.0), small_retractor()).done);
        for (const double opening_mm : { 4.0, 6.0, 10.0 }) // notches of the wheel: one step
            live_session.crank(live_session.hooks().hooks[0].id, opening_mm);
        settle(live_session);
        EXPECT_TRUE(draw(live_session, { 20.0, 0.0, 35.0 }, { 90.0, 0.0, 35.0 }).done);
        const KnifeAnswer placed = live_session.place_hook(at(live_session, 55.0, 38.0));
        ASSERT_TRUE(placed.done) << placed.reason;
        const Vec3 where_set = live_session.hooks().hooks[2].displacement;
        live_session.pull_hook(live_session.hooks().hooks[2].id, Vec3(0.0, 0.0, 3.0));
        live_session.pull_hook(live_session.hooks().hooks[2].id, Vec3(0.0, 0.0, 5.0));
        live_session.take_off_hook(live_session.hooks().hooks[0].id);
        settle(live_session);
        ASSERT_EQ(live_session.hooks().hooks.size(), 1U);
        const auto undo = [&](const std::string& what) {
            EXPECT_EQ(live_session.step_to_undo(), what);
            live_session.undo_step();
            settle(live_session);
            return live_session.hooks();
        };
        const HookReport all = undo("taking off the upper blade");
        ASSERT_EQ(all.retractors.size(), 1U);
        EXPECT_NEAR(all.retractors[0].opening_mm, 10.0, 1e-9);
        EXPECT_EQ(undo("moving the hook 1").hooks.size(), 3U);
        EXPECT_LT((live_session.hooks().hooks[0].displacement - where_set).norm(), kBackMm);
        EXPECT_EQ(undo("setting the hook").hooks.size(), 2U);
        EXPECT_EQ(undo("cut").hooks.size(), 2U);
        const HookReport cranked = live_session.hooks();
        EXPECT_NEAR(cranked.retractors[0].opening_mm, 10.0, 1e-9);
        EXPECT_LT(undo("cranking the retractor").retractors[0].opening_mm, 1.0);
        EXPECT_TRUE(undo("setting the retractor").hooks.empty());
        EXPECT_TRUE(undo("cut").hooks.empty());
        EXPECT_EQ(live_session.step_to_undo(), "");
        for (const char* const what : { "cut", "setting the retractor", "cranking the retractor", "cut",
                 "setting the hook", "moving the hook 1", "taking off the upper blade" }) {
            EXPECT_EQ(live_session.step_to_redo(), what);
            live_session.redo_step();
            settle(live_session);
            if (std::string(what) == "moving the hook 1")
                for (const HookState& hook : live_session.hooks().hooks) {
                    const auto then = std::ranges::find(all.hooks, hook.name, &HookState::name);
                    ASSERT_NE(then, all.hooks.end()) << hook.name;
                    EXPECT_LT((hook.displacement - then->displacement).norm(), kBackMm) << hook.name;
                }
        }
        EXPECT_EQ(live_session.step_to_redo(), "");
        EXPECT_EQ(live_session.hooks().hooks.size(), 1U);
    }

    TEST(WoundHooks, ANewStepTakesThePlaceOfThoseThatWereUndone)
    {
        SurgerySession live_session = wound_with_retractor(60.0);
        live_session.crank(live_session.hooks().hooks[0].id, 6.0);
        live_session.undo_step();
        live_session.crank(live_session.hooks().hooks[0].id, 3.0);
        EXPECT_EQ(live_session.step_to_redo(), "");
        live_session.undo(); // the cut at once, as the list of cuts does
        settle(live_session);
        EXPECT_EQ(live_session.step_to_undo(), "");
        EXPECT_TRUE(live_session.hooks().hooks.empty());
        live_session.redo();
        settle(live_session);
        EXPECT_EQ(live_session.step_to_redo(), "setting the retractor");
        live_session.redo_step();
        live_session.redo_step();
        settle(live_session);
        ASSERT_EQ(live_session.hooks().retractors.size(), 1U);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 3.0, 1e-9);
        live_session.pull_hook(live_session.hooks().hooks[1].id, Vec3(0.0, 0.0, -2.0));
        EXPECT_EQ(live_session.step_to_undo(), "cranking the retractor") << "by its other blade";
        live_session.undo_step();
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 0.0, 0.5) << "one step";
    }

    TEST(WoundHooks, HooksThatACutTakesOffComeBackWithItsUndo)
    {
        SurgerySession live_session = wound_with_retractor(60.0);
        live_session.crank(live_session.hooks().hooks[0].id, 6.0);
        settle(live_session);
        constexpr int kLayers = 4; // of the wall, at most
        for (int layer = 0; layer < kLayers && !live_session.hooks().retractors.empty(); ++layer) {
            const KnifeAnswer taken = live_session.take_out(at(live_session, 60.0, 68.0), 30.0);
            ASSERT_TRUE(taken.done) << taken.reason;
            settle(live_session);
        }
        ASSERT_TRUE(live_session.hooks().retractors.empty()) << "its lip is gone";
        EXPECT_EQ(live_session.step_to_undo(), "cut");
        live_session.undo_step();
        settle(live_session);
        ASSERT_EQ(live_session.hooks().retractors.size(), 1U);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 6.0, 1e-9);
        live_session.redo_step();
        EXPECT_TRUE(live_session.hooks().retractors.empty());
    }

    TEST(WoundHooks, UndoingTheCutTakesItsRetractorOffAndLeavesTheOthers)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(draw(live_session, { 20.0, 0.0, 85.0 }, { 90.0, 0.0, 85.0 }).done);
        EXPECT_TRUE(draw(live_session, { 20.0, 0.0, 35.0 }, { 90.0, 0.0, 35.0 }).done);
        for (const double z : { 88.0, 38.0 })
            ASSERT_TRUE(live_session.place_retractor(at(live_session, 55.0, z), small_retractor()).done);
        ASSERT_EQ(live_session.hooks().retractors.size(), 2U);
        EXPECT_EQ(live_session.hooks().hooks[2].name, "upper blade 2");
        live_session.pull_all_hooks(3.0);
        settle(live_session);
        for (const RetractorState& retractor : live_session.hooks().retractors) {
            EXPECT_NEAR(retractor.opening_mm, 6.0, 1e-9);
            EXPECT_LE(retractor.imbalance, RackBalance::kTolerance);
        }
        (void)live_session.take_remark();
        live_session.undo();
        settle(live_session);
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.retractors.size(), 1U);
        ASSERT_EQ(report.hooks.size(), 2U);
        EXPECT_EQ(report.hooks[0].name, "upper blade");
        EXPECT_EQ(live_session.take_remark(), "the small retractor has lost its tissue and was removed");
        // Taken off and set again, it has a name of its own.
        live_session.redo();
        ASSERT_TRUE(live_session.place_retractor(at(live_session, 55.0, 38.0), small_retractor()).done);
        EXPECT_EQ(live_session.hooks().hooks[2].name, "upper blade 3");
    }

    TEST(WoundHooks, ARetractorStaysWhenTheTensionIsChanged)
    {
        SurgerySession live_session = wound_with_retractor();
        live_session.crank(live_session.hooks().hooks[0].id, 10.0);
        settle(live_session);
        const double without_N = live_session.hooks().retractors.at(0).force_N;
        live_session.set_tension(0.04);
        settle(live_session);
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.retractors.size(), 1U);
        EXPECT_NEAR(report.retractors[0].opening_mm, 10.0, 1e-9);
        EXPECT_LT(report.retractors[0].force_N, without_N) << "the tension opens the wound too";
        EXPECT_LE(report.retractors[0].imbalance, RackBalance::kTolerance);
    }

    TEST(WoundHooks, ABladeWithPlayTurnsAndKeepsItsOpeningWhenTheWallIsSolvedAnew)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 45.0 }, { 90.0, 0.0, 45.0 }).done);
        RetractorKind kind = small_retractor();
        kind.play_deg = 12.0;
        ASSERT_TRUE(live_session.place_retractor(at(live_session, 60.0, 48.0), kind).done);
        live_session.crank(live_session.hooks().hooks[0].id, 10.0);
        settle(live_session);
        const HookReport before = live_session.hooks();
        const RetractorState& open = before.retractors.at(0);
        EXPECT_NEAR(open.opening_mm, 10.0, 1e-9);
        EXPECT_NEAR(open.arm_mm[0] + open.arm_mm[1], 10.0, 1e-9);
        double tissue_mm = 0.0;
        for (std::size_t i = 0; i < 2; ++i) {
            const HookState& blade = before.hooks[i];
            EXPECT_GT(open.turn_rad[i], 0.1);
            EXPECT_NEAR(blade.displacement.dot(blade.placement.pull),
                open.arm_mm[i] - blade.placement.lever_mm * std::sin(open.turn_rad[i]), 1e-6);
            EXPECT_EQ(moved_by_hand(before, blade), Vec3(open.arm_mm[i] * blade.placement.pull));
            tissue_mm += blade.displacement.dot(blade.placement.pull);
        }
        EXPECT_LT(tissue_mm, 9.0) << "below the arms the tissue moves less";
        live_session.set_tension(0.04);
        settle(live_session);
        const RetractorState after = live_session.hooks().retractors.at(0);
        EXPECT_NEAR(after.opening_mm, 10.0, 1e-6);
        EXPECT_NEAR(after.turn_rad[0], open.turn_rad[0], 1e-6);
    }

    TEST(WoundHooks, ARetractorWhoseBladeIsStoppedSaysHowFarItIs)
    {
        SurgerySession live_session = wound_with_retractor(45.0);
        const std::vector<HookState> blades = live_session.hooks().hooks;
        live_session.crank(blades[0].id, 8.0);
        settle(live_session);
        live_session.crank(blades[0].id, -5.0);
        settle(live_session);
        EXPECT_EQ(live_session.hooks().retractors.at(0).opening_mm, 0.0) << "blades do not pass through each other";
    }

    SurgerySetup wall_with_planned_retractor(std::optional<double> force_N)
    {
        SurgerySetup setup = wall_with_planned_hooks({ .force_N = force_N }, 8.0);
        RetractorSpec retractor { .kind = "midcab" };
        retractor.force_N = force_N;
        retractor.greatest_opening_mm = 90.0;
        setup.approach.retractor = retractor;
        return setup;
    }

    TEST(WoundHooks, APlannedRetractorHasItsRackAndFollowsItsShare)
    {
        SurgerySession live_session(wall_with_planned_retractor(std::nullopt));
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 20.0).done);
        const KnifeAnswer answer = live_session.take_planned_hooks();
        ASSERT_TRUE(answer.done) << answer.reason;
        ASSERT_EQ(live_session.hooks().retractors.size(), 1U);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 12.0, 1e-9);
        EXPECT_EQ(live_session.hooks().hooks[0].name, "planned upper blade");
        live_session.pull_hooks_by_share(0.5);
        settle(live_session);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 6.0, 1e-9);
        EXPECT_LE(live_session.hooks().retractors[0].imbalance, RackBalance::kTolerance);
        // Cranked shut by hand, it opens to its plan again.
        live_session.pull_all_hooks(0.0);
        settle(live_session);
        const KnifeAnswer again = live_session.take_planned_hooks();
        EXPECT_TRUE(again.done) << again.reason;
        ASSERT_EQ(live_session.hooks().hooks.size(), 2U);
        ASSERT_EQ(live_session.hooks().retractors.size(), 1U);
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 12.0, 1e-9);
        live_session.undo_step();
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 0.0, 1e-9) << "one step back: shut by hand";
        live_session.redo_step();
        EXPECT_NEAR(live_session.hooks().retractors[0].opening_mm, 12.0, 1e-9);
    }

    TEST(WoundHooks, APlannedHookHoldsNoBoneBeyondACutThatMissedItsLine)
    {
        const auto force_with = [](bool bears) {
            SurgerySetup setup = wall_with_planned_hooks({}, 8.0);
            for (TetId t = 0; t < static_cast<TetId>(setup.wall.tet_count()); ++t) {
                Vec3 middle = Vec3::Zero();
                for (const VertexId v : setup.wall.tet(t))
                    middle += 0.25 * setup.wall.vertices.row(v).transpose();
                if (middle.y() > 5.0 && middle.y() < 15.0)
                    setup.wall.labels[static_cast<std::size_t>(t)] = kBone;
            }
            if (bears) // a layer of bone is sawn, and each hook bears on its own half, at the planned line
                for (HookSpec& blade : setup.approach.hooks)
                    blade.bearing = { Vec3(60.0, 5.0, 60.0) + blade.direction };
            insert_bearing_points(setup.wall, setup.labels, setup.approach);
            SurgerySession live_session(std::move(setup));
            EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 62.5 }, { 90.0, 0.0, 62.5 }, 20.0, true).done);
            EXPECT_TRUE(live_session.take_planned_hooks().done);
            settle(live_session);
            for (const HookState& blade : live_session.hooks().hooks)
                for (const VertexId v : blade.placement.nodes)
                    EXPECT_GE((live_session.picture()->surface->rest.row(v).transpose() - Vec3(0.0, 0.0, 62.5))
                                  .dot(blade.placement.pull),
                        -0.1)
                        << "the lip lies 2.5 mm beside the plan, and is as straight as the mesh lets it";
            return live_session.hooks().side_N[0];
        };
        // A node of one hook on the other's half of the bone makes the force a thousand times as large.
        EXPECT_NEAR(force_with(true), force_with(false), 0.3 * force_with(false));
    }

    TEST(WoundHooks, APlannedRetractorThatPushesWithAForceHasNoRackAndSaysSo)
    {
        SurgerySession live_session(wall_with_planned_retractor(5.0));
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }, 20.0).done);
        const KnifeAnswer answer = live_session.take_planned_hooks();
        ASSERT_TRUE(answer.done) << answer.reason;
        EXPECT_TRUE(live_session.hooks().retractors.empty());
        EXPECT_NE(answer.reason.find("without a rack"), std::string::npos) << answer.reason;
    }

    TEST(WoundHooks, ARetractorNeedsTwoLips)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_FALSE(live_session.place_retractor(at(live_session, 60.0, 48.0), small_retractor()).done);
        EXPECT_TRUE(draw(live_session, { 30.0, 0.0, 45.0 }, { 90.0, 0.0, 45.0 }).done);
        const KnifeAnswer end = live_session.place_retractor(at(live_session, 88.0, 48.0), small_retractor());
        EXPECT_FALSE(end.done);
        EXPECT_NE(end.reason.find("beyond the end of the wound"), std::string::npos) << end.reason;
        const KnifeAnswer far = live_session.place_retractor(at(live_session, 60.0, 100.0), small_retractor());
        EXPECT_FALSE(far.done);
        EXPECT_NE(far.reason.find("no wound within"), std::string::npos) << far.reason;
        EXPECT_TRUE(live_session.hooks().hooks.empty());
    }

    TEST(WoundHooks, WhatGivesNoHoldIsRefusedInWords)
    {
        SurgerySession live_session(layered_wall());
        const auto refused = [&](double x, double z) { return live_session.place_hook(at(live_session, x, z)).reason; };
        EXPECT_NE(refused(60.0, 60.0).find("cut first"), std::string::npos);
        ASSERT_TRUE(draw(live_session, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }).done);
        EXPECT_NE(refused(60.0, 100.0).find("no wound within"), std::string::npos) << refused(60.0, 100.0);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 60.0, 63.0)).done);
        const std::string twice = refused(60.0, 63.0);
        EXPECT_NE(twice.find("already holds the wound here"), std::string::npos) << twice;
        EXPECT_EQ(live_session.hooks().hooks.size(), 1U);
        EXPECT_THROW(
            live_session.pull_hook(live_session.hooks().hooks[0].id, Vec3(0.0, 0.0, std::nan(""))), InputError);
        live_session.pull_hook(77, Vec3::Zero()); // taken off meanwhile
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 30.0, 90.0), {}).done);
        EXPECT_NE(refused(50.0, 57.0).find("a stroke is open"), std::string::npos);
        SurgerySetup floating = layered_wall();
        floating.held.clear();
        SurgerySession loose(std::move(floating));
        ASSERT_TRUE(draw(loose, { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 }).done);
        const std::string why = loose.place_hook(at(loose, 60.0, 63.0)).reason;
        EXPECT_NE(why.find("has neither a support nor a hook"), std::string::npos) << why;
        EXPECT_TRUE(loose.hooks().hooks.empty());
    }

    TEST(WoundHooks, ANewFactorIsMadeInTheBackgroundWhileTheKnifeGoesOn)
    {
        OpenWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(2.0);
        for (const double z : { 30.0, 90.0 }) {
            ASSERT_TRUE(draw(live_session, { 15.0, 0.0, z }, { 85.0, 0.0, z }, 20.0).done);
            wound.expect_exact();
        }
        // The factor is taken when the hand next moves.
        for (int i = 0; i < kPatience && live_session.hooks().factors_swapped == 0; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            live_session.pull_all_hooks(3.0);
            settle(live_session);
        }
        EXPECT_GT(live_session.hooks().factors_swapped, 0);
        wound.expect_exact();
    }

    TEST(WoundHooks, WhereALineIsPlannedTheWoundFollowsTheKnifeWithTheFactorAsItIs)
    {
        SurgerySetup setup = layered_wall();
        setup.approach.incision = { { 15.0, 0.0, 30.0 }, { 85.0, 0.0, 30.0 } };
        setup.approach.directions = { Vec3::UnitY(), Vec3::UnitY() };
        setup.approach.depth_mm = 20.0;
        setup.approach.sizing.corridor_edge_mm = kSlabEdgeMm;
        OpenWound planned(std::move(setup)), unplanned;
        for (OpenWound* wound : { &planned, &unplanned }) {
            wound->live_session.pull_all_hooks(2.0);
            ASSERT_TRUE(draw(wound->live_session, { 15.0, 0.0, 31.0 }, { 85.0, 0.0, 29.0 }, 20.0).done); // nearly
        }
        planned.expect_exact();
        // By the time that one without a plan has its new factor, the other would have, too.
        for (int i = 0; i < kPatience && unplanned.live_session.hooks().factors_swapped == 0; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            for (OpenWound* wound : { &unplanned, &planned }) {
                wound->live_session.pull_all_hooks(3.0);
                settle(wound->live_session);
            }
        }
        EXPECT_GT(unplanned.live_session.hooks().factors_swapped, 0);
        EXPECT_EQ(planned.live_session.hooks().factors_swapped, 0);
    }

    TEST(SurgeryWorker, TheWoundFollowsTheHandAndItsNumbersSettle)
    {
        SurgeryWorker worker([](const Job&) { return layered_wall(); }, [] {});
        const auto wait = [&] {
            for (int i = 0;
                 i < 12000 && (!worker.idle() || worker.snapshot()->phase == SurgerySnapshot::Phase::preparing); ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            ASSERT_TRUE(worker.idle());
        };
        wait();
        const auto at_now = [&](double x, double z) { return *touch(*worker.snapshot()->picture, ray_down(x, z)); };
        worker.run(surgery::BeginStroke { at_now(30.0, 60.0) });
        for (double x = 32.0; x <= 90.0; x += 2.0)
            worker.run(surgery::DrawTo { at_now(x, 60.0) });
        worker.run(surgery::FinishStroke {});
        wait();
        worker.run(surgery::PlaceHook { at_now(60.0, 63.0) });
        worker.run(surgery::PlaceHook { at_now(60.0, 57.0) });
        wait();
        const SurgerySnapshot placed = *worker.snapshot();
        ASSERT_EQ(placed.hooks.hooks.size(), 2U) << placed.answer;
        const fem::HookId id = placed.hooks.hooks[0].id;
        for (int i = 1; i <= 500; ++i)
            worker.run(surgery::PullHook { id, Vec3(0.0, 0.0, 0.01 * i) });
        wait();
        const SurgerySnapshot pulled = *worker.snapshot();
        EXPECT_LT((pulled.hooks.hooks[0].displacement - Vec3(0.0, 0.0, 5.0)).norm(), kRoundingMm)
            << "the newest order counts";
        EXPECT_TRUE(pulled.hooks.settled);
        EXPECT_LT(pulled.hooks.residual, kResidual);
        EXPECT_GT(pulled.hooks.strain.p99, 0.0);
        EXPECT_GT(pulled.gape_mm, 4.9);
        EXPECT_EQ(pulled.to_undo, "moving the " + pulled.hooks.hooks[0].name);
        worker.run(surgery::GoTo { 0 });
        wait();
        EXPECT_TRUE(worker.snapshot()->hooks.hooks.empty());
        EXPECT_NE(worker.snapshot()->answer.find("lost its tissue"), std::string::npos) << worker.snapshot()->answer;
        EXPECT_TRUE(worker.snapshot()->refused);
    }

} // namespace wound_hooks_test
} // namespace retractor::planner
