// The nonlinear answer near a wound in the surgery session: it is NonlinearRegion's, comes in the background, follows
// the hand, and makes way for cuts.

#include "planner/session/near_wound.h"

#include "fem/linear_algebra/sparse_cholesky.h"
#include "mesh/base/error.h"
#include "planner/session/surgery_session.h"
#include "planner/session/surgery_worker.h"
#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>
#include <thread>

namespace retractor::planner {
namespace near_wound_test {

    constexpr double kSettled = 1e-6; // residual of an answer at rest
    // Two answers at rest that were come to by different ways, of the largest displacement and force: the stiffness of
    // the slab is worth some hundred residuals.
    constexpr double kSame = 3e-4;
    // What is shown is a sum of a linear answer and of the nonlinear one's difference from it, in coordinates of some
    // 100 mm, each rounded to 1e-14 of itself; and the linear one may be made with an older or a newer factor, as the
    // threads come along. A wrong answer is off by a tenth of a millimetre and a newton at the least.
    constexpr double kRounding = 1e-10; // mm, N

    Touch at(SurgerySession& live_session, double x, double z)
    {
        const auto found = touch(*live_session.picture(), ray_down(x, z));
        if (!found)
            throw InputError("the ray misses the slab");
        return *found;
    }

    void settle(SurgerySession& live_session)
    {
        for (int i = 0; i < 100000 && live_session.moving(); ++i) {
            live_session.relax(40.0);
            std::this_thread::sleep_for(std::chrono::milliseconds(1)); // the answer is made on another thread
        }
        ASSERT_FALSE(live_session.moving());
    }

    bool draw(SurgerySession& live_session, double x0, double z0, double x1, double z1)
    {
        if (!live_session.begin_stroke(at(live_session, x0, z0), { .depth_mm = 15.0 }).done)
            return false;
        for (int i = 1; i <= 20; ++i)
            (void)live_session.draw_to(at(live_session, x0 + (x1 - x0) * i / 20.0, z0 + (z1 - z0) * i / 20.0));
        return live_session.finish_stroke().done;
    }

    /// A wound of 60 mm along x in the middle of the slab, with a hook on each lip in its middle.
    struct NonlinearWound {
        SurgerySession live_session { layered_wall() };

        NonlinearWound()
        {
            EXPECT_TRUE(draw(live_session, 30.0, 60.0, 90.0, 60.0));
            live_session.set_nonlinear(true);
            for (const double z : { 63.0, 57.0 })
                EXPECT_TRUE(live_session.place_hook(at(live_session, 60.0, z)).done);
        }
        Points moved()
        {
            const WallPicture& picture = *live_session.picture();
            Points moved = Points::Zero(static_cast<Eigen::Index>(live_session.session().vertex_slots()), 3);
            for (VertexId v = 0; v < static_cast<VertexId>(moved.rows()); ++v)
                if (live_session.session().has_vertex(v))
                    moved.row(v) = picture.shown.row(v) - picture.surface->rest.row(v);
            return moved;
        }
        /// NonlinearRegion on a copy of the wall, from rest.
        void expect_nonlinear_region()
        {
            settle(live_session);
            const HookReport report = live_session.hooks();
            ASSERT_EQ(report.shown, ShownAnswer::nonlinear) << report.shown_text;
            EXPECT_EQ(report.shown_text, "nonlinear within 40 mm");
            EXPECT_LT(report.residual, kSettled);
            mesh::SlotMap map;
            const mesh::TetMesh mesh = live_session.session().compact_mesh(&map);
            const auto compact = [&](VertexId id) { return map.compact_vertex[static_cast<std::size_t>(id)]; };
            SurgerySetup setup = layered_wall();
            for (fem::Material& material : setup.materials)
                material.poissons_ratio = std::min(material.poissons_ratio, 0.45);
            fem::Supports supports;
            for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
                if (const Vec3 p = mesh.vertices.row(v);
                    p.x() == 0.0 || p.x() == 120.0 || p.z() == 0.0 || p.z() == 120.0)
                    supports.fixed.push_back(v);
            std::vector<fem::HookPatch> hooks;
            std::vector<Vec3> asked;
            for (const HookState& hook : report.hooks) {
                hooks.push_back({ hook.name, hook.placement.side, {}, Vec3::Zero() });
                for (const VertexId v : hook.placement.nodes)
                    hooks.back().nodes.push_back(compact(v));
                asked.push_back(hook.drive.displacement);
            }
            std::set<VertexId> lips;
            for (const mesh::LipFace& lip : live_session.session().lips())
                for (const VertexId v : mesh::face_vertices(
                         mesh, { map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner }))
                    lips.insert(v);
            Points wound(static_cast<Eigen::Index>(lips.size()), 3);
            Eigen::Index row = 0;
            for (const VertexId v : lips)
                wound.row(row++) = mesh.vertices.row(v);
            constexpr double kNearMm = 40.0, kStepMm = 3.0;
            fem::NonlinearRegion field(mesh, setup.materials, supports, hooks, fem::elements_near(mesh, wound, kNearMm),
                { .elasticity = fem::Elasticity::corotational_linear });
            const int steps
                = static_cast<int>(std::ceil(live_session.hooks().hooks[0].drive.displacement.norm() / kStepMm));
            for (int step = 1; step <= steps; ++step) {
                std::vector<Vec3> there = asked;
                for (Vec3& a : there)
                    a *= static_cast<double>(step) / steps;
                (void)field.drag(there);
            }
            const fem::NearFrame right = field.settle();
            ASSERT_EQ(right.status, fem::NearStatus::settled) << right.message;
            const Points shown = moved();
            double worst = 0.0;
            for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
                worst = std::max(worst,
                    (shown.row(map.vertex_slot[v]).transpose()
                        - right.displacement.segment<3>(3 * static_cast<Eigen::Index>(v)))
                        .norm());
            EXPECT_LT(worst, kSame * shown.rowwise().norm().maxCoeff());
            for (std::size_t h = 0; h < hooks.size(); ++h)
                EXPECT_LT(
                    (report.hooks[h].force_N - right.hook_forces_N[h]).norm(), kSame * right.hook_forces_N[h].norm());
        }
    };

    double difference(const Points& a, const Points& b)
    {
        const Eigen::Index rows = std::min(a.rows(), b.rows());
        return (a.topRows(rows) - b.topRows(rows)).rowwise().norm().maxCoeff();
    }

    TEST(NearWound, WhatIsShownIsTheNearFieldsAnswer)
    {
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(12.0);
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear) << "it is not made yet";
        EXPECT_EQ(live_session.hooks().shown_text, "linear: the nonlinear solution is computed");
        const Points linear = wound.moved();
        wound.expect_nonlinear_region();
        EXPECT_GT(difference(wound.moved(), linear), 0.5) << "12 mm are far beyond small strains";
        EXPECT_GT(live_session.hooks().strain.p99, 0.0);
        // Dragged on: frames of the same field, and each hook where the hand is.
        for (const double mm : { 13.0, 14.0, 15.0 }) {
            live_session.pull_all_hooks(mm);
            EXPECT_EQ(live_session.hooks().shown, ShownAnswer::nonlinear);
            EXPECT_TRUE(live_session.hooks_unsettled());
        }
        const Points dragged = wound.moved();
        wound.expect_nonlinear_region();
        EXPECT_LT(difference(dragged, wound.moved()), 0.5) << "what the eye is shown while the hand moves";
        EXPECT_EQ(live_session.hooks().near_swapped, 1) << "dragging makes no new one";
        // Another hook: made anew.
        live_session.pull_all_hooks(4.0);
        settle(live_session);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 75.0, 66.0)).done);
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear);
        ASSERT_EQ(live_session.hooks().hooks.size(), 3U);
        const Points placed = wound.moved();
        for (const HookState& hook : live_session.hooks().hooks)
            for (const VertexId v : hook.placement.nodes)
                EXPECT_LT((placed.row(v).transpose() - hook.drive.displacement).norm(), 1e-9) << hook.name;
        wound.expect_nonlinear_region();
    }

    TEST(NearWound, SmallPullsDifferFromLinearBySecondOrder)
    {
        NonlinearWound wound;
        const auto off = [&](double mm) {
            wound.live_session.pull_all_hooks(mm);
            settle(wound.live_session);
            const Points nonlinear = wound.moved();
            EXPECT_EQ(wound.live_session.hooks().shown, ShownAnswer::nonlinear);
            wound.live_session.set_nonlinear(false);
            settle(wound.live_session);
            EXPECT_EQ(wound.live_session.hooks().shown, ShownAnswer::linear);
            EXPECT_EQ(wound.live_session.hooks().shown_text, "linear");
            const double difference_mm = difference(nonlinear, wound.moved());
            wound.live_session.set_nonlinear(true);
            return difference_mm;
        };
        const double small = off(0.2), twice = off(0.4);
        EXPECT_NEAR(twice / small, 4.0, 0.8);
        EXPECT_LT(twice, 0.05 * 0.4);
    }

    TEST(NearWound, HooksStopWhereTheirLipsMeetInNonlinearTissueToo)
    {
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(2.0);
        settle(live_session);
        live_session.pull_hook(live_session.hooks().hooks[1].id, Vec3(0.0, 0.0, 6.0));
        settle(live_session);
        const HookReport report = live_session.hooks();
        EXPECT_EQ(report.shown, ShownAnswer::nonlinear) << report.shown_text;
        EXPECT_LT(report.residual, kSettled);
        EXPECT_EQ(report.meeting, "hook 1 and hook 2");
        EXPECT_LT((report.hooks[0].displacement - Vec3(0.0, 0.0, 2.0)).norm(), kRounding);
        EXPECT_NEAR(report.hooks[1].displacement.z(), 2.0, 0.2) << "the lips are as good as straight";
    }

    TEST(NearWound, CutsGoOnFromTheNonlinearAnswerAndUndoRestoresIt)
    {
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(12.0);
        const Points linear = wound.moved();
        wound.expect_nonlinear_region();
        const Points before = wound.moved();
        const double force = live_session.hooks().hooks[0].force_N.norm();
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 100.0), { .depth_mm = 8.0 }).done);
        for (double x = 22.0; x <= 40.0; x += 2.0)
            (void)live_session.draw_to(at(live_session, x, 100.0));
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        const Points cut = wound.moved();
        EXPECT_LT(difference(cut, before), 0.5 * difference(linear, before)) << "it does not jump back";
        for (const HookState& hook : live_session.hooks().hooks)
            for (const VertexId v : hook.placement.nodes)
                EXPECT_LT((cut.row(v).transpose() - hook.drive.displacement).norm(), 1e-9);
        EXPECT_NEAR(live_session.hooks().hooks[0].force_N.norm() / force, 1.0, 0.05) << "a small cut far away";
        live_session.relax(40.0);
        EXPECT_TRUE(live_session.moving()) << "it is made when the cut is";
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        ASSERT_TRUE(live_session.finish_stroke().done);
        wound.expect_nonlinear_region();
        live_session.undo();
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        wound.expect_nonlinear_region();
        EXPECT_LT(difference(wound.moved(), before), kSame * 12.0);
        EXPECT_NEAR(live_session.hooks().hooks[0].force_N.norm(), force, kSame * force);
    }

    TEST(NearWound, HooksYieldAtTheirLimitInNonlinearTissueToo)
    {
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(8.0);
        settle(live_session);
        const double unlimited = live_session.hooks().hooks[0].force_N.norm(), limit = 0.5 * unlimited;
        live_session.set_yield(limit);
        settle(live_session);
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.shown, ShownAnswer::nonlinear) << report.shown_text;
        EXPECT_LT(report.residual, kSettled);
        constexpr double kAtLimit = 1e-4; // of the limit: the hooks stay to 1e-6 of their way
        const Points shown = wound.moved();
        for (const HookState& hook : report.hooks) {
            EXPECT_TRUE(hook.yielded) << hook.name;
            EXPECT_NEAR(hook.force_N.norm(), limit, kAtLimit * limit) << hook.name;
            const Vec3 slip = hook.drive.displacement - hook.displacement;
            EXPECT_GT(slip.norm(), 1.0) << hook.name;
            EXPECT_NEAR(slip.normalized().dot(hook.force_N.normalized()), 1.0, kAtLimit) << "it slips as it is pulled";
            for (const VertexId v : hook.placement.nodes)
                EXPECT_LT((shown.row(v).transpose() - hook.displacement).norm(), 1e-9) << hook.name;
        }
        // The same by a hand that goes no farther than the hooks have come to.
        std::vector<Vec3> there;
        for (const HookState& hook : report.hooks)
            there.push_back(hook.displacement);
        live_session.set_yield(std::numeric_limits<double>::infinity());
        for (std::size_t h = 0; h < there.size(); ++h)
            live_session.pull_hook(report.hooks[h].id, there[h]);
        settle(live_session);
        for (std::size_t h = 0; h < there.size(); ++h) {
            EXPECT_FALSE(live_session.hooks().hooks[h].yielded);
            EXPECT_LT((live_session.hooks().hooks[h].force_N - report.hooks[h].force_N).norm(), kAtLimit * limit);
        }
        EXPECT_LT(difference(wound.moved(), shown), kAtLimit * 8.0);
        // Made anew under the limit, from rest.
        live_session.set_nonlinear(false);
        live_session.set_yield(limit);
        live_session.pull_all_hooks(8.0);
        live_session.set_nonlinear(true);
        settle(live_session);
        ASSERT_EQ(live_session.hooks().shown, ShownAnswer::nonlinear);
        EXPECT_TRUE(live_session.hooks().hooks[0].yielded);
        EXPECT_LT(difference(wound.moved(), shown), kAtLimit * 8.0);
        live_session.set_yield(std::numeric_limits<double>::infinity());
        settle(live_session);
        EXPECT_NEAR(live_session.hooks().hooks[0].force_N.norm(), unlimited, kAtLimit * unlimited);
        wound.expect_nonlinear_region();
    }

    TEST(NearWound, SaysWhereLinearTissueBeyondIsOffByMuch)
    {
        constexpr double kFarMm = 30.0; // each way
        SurgerySetup setup = wall_with_planned_hooks({}, 7.0);
        for (HookSpec& hook : setup.approach.hooks)
            hook.opening_mm = kFarMm;
        // By one side alone: the others turn.
        std::erase_if(setup.held, [&](VertexId v) { return setup.wall.vertices(v, 2) > 1.0; });
        SurgerySession live_session(std::move(setup));
        ASSERT_TRUE(draw(live_session, 30.0, 60.0, 90.0, 60.0));
        live_session.set_nonlinear(true);
        ASSERT_TRUE(live_session.take_planned_hooks().done);
        settle(live_session);
        const HookReport report = live_session.hooks();
        ASSERT_EQ(report.shown, ShownAnswer::nonlinear) << report.shown_text;
        EXPECT_NE(report.shown_text.find("; the linear tissue beyond "), std::string::npos)
            << report.shown_text;
        live_session.pull_hooks_by_share(0.01);
        settle(live_session);
        EXPECT_EQ(live_session.hooks().shown_text, "nonlinear within 40 mm") << "little is asked of it there";
    }

    TEST(NearWound, PlannedForcesAreBorneInNonlinearTissueToo)
    {
        constexpr double kForceN = 6.0, kAtForce = 1e-4; // the hooks stay to 1e-6 of their way
        SurgerySession live_session(wall_with_planned_hooks({ .force_N = kForceN }, 7.0));
        ASSERT_TRUE(draw(live_session, 30.0, 60.0, 90.0, 60.0));
        live_session.set_nonlinear(true);
        const KnifeAnswer taken = live_session.take_planned_hooks();
        ASSERT_TRUE(taken.done && taken.reason.empty()) << taken.reason;
        const auto way = [&](std::size_t h) { return live_session.hooks().hooks[h].displacement; };
        const auto expect_force = [&](double force_N) {
            settle(live_session);
            ASSERT_EQ(live_session.hooks().shown, ShownAnswer::nonlinear) << live_session.hooks().shown_text;
            EXPECT_EQ(live_session.hooks().shown_text, "nonlinear within 40 mm");
            EXPECT_LT(live_session.hooks().residual, kSettled);
            for (const HookState& hook : live_session.hooks().hooks)
                EXPECT_LT((hook.force_N - force_N * hook.placement.pull).norm(), kAtForce * kForceN) << hook.name;
        };
        const double linear = way(0).norm();
        expect_force(kForceN);
        const Vec3 planned = way(0);
        EXPECT_GT(std::abs(planned.norm() - linear), 0.2) << "far beyond small strains";
        live_session.pull_hooks_by_share(0.5);
        expect_force(0.5 * kForceN);
        EXPECT_EQ(live_session.hooks().near_swapped, 1) << "the slider makes no new one";
        EXPECT_LT(way(0).norm(), planned.norm());
        live_session.pull_hooks_by_share(1.0);
        expect_force(kForceN);
        EXPECT_LT((way(0) - planned).norm(), kAtForce * planned.norm());
        // After a cut the force is the same, at once and in the answer that is made of it; and undone, the way is.
        ASSERT_TRUE(draw(live_session, 30.0, 85.0, 90.0, 85.0));
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        EXPECT_NEAR(live_session.hooks().hooks[0].force_N.norm(), kForceN, kAtForce * kForceN);
        expect_force(kForceN);
        EXPECT_GT(way(0).norm(), planned.norm());
        live_session.undo();
        expect_force(kForceN);
        EXPECT_LT((way(0) - planned).norm(), kAtForce * planned.norm());
        // In the hand it is where that is, also where no nonlinear answer is there yet.
        ASSERT_TRUE(draw(live_session, 20.0, 100.0, 40.0, 100.0));
        ASSERT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        live_session.pull_hook(live_session.hooks().hooks[0].id, planned);
        EXPECT_LT((way(0) - planned).norm(), kRounding);
    }

    TEST(NearWound, ARefusedLinearAnswerLeavesWhatWasShown)
    {
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(12.0);
        wound.expect_nonlinear_region();
        const HookReport before = live_session.hooks();
        const Points shown = wound.moved();
        // No number is left for the square of such a limit.
        live_session.set_yield(1e-200);
        const auto expect_as_before = [&] {
            const HookReport report = live_session.hooks();
            EXPECT_NE(report.refusal.find("no equilibrium of the hooks"), std::string::npos) << report.refusal;
            EXPECT_EQ(report.shown_text.find("last solution"), 0U) << report.shown_text;
            EXPECT_LT(difference(wound.moved(), shown), kRounding);
            for (std::size_t h = 0; h < before.hooks.size(); ++h) {
                EXPECT_LT((report.hooks[h].force_N - before.hooks[h].force_N).norm(), kRounding);
                EXPECT_LT((report.hooks[h].displacement - before.hooks[h].displacement).norm(), kRounding);
            }
        };
        expect_as_before();
        settle(live_session);
        expect_as_before();
        live_session.pull_all_hooks(2.0);
        expect_as_before();
        // A knife that goes on finds no answer either, and leaves the rest where it is.
        ASSERT_TRUE(draw(live_session, 20.0, 100.0, 40.0, 100.0));
        EXPECT_NE(live_session.hooks().refusal, "");
        EXPECT_LT(difference(wound.moved(), shown), kRounding);
        live_session.undo();
        live_session.pull_all_hooks(12.0);
        live_session.set_yield(std::numeric_limits<double>::infinity());
        EXPECT_EQ(live_session.hooks().refusal, "");
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear) << live_session.hooks().shown_text;
        wound.expect_nonlinear_region();
        EXPECT_LT(difference(wound.moved(), shown), kSame * 12.0);
    }

    TEST(NearWound, ANewLimitShowsNoForcesBeyondIt)
    {
        // After a cut the linear answer's changes are added to the last nonlinear one: its forces know no new limit.
        NonlinearWound wound;
        SurgerySession& live_session = wound.live_session;
        live_session.pull_all_hooks(12.0);
        settle(live_session);
        const double limit = 1e-3 * live_session.hooks().hooks[0].force_N.norm();
        ASSERT_TRUE(draw(live_session, 20.0, 100.0, 40.0, 100.0));
        ASSERT_EQ(live_session.hooks().shown, ShownAnswer::linear_since);
        constexpr double kOver = 0.01;
        const auto expect_within_limit = [&] {
            for (const HookState& hook : live_session.hooks().hooks) {
                EXPECT_TRUE(hook.yielded) << hook.name;
                EXPECT_LT(hook.force_N.norm(), (1.0 + kOver) * limit) << hook.name;
            }
        };
        live_session.set_yield(limit);
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::linear) << live_session.hooks().shown_text;
        expect_within_limit();
        settle(live_session);
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::nonlinear) << live_session.hooks().shown_text;
        expect_within_limit();
    }

    TEST(NearWound, TensionIsPartOfIt)
    {
        SurgerySession live_session(layered_wall());
        live_session.set_tension(0.01);
        ASSERT_TRUE(draw(live_session, 30.0, 60.0, 90.0, 60.0));
        live_session.set_nonlinear(true);
        for (const double z : { 63.0, 57.0 })
            ASSERT_TRUE(live_session.place_hook(at(live_session, 60.0, z)).done);
        settle(live_session);
        EXPECT_EQ(live_session.hooks().shown, ShownAnswer::nonlinear) << live_session.hooks().shown_text;
        const double nonlinear = live_session.gape_mm();
        live_session.set_nonlinear(false);
        settle(live_session);
        EXPECT_GT(nonlinear, 0.2);
        EXPECT_NEAR(nonlinear / live_session.gape_mm(), 1.0, 0.05) << "a small tension opens alike";
    }

    /// A block held at its bottom with a hook on its top.
    NearProblem block(double pull)
    {
        NearProblem problem;
        problem.mesh = mesh::kuhn_box(4, 4, 4, 5.0);
        problem.material_of_label.assign(2, fem::default_materials().front());
        fem::HookPatch hook { "hook", 1, {}, Vec3(pull, 0.0, 0.0) };
        for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertex_count()); ++v) {
            problem.id.push_back(v);
            const Vec3 p = problem.mesh.vertices.row(v);
            if (p.z() == 0.0)
                problem.supports.fixed.push_back(v);
            else if (p.z() == 20.0 && p.x() < 7.0 && p.y() < 7.0)
                hook.nodes.push_back(v);
        }
        problem.drives = { { .displacement = hook.displacement } };
        problem.hooks = { hook };
        problem.wound = problem.mesh.vertices.topRows(1);
        return problem;
    }

    void wait_for(NearWound& near)
    {
        for (int i = 0; i < 100000 && near.building(); ++i) {
            (void)near.take();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ASSERT_FALSE(near.building());
    }

    TEST(NearWound, OnlyTheNewestProblemCounts)
    {
        NearWound near;
        for (int i = 1; i <= 20; ++i) {
            near.begin(block(0.2 * i));
            EXPECT_TRUE(near.building());
            EXPECT_FALSE(near.ready());
        }
        wait_for(near);
        ASSERT_TRUE(near.ready()) << near.refusal();
        EXPECT_LT((near.frame().hook_displacements[0] - Vec3(4.0, 0.0, 0.0)).norm(), kRounding);
        EXPECT_TRUE(near.settled());
        EXPECT_LT(near.frame().residual, kSettled);
        near.begin(block(1.0));
        near.outdate();
        EXPECT_FALSE(near.building());
        EXPECT_FALSE(near.ready());
        near.begin(block(1.0)); // and goes while it is made
    }

    TEST(NearWound, SaysWhyItCannotBeSolved)
    {
        NearWound near;
        NearProblem loose = block(1.0);
        loose.supports = {};
        loose.hooks.clear();
        loose.drives.clear();
        near.begin(loose);
        wait_for(near);
        EXPECT_FALSE(near.ready());
        EXPECT_NE(near.refusal(), "");
        NearProblem empty = block(1.0);
        empty.hooks[0].nodes.clear();
        near.begin(empty);
        EXPECT_EQ(near.refusal(), "");
        wait_for(near);
        EXPECT_NE(near.refusal().find("hook"), std::string::npos) << near.refusal();
        near.begin(block(1.0));
        wait_for(near);
        EXPECT_TRUE(near.ready());
        EXPECT_EQ(near.refusal(), "");
    }

    TEST(SurgeryWorker, TheNonlinearAnswerComesWhenTheHandRests)
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
        worker.run(surgery::SetNonlinear { true });
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
        EXPECT_EQ(placed.hooks.shown, ShownAnswer::nonlinear) << placed.hooks.shown_text;
        for (int i = 1; i <= 200; ++i)
            worker.run(surgery::PullHook { placed.hooks.hooks[0].id, Vec3(0.0, 0.0, 0.05 * i) });
        wait();
        const SurgerySnapshot pulled = *worker.snapshot();
        EXPECT_LT((pulled.hooks.hooks[0].displacement - Vec3(0.0, 0.0, 10.0)).norm(), kRounding)
            << "the newest order counts";
        EXPECT_EQ(pulled.hooks.shown, ShownAnswer::nonlinear);
        EXPECT_LT(pulled.hooks.residual, kSettled);
        EXPECT_TRUE(pulled.hooks.settled);
        worker.run(surgery::GoTo { 0 });
        wait();
        EXPECT_TRUE(worker.snapshot()->hooks.hooks.empty());
    }

} // namespace near_wound_test
} // namespace retractor::planner
