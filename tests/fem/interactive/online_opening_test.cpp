#include "fem/interactive/online_opening.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/linear_algebra/parallel.h"
#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"
#include "tests/support/random_strokes.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/element_stress.h"
#include "tests/verification/framework/tension.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

namespace retractor::fem {
namespace online_opening_test {

    using namespace test_support;

    // Two exact solvers on one mesh: what their round-off leaves between them, relative to the largest displacement.
    constexpr double kSameAnswer = 1e-10;
    constexpr double kResidual = 1e-8; // what an answer promises

    const Vec3 kBox(32.0, 32.0, 16.0);
    const std::vector<Material> kTissues { test_support::material(1.0, 0.3), test_support::material(0.02, 0.45),
        test_support::material(0.2, 0.4) };

    mesh::TetMesh layered_box()
    {
        mesh::TetMesh box = mesh::kuhn_box(8, 8, 4, 4.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            box.labels[static_cast<std::size_t>(t)] = box.vertices(box.tet(t)[0], 2) >= 8.0 ? 2 : 1;
        return box;
    }

    std::vector<VertexId> vertices_where(const mesh::TetMesh& mesh, const std::function<bool(const Vec3&)>& inside)
    {
        std::vector<VertexId> found;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (inside(mesh.vertices.row(v).transpose()))
                found.push_back(v);
        return found;
    }
    bool at_bottom(const Vec3& p) { return p.z() < 1e-9; }
    Supports bottom_fixed(const mesh::TetMesh& mesh) { return { vertices_where(mesh, at_bottom), {} }; }

    /// Skin vertices of the corner at the origin, or of the opposite one.
    OnlineHook corner_hook(const mesh::TetMesh& mesh, bool far, const Vec3& pull)
    {
        OnlineHook hook;
        hook.name = far ? "far" : "near";
        hook.side = far ? 1 : -1;
        hook.nodes = vertices_where(mesh, [&](const Vec3& p) {
            const double x = far ? kBox.x() - p.x() : p.x(), y = far ? kBox.y() - p.y() : p.y();
            return p.z() > kBox.z() - 1e-9 && x < 8.5 && y < 8.5;
        });
        hook.drive.displacement = pull;
        return hook;
    }

    /// The middle of the box: the planned corridor.
    std::vector<VertexId> middle(const mesh::TetMesh& mesh)
    {
        return vertices_where(mesh, [](const Vec3& p) { return std::abs(p.y() - 16.0) < 6.5 && p.z() > 3.0; });
    }

    /// Along x through the middle of the top.
    mesh::Blade middle_blade(double depth = 9.0, double from = 5.0, double to = 27.0)
    {
        return { .line = { Vec3(from, 15.1, 16.0), Vec3(to, 16.7, 16.0) },
            .directions = { Vec3(0.05, 0.1, -1.0) },
            .depth_mm = depth };
    }

    /// The same problem assembled and factored from nothing, by session ids.
    Eigen::VectorXd fresh_solution(const mesh::CutSession& session, std::span<const Material> materials,
        const std::vector<OnlineHook>& hooks, const std::vector<Vec3>& moved, const Eigen::VectorXd& load = {})
    {
        mesh::SlotMap map;
        const mesh::TetMesh mesh = session.compact_mesh(&map);
        std::vector<Lame> parameters;
        for (const Label label : mesh.labels)
            parameters.push_back(lame(materials[label]));
        ElasticBody body(mesh, Elasticity::linear, parameters);
        std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
        Eigen::VectorXd values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(prescribed.size())), loads = values;
        const auto prescribe = [&](VertexId v, const Vec3& u) {
            values.segment<3>(3 * v) = u;
            for (std::size_t a = 0; a < 3; ++a)
                prescribed[3 * static_cast<std::size_t>(v) + a] = 1;
        };
        for (const VertexId v : vertices_where(mesh, at_bottom))
            prescribe(v, Vec3::Zero());
        for (std::size_t h = 0; h < hooks.size(); ++h)
            for (const VertexId v : hooks[h].nodes)
                if (static_cast<std::size_t>(v) < map.compact_vertex.size()
                    && map.compact_vertex[static_cast<std::size_t>(v)] >= 0)
                    prescribe(map.compact_vertex[static_cast<std::size_t>(v)], moved[h]);
        if (load.size() > 0)
            for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
                loads.segment<3>(3 * static_cast<Eigen::Index>(v)) = load.segment<3>(3 * map.vertex_slot[v]);
        const Eigen::VectorXd u = test_support::solve_linear(body, prescribed, values, loads);
        Eigen::VectorXd by_id = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(map.compact_vertex.size()));
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
            by_id.segment<3>(3 * map.vertex_slot[v]) = u.segment<3>(3 * static_cast<Eigen::Index>(v));
        return by_id;
    }

    double difference(Eigen::VectorXd a, Eigen::VectorXd b)
    {
        const Eigen::Index n = std::max(a.size(), b.size());
        a.conservativeResizeLike(Eigen::VectorXd::Zero(n));
        b.conservativeResizeLike(Eigen::VectorXd::Zero(n));
        return (a - b).lpNorm<Eigen::Infinity>() / b.lpNorm<Eigen::Infinity>();
    }

    OnlineAnswer whole_answer(OnlineOpening& opening)
    {
        OnlineAnswer answer = opening.answer();
        opening.complete(answer);
        return answer;
    }

    /// The body divided into parts small enough for the tests' boxes to have many.
    OnlineOptions divided_body()
    {
        OnlineOptions options;
        options.body = BodyKept::dissected;
        options.part_vertices = 20;
        return options;
    }
    std::vector<OnlineOptions> both_ways() { return { OnlineOptions {}, divided_body() }; }

    struct Wound {
        explicit Wound(const mesh::TetMesh& box = layered_box(), std::vector<Material> tissues = kTissues,
            OnlineOptions options = {}, const Vec3& pull = Vec3(0.0, 3.0, 1.0), bool wide_corridor = false)
            : materials(std::move(tissues))
            , session(box)
            , opening(session, materials, bottom_fixed(box),
                  wide_corridor ? vertices_where(box, [](const Vec3& p) { return p.z() > 1.0; }) : middle(box), options)
            , hooks { corner_hook(box, false, -pull), corner_hook(box, true, pull) }
        {
            for (const OnlineHook& hook : hooks)
                ids.push_back(opening.attach(hook));
        }
        void cut(const mesh::Blade& blade)
        {
            const mesh::CutResult result = session.cut(blade);
            ASSERT_EQ(result.status, mesh::CutStatus::done) << result.message;
            opening.follow(result.delta);
        }
        std::vector<Vec3> pulls() const
        {
            std::vector<Vec3> moved;
            for (const OnlineHook& hook : hooks)
                moved.push_back(hook.drive.displacement);
            return moved;
        }
        void expect_exact(double tolerance = kSameAnswer)
        {
            const OnlineAnswer answer = whole_answer(opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            EXPECT_LT(answer.residual, kResidual);
            EXPECT_LT(difference(answer.displacement, fresh_solution(session, materials, hooks, pulls())), tolerance)
                << opening.route();
        }

        std::vector<Material> materials;
        mesh::CutSession session;
        OnlineOpening opening;
        std::vector<OnlineHook> hooks;
        std::vector<HookId> ids;
    };

    TEST(OnlineOpening, AStretchedBarHasTheClosedFormsForce)
    {
        // Plane cross-sections that may contract freely: only the ends are held, by hooks that grip all of them.
        const mesh::TetMesh bar = mesh::kuhn_box(10, 2, 2, 1.0);
        const Material soft
            = test_support::material(0.5, 0.0); // no lateral contraction: the ends' grip does not matter
        const mesh::CutSession session(bar);
        OnlineHook end;
        end.name = "end";
        end.nodes = vertices_where(bar, [](const Vec3& p) { return p.x() > 9.9; });
        end.drive.displacement = Vec3(0.2, 0.0, 0.0);
        OnlineOpening opening(session, std::vector<Material> { soft, soft },
            { vertices_where(bar, [](const Vec3& p) { return p.x() < 0.1; }), {} }, {});
        opening.attach(end);
        const OnlineAnswer answer = whole_answer(opening);
        EXPECT_NEAR(answer.hook_forces_N[0].x(), 0.5 * 4.0 * 0.2 / 10.0, 1e-12); // E A u / L
        for (VertexId v = 0; v < static_cast<VertexId>(bar.vertex_count()); ++v)
            EXPECT_NEAR(answer.displacement[3 * v], 0.02 * bar.vertices(v, 0), 1e-12);
    }

    TEST(OnlineOpening, FollowsCutsUndosAndRedosExactly)
    {
        // The divided body; updated states after every step, never, and by the usual rule.
        std::vector<OnlineOptions> ways { divided_body() };
        for (const std::size_t apply_update :
            { std::size_t { 1 }, std::size_t { 100000 }, OnlineOptions {}.update_vertices })
            ways.push_back({ .update_vertices = apply_update });
        for (const OnlineOptions& options : ways) {
            int solved = 0;
            for (unsigned seed = 1; seed <= 3; ++seed) {
                Wound wound(layered_box(), kTissues, options);
                std::mt19937 random(seed);
                for (int i = 0; i < 8; ++i) {
                    const auto follow = [&](const mesh::MeshDelta& delta) {
                        wound.opening.follow(delta);
                        EXPECT_NE(whole_answer(wound.opening).status, OnlineStatus::inaccurate);
                    };
                    test_support::random_change(wound.session, random, kBox, follow);
                    if (wound.opening.answer().status == OnlineStatus::unsupported)
                        continue; // strokes that meet can cut a piece out
                    SCOPED_TRACE("seed " + std::to_string(seed) + ", change " + std::to_string(i));
                    wound.expect_exact();
                    ++solved;
                }
            }
            EXPECT_GT(solved, 12);
        }
    }

    TEST(OnlineOpening, AFreehandStrokeIsExactAfterEachStepAndFirstInTheCorridor)
    {
        Wound wound(layered_box(), kTissues, { .update_vertices = 20 });
        const mesh::Blade blade = middle_blade();
        mesh::Blade drawn = blade;
        drawn.line = { blade.line[0] };
        constexpr int kSteps = 8;
        for (int step = 1; step <= kSteps; ++step) {
            drawn.line.push_back(blade.line[0] + (blade.line[1] - blade.line[0]) * step / kSteps);
            const mesh::CutResult result = wound.session.extend_stroke(drawn);
            ASSERT_EQ(result.status, mesh::CutStatus::done);
            wound.opening.follow(result.delta);
            OnlineAnswer answer = wound.opening.answer();
            const Eigen::VectorXd near = answer.displacement;
            const std::vector<Vec3> forces = answer.hook_forces_N;
            wound.opening.complete(answer);
            for (Eigen::Index i = 0; i < near.size(); ++i)
                if (near[i] != 0.0) {
                    EXPECT_NEAR(near[i], answer.displacement[i], 1e-12);
                }
            for (std::size_t h = 0; h < forces.size(); ++h)
                EXPECT_LT((forces[h] - answer.hook_forces_N[h]).norm(), 1e-10 * forces[h].norm());
            wound.expect_exact();
        }
    }

    TEST(OnlineOpening, FoldingOnAThreadOfItsOwnDoesNotTouchTheBits)
    {
        // Updated at once, and in the background with the steps quick or slow after each other.
        const auto stroke = [](int update_deltas, int wait_ms, int& is_updated) {
            // So many kept vertices that their dense system never pays.
            Wound wound(layered_box(), kTissues, { .update_vertices = 10, .update_deltas = update_deltas },
                Vec3(0.0, 3.0, 1.0), true);
            std::vector<Eigen::VectorXd> fields;
            const mesh::Blade blade = middle_blade(9.0, 3.0, 29.0);
            mesh::Blade drawn = blade;
            drawn.line = { blade.line[0] };
            constexpr int kSteps = 10;
            for (int step = 1; step <= kSteps; ++step) {
                drawn.line.push_back(blade.line[0] + (blade.line[1] - blade.line[0]) * step / kSteps);
                const mesh::CutResult result = wound.session.extend_stroke(drawn);
                EXPECT_EQ(result.status, mesh::CutStatus::done);
                wound.opening.follow(result.delta);
                const OnlineAnswer answer = whole_answer(wound.opening);
                EXPECT_EQ(answer.status, OnlineStatus::solved);
                is_updated += wound.opening.is_updated() ? 1 : 0;
                fields.push_back(answer.displacement);
                wound.expect_exact();
                // What is tested: that time, which the background thread has or has not, changes no bit.
                std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
            }
            return fields;
        };
        int at_once = 0, quick = 0, slow = 0;
        const auto reference = stroke(0, 0, at_once);
        const auto first = stroke(2, 0, quick), second = stroke(2, 30, slow);
        EXPECT_GT(at_once, 0);
        EXPECT_GT(quick, 0);
        EXPECT_EQ(quick, slow);
        for (std::size_t i = 0; i < first.size(); ++i) {
            EXPECT_EQ(first[i], second[i]) << "step " << i;
            EXPECT_LT(difference(first[i], reference[i]), kSameAnswer);
        }
    }

    /// A bar that a stroke goes along, under tension across where it is asked for; far more of it in the corridor than
    /// a step touches, so that the updated state drops vertices behind the knife.
    struct LongStroke {
        explicit LongStroke(bool under_tension, int update_deltas = 0)
            : bar(mesh::kuhn_box(18, 6, 4, 4.0))
            , session(bar)
        {
            OnlineOptions options { .update_vertices = 10, .update_deltas = update_deltas };
            Mat3 tension = Mat3::Zero();
            tension(1, 1) = 0.002;
            if (under_tension)
                options.stress_of_element.assign(bar.tet_count(), tension);
            opening = std::make_unique<OnlineOpening>(session, kTissues, bottom_fixed(bar),
                vertices_where(bar, [](const Vec3& p) { return p.z() > 1.0 && std::abs(p.y() - 12.0) < 9.0; }),
                options);
            hook("first", Vec3(4.0, 4.0, 16.0), Vec3(0.0, -1.5, 0.5));
            hook("last", Vec3(68.0, 20.0, 16.0), Vec3(0.0, 1.5, 0.5));
        }
        void hook(const char* name, const Vec3& at, const Vec3& pull)
        {
            OnlineHook made { .name = name, .side = 1, .nodes = {}, .drive = {} };
            made.nodes = vertices_where(
                bar, [&](const Vec3& p) { return p.z() > 15.0 && (p - at).head<2>().cwiseAbs().maxCoeff() < 4.1; });
            made.drive.displacement = pull;
            ids.push_back(opening->attach(made));
            hooks.push_back(made);
        }
        void step()
        {
            constexpr double kStep = 4.0;
            drawn.line.push_back(drawn.line.back() + Vec3(kStep, 0.05 * kStep, 0.0));
            const mesh::CutResult result = session.extend_stroke(drawn);
            ASSERT_EQ(result.status, mesh::CutStatus::done);
            opening->follow(result.delta, session.lips());
        }
        void expect_exact()
        {
            std::vector<Vec3> moved;
            for (const OnlineHook& each : hooks)
                moved.push_back(each.drive.displacement);
            const OnlineAnswer answer = whole_answer(*opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            EXPECT_LT(answer.residual, kResidual);
            const Eigen::VectorXd fresh = fresh_solution(session, kTissues, hooks, moved,
                opening->stiffness().loaded() ? opening->stiffness().load() : Eigen::VectorXd());
            EXPECT_LT(difference(answer.displacement, fresh), kSameAnswer);
            most_left = std::max(most_left, opening->dropped_vertices());
        }

        mesh::TetMesh bar;
        mesh::CutSession session;
        std::unique_ptr<OnlineOpening> opening;
        std::vector<OnlineHook> hooks;
        std::vector<HookId> ids;
        mesh::Blade drawn {
            .line = { Vec3(6.0, 10.7, 16.0) }, .directions = { Vec3(0.05, 0.1, -1.0) }, .depth_mm = 9.0
        };
        std::size_t most_left = 0;
    };

    TEST(OnlineOpening, WhatLiesBehindTheKnifeLeavesAndTheAnswerStaysExact)
    {
        for (const bool under_tension : { false, true })
            for (const int update_deltas : { 0, 2 }) {
                SCOPED_TRACE(std::to_string(under_tension) + " " + std::to_string(update_deltas));
                LongStroke stroke(under_tension, update_deltas);
                for (int i = 0; i < 13; ++i) {
                    stroke.step();
                    stroke.expect_exact();
                }
                EXPECT_GT(stroke.most_left, 30U);
                // Columns, hooks' forces included, are those of the answer.
                EXPECT_LT(stroke.opening->prepare_drag(), kResidual);
                const OnlineAnswer asked = whole_answer(*stroke.opening), dragged = stroke.opening->drag_answer();
                EXPECT_LT(difference(dragged.displacement, asked.displacement), kSameAnswer);
                for (std::size_t h = 0; h < stroke.hooks.size(); ++h)
                    EXPECT_LT((dragged.hook_forces_N[h] - asked.hook_forces_N[h]).norm(),
                        1e-9 * asked.hook_forces_N[h].norm());
            }
    }

    TEST(OnlineOpening, PartsGiveTheSameBitsOnOneThreadAndOnTwo)
    {
        const auto fields = [](int threads) {
            set_solver_threads(threads);
            Wound wound(layered_box(), kTissues, divided_body());
            std::vector<Eigen::VectorXd> found { whole_answer(wound.opening).displacement };
            wound.cut(middle_blade());
            EXPECT_EQ(wound.opening.route(), "dissected");
            found.push_back(whole_answer(wound.opening).displacement);
            wound.opening.follow(wound.session.undo());
            found.push_back(whole_answer(wound.opening).displacement);
            return found;
        };
        const auto one = fields(1), two = fields(2);
        for (std::size_t i = 0; i < one.size(); ++i)
            EXPECT_EQ(one[i], two[i]) << i;
    }

    TEST(OnlineOpening, ComingBackToWhatHasLeftIsExact)
    {
        const auto stroke_with_left = [] {
            auto stroke = std::make_unique<LongStroke>(false);
            for (int i = 0; i < 9; ++i) {
                stroke->step();
                stroke->expect_exact();
            }
            EXPECT_GT(stroke->opening->dropped_vertices(), 30U);
            return stroke;
        };
        { // a hook on dropped vertices
            const auto stroke = stroke_with_left();
            stroke->hook("on the dropped lip", Vec3(20.0, 8.0, 16.0), Vec3(0.0, -1.0, 0.0));
            stroke->expect_exact();
            stroke->step();
            stroke->expect_exact();
        }
        { // a second cut across the dropped vertices, then undone
            const auto stroke = stroke_with_left();
            const auto finished = stroke->session.finish_stroke();
            stroke->opening->follow(finished.delta);
            const mesh::Blade across { .line = { Vec3(18.3, 5.0, 16.0), Vec3(17.1, 19.0, 16.0) },
                .directions = { Vec3(0.0, 0.1, -1.0) },
                .depth_mm = 6.0 };
            const mesh::CutResult cut = stroke->session.cut(across);
            ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
            stroke->opening->follow(cut.delta);
            stroke->expect_exact();
            stroke->opening->follow(stroke->session.undo());
            stroke->expect_exact();
            stroke->opening->follow(stroke->session.undo());
            stroke->expect_exact();
        }
        { // a cut outside the corridor, which the body then keeps as well; the next steps make updated states again
            const auto stroke = stroke_with_left();
            const auto finished = stroke->session.finish_stroke();
            stroke->opening->follow(finished.delta);
            const mesh::Blade beside { .line = { Vec3(30.0, 2.1, 16.0), Vec3(38.0, 3.0, 16.0) },
                .directions = { Vec3(0.0, 0.0, -1.0) },
                .depth_mm = 3.0 };
            const mesh::CutResult cut = stroke->session.cut(beside);
            ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
            stroke->opening->follow(cut.delta);
            stroke->expect_exact();
        }
    }

    TEST(OnlineOpening, BothRoutesAndNoCorridorAtAllGiveOneAnswer)
    {
        const mesh::TetMesh box = layered_box();
        mesh::CutSession session(box);
        std::vector<OnlineHook> hooks { corner_hook(box, false, Vec3(-1.0, -2.0, 0.0)) };
        OnlineOpening planned(session, kTissues, bottom_fixed(box), middle(box));
        OnlineOpening wide(
            session, kTissues, bottom_fixed(box), vertices_where(box, [](const Vec3& p) { return p.z() > 1.0; }));
        OnlineOpening added(session, kTissues, bottom_fixed(box), {}, { .added_vertices = 10000 });
        OnlineOpening rebuilt(session, kTissues, bottom_fixed(box), {}, { .added_vertices = 0 });
        const mesh::CutResult cut = session.cut(middle_blade());
        ASSERT_EQ(cut.status, mesh::CutStatus::done);
        const Eigen::VectorXd fresh = fresh_solution(session, kTissues, hooks, { hooks[0].drive.displacement });
        std::set<std::string> routes;
        for (OnlineOpening* opening : { &planned, &wide, &added, &rebuilt }) {
            opening->attach(hooks[0]);
            opening->follow(cut.delta);
            const OnlineAnswer answer = whole_answer(*opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            EXPECT_LT(difference(answer.displacement, fresh), kSameAnswer) << opening->route();
            routes.insert(opening->route());
        }
        EXPECT_EQ(routes, (std::set<std::string> { "dense", "low rank" }));
    }

    TEST(OnlineOpening, HooksAttachedToADenseSystemAreExact)
    {
        const mesh::TetMesh box = layered_box();
        mesh::CutSession session(box);
        OnlineOpening opening(session, kTissues, bottom_fixed(box), middle(box));
        std::vector<OnlineHook> hooks;
        std::vector<Vec3> moved;
        // In the corridor, so that nothing has to be kept in addition.
        const auto patch = [&](double x, double y) {
            OnlineHook hook;
            hook.name = "patch";
            hook.nodes = vertices_where(box,
                [&](const Vec3& p) { return p.z() > 15.9 && std::abs(p.x() - x) < 4.5 && std::abs(p.y() - y) < 2.5; });
            hook.drive.displacement = Vec3(0.1, y > 16.0 ? 2.0 : -2.0, 0.5);
            return hook;
        };
        const auto attach = [&](const OnlineHook& hook) {
            hooks.push_back(hook);
            moved.push_back(hook.drive.displacement);
            return opening.attach(hook);
        };
        attach(patch(8.0, 20.0));
        const mesh::CutResult cut = session.cut(middle_blade(12.0));
        ASSERT_EQ(cut.status, mesh::CutStatus::done);
        opening.follow(cut.delta);
        ASSERT_EQ(whole_answer(opening).status, OnlineStatus::solved);
        ASSERT_EQ(opening.route(), "dense");
        const auto expect_exact = [&] {
            const OnlineAnswer answer = whole_answer(opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            EXPECT_LT(difference(answer.displacement, fresh_solution(session, kTissues, hooks, moved)), kSameAnswer);
            const std::vector<Vec3> near = opening.answer().hook_forces_N;
            for (std::size_t h = 0; h < near.size(); ++h)
                EXPECT_LT((near[h] - answer.hook_forces_N[h]).norm(), 1e-9 * near[h].norm());
        };
        attach(patch(24.0, 20.0));
        expect_exact();
        const HookId last = attach(patch(16.0, 12.0));
        expect_exact();
        EXPECT_LT(opening.prepare_drag(), kResidual);
        EXPECT_LT(difference(opening.drag(moved), fresh_solution(session, kTissues, hooks, moved)), kSameAnswer);
        opening.detach(last);
        hooks.pop_back();
        moved.pop_back();
        expect_exact();
        opening.follow(session.undo());
        expect_exact();
    }

    TEST(OnlineOpening, ACutOutsideTheCorridorIsExact)
    {
        for (const OnlineOptions& options : both_ways()) {
            Wound wound(layered_box(), kTissues, options);
            mesh::Blade aside = middle_blade(8.0);
            for (Vec3& p : aside.line)
                p.y() -= 11.0;
            const std::size_t planned = wound.opening.corridor_vertices();
            wound.cut(aside);
            wound.expect_exact();
            EXPECT_GT(wound.opening.corridor_vertices(), planned);
        }
    }

    TEST(OnlineOpening, ABodyThatOutgrowsItsCorridorIsTakenApartAndExact)
    {
        const mesh::TetMesh box
            = mesh::kuhn_box(60, 6, 4, 4.0); // long: its parts are far less work than one dense corridor
        const std::vector<Material> tissues(2, test_support::material(0.1, 0.4));
        const mesh::CutSession session(box);
        OnlineOpening opening(session, tissues, bottom_fixed(box),
            vertices_where(box, [](const Vec3& p) { return p.x() < 9.0 && p.z() > 11.0; }));
        OnlineHook slab;
        slab.name = "slab";
        slab.side = 1;
        slab.nodes = vertices_where(box, [](const Vec3& p) { return p.z() > 11.0; });
        slab.drive.displacement = Vec3(1.0, 2.0, 0.5);
        EXPECT_NE(opening.route(), "dissected");
        (void)opening.attach(slab);
        const OnlineAnswer answer = whole_answer(opening);
        ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
        EXPECT_EQ(opening.route(), "dissected");
        EXPECT_LT(
            difference(answer.displacement, fresh_solution(session, tissues, { slab }, { slab.drive.displacement })),
            kSameAnswer);
    }

    TEST(OnlineOpening, DetachingAndUndoingReturnToTheSameAnswer)
    {
        for (const OnlineOptions& options : both_ways()) {
            Wound wound(layered_box(), kTissues, options);
            const OnlineAnswer closed = whole_answer(wound.opening);
            wound.cut(middle_blade());
            const OnlineAnswer before = whole_answer(wound.opening);
            OnlineHook third;
            third.name = "third";
            const mesh::TetMesh box = layered_box();
            third.nodes = vertices_where(box, [](const Vec3& p) {
                return p.z() > 15.9 && std::abs(p.x() - 16.0) < 4.5 && p.y() > 21.0 && p.y() < 27.0;
            });
            third.drive.displacement = Vec3(0.0, 4.0, 0.0);
            const HookId id = wound.opening.attach(third);
            const OnlineAnswer held = whole_answer(wound.opening);
            ASSERT_EQ(held.status, OnlineStatus::solved) << held.message;
            std::vector<OnlineHook> all = wound.hooks;
            all.push_back(third);
            std::vector<Vec3> pulls = wound.pulls();
            pulls.push_back(third.drive.displacement);
            EXPECT_LT(difference(held.displacement, fresh_solution(wound.session, kTissues, all, pulls)), kSameAnswer);
            wound.opening.detach(id);
            EXPECT_LT(difference(whole_answer(wound.opening).displacement, before.displacement), kSameAnswer);
            wound.opening.follow(wound.session.undo());
            EXPECT_LT(difference(whole_answer(wound.opening).displacement, closed.displacement), kSameAnswer);
            wound.opening.follow(wound.session.redo());
            EXPECT_LT(difference(whole_answer(wound.opening).displacement, before.displacement), kSameAnswer);
        }
    }

    TEST(OnlineOpening, DraggingIsTheAnswerAndLinear)
    {
        for (const OnlineOptions& options : both_ways()) {
            Wound wound(layered_box(), kTissues, options);
            wound.cut(middle_blade());
            EXPECT_LT(wound.opening.prepare_drag(), kResidual);
            const std::vector<Vec3> moved { Vec3(0.5, -1.0, 2.0), Vec3(0.1, 2.0, -0.4) };
            const Eigen::VectorXd dragged = wound.opening.drag(moved);
            EXPECT_LT(difference(dragged, fresh_solution(wound.session, kTissues, wound.hooks, moved)), kSameAnswer);
            for (std::size_t h = 0; h < 2; ++h)
                wound.opening.drive(wound.ids[h], { .displacement = moved[h] });
            const OnlineAnswer answer = whole_answer(wound.opening);
            EXPECT_LT(difference(dragged, answer.displacement), kSameAnswer);
            const std::vector<Vec3> forces = wound.opening.drag_forces(moved);
            for (std::size_t h = 0; h < 2; ++h)
                EXPECT_LT((forces[h] - answer.hook_forces_N[h]).norm(), 1e-9 * answer.hook_forces_N[h].norm());
            wound.opening.drive(wound.ids[0], { .displacement = 100.0 * moved[0] }); // 200 mm: linear all the same
            wound.opening.drive(wound.ids[1], { .displacement = 100.0 * moved[1] });
            EXPECT_LT(difference(whole_answer(wound.opening).displacement, 100.0 * dragged), kSameAnswer);
            wound.opening.follow(wound.session.undo());
            EXPECT_THROW(wound.opening.drag(moved), InputError);
        }
    }

    TEST(OnlineOpening, HooksOnALipThatIsThenCutThrough)
    {
        for (const std::size_t apply_update : { std::size_t { 1 }, std::size_t { 100000 } }) {
            Wound wound(layered_box(), kTissues, { .update_vertices = apply_update });
            wound.cut(middle_blade(9.0, 5.0, 15.0));
            wound.expect_exact();
            wound.cut(middle_blade(9.0, 14.0, 27.0));
            wound.expect_exact();
            mesh::SlotMap map;
            const mesh::TetMesh mesh = wound.session.compact_mesh(&map);
            std::set<VertexId> lip; // added vertices among them
            for (const mesh::LipFace& face : wound.session.lips())
                if (face.side > 0)
                    for (const VertexId v : mesh::face_vertices(
                             mesh, { map.compact_tet[static_cast<std::size_t>(face.face.tet)], face.face.corner }))
                        if (const Vec3 p = mesh.vertices.row(v); std::abs(p.x() - 16.0) < 5.0 && p.z() > 9.0)
                            lip.insert(map.vertex_slot[static_cast<std::size_t>(v)]);
            OnlineHook hook;
            hook.name = "lip";
            hook.nodes.assign(lip.begin(), lip.end());
            hook.drive.displacement = Vec3(0.0, 2.0, 0.0);
            wound.opening.attach(hook);
            wound.hooks.push_back(hook);
            wound.expect_exact();
            mesh::Blade across { .line = { Vec3(16.0, 6.0, 16.0), Vec3(16.5, 26.0, 16.0) },
                .directions = { Vec3(0.0, 0.0, -1.0) },
                .depth_mm = 6.0 };
            wound.cut(across);
            wound.expect_exact();
            wound.opening.follow(wound.session.undo());
            wound.expect_exact();
            wound.opening.follow(wound.session.undo());
            wound.opening.follow(wound.session.undo()); // the lip itself is gone
            const OnlineAnswer lost = wound.opening.answer();
            EXPECT_EQ(lost.status, OnlineStatus::unsupported);
            EXPECT_NE(lost.message.find("hook 'lip' has lost its hold"), std::string::npos) << lost.message;
            EXPECT_TRUE(lost.lost_hook.has_value());
            wound.opening.follow(wound.session.redo());
            wound.opening.follow(wound.session.redo());
            wound.expect_exact();
        }
    }

    TEST(OnlineOpening, APieceThatComesOffIsRefusedByNameAndUndoingIsExact)
    {
        for (const OnlineOptions& options : both_ways()) {
            Wound wound(layered_box(), kTissues, options);
            const auto slice = [](double x0, double y0, double x1, double y1) {
                return mesh::Blade { .line = { Vec3(x0, y0, 16.0), Vec3(x1, y1, 16.0) },
                    .directions = { Vec3(0.0, 0.0, -1.0) },
                    .depth_mm = 20.0 };
            };
            // A corner without a hook, cut off straight down: its bottom stays fixed, so it is held.
            wound.cut(slice(20.0, -3.0, 35.0, 12.0));
            wound.expect_exact();
            wound.opening.follow(wound.session.undo());
            // The same corner under-cut by a level blade: now nothing holds it.
            wound.cut(slice(20.0, -3.0, 35.0, 12.0));
            const mesh::Blade level { .line = { Vec3(36.0, -4.0, 7.0), Vec3(15.0, -4.0, 7.0) },
                .directions = { Vec3(0.0, 1.0, 0.0) },
                .depth_mm = 22.0 };
            wound.cut(level);
            const OnlineAnswer off = wound.opening.answer();
            ASSERT_EQ(off.status, OnlineStatus::unsupported);
            EXPECT_NE(off.message.find("has neither a support nor a hook"), std::string::npos) << off.message;
            wound.opening.follow(wound.session.undo());
            wound.expect_exact();
        }
    }

    TEST(OnlineOpening, AnAblationTakesSupportsAndUndoingItGivesThemBack)
    {
        Wound wound;
        const mesh::TetMesh box = layered_box();
        std::vector<TetId> marked;
        for (const VertexId v : vertices_where(box, at_bottom))
            if ((box.vertices.row(v).transpose() - Vec3(16.0, 12.0, 0.0)).norm() < 4.5)
                for (const TetId t : wound.session.tets_at(v))
                    marked.push_back(t);
        const mesh::CutResult ablation = wound.session.ablate(marked);
        ASSERT_EQ(ablation.status, mesh::CutStatus::done);
        ASSERT_GE(ablation.delta.vertices_gone.size(), 3U);
        wound.opening.follow(ablation.delta);
        wound.expect_exact();
        wound.cut(middle_blade()); // free vertices under the ids of fixed ones
        for (const auto& gone : ablation.delta.vertices_gone)
            ASSERT_TRUE(wound.session.has_vertex(gone.id));
        wound.expect_exact();
        for (int times = 0; times < 2; ++times) {
            wound.opening.follow(wound.session.undo());
            wound.expect_exact();
            wound.opening.follow(wound.session.undo());
            wound.expect_exact();
            if (times == 1) { // nor does a factor that never knew of the ablation forget them
                wound.opening.start_rebuild();
                ASSERT_TRUE(wound.opening.adopt_rebuild());
                wound.expect_exact();
            }
            wound.opening.follow(wound.session.redo());
            wound.expect_exact();
            wound.opening.follow(wound.session.redo());
            wound.expect_exact();
        }
    }

    TEST(OnlineOpening, AHookHoldsItsVerticesNotWhatTheirIdsBecome)
    {
        Wound wound;
        const mesh::TetMesh box = layered_box();
        OnlineHook& near = wound.hooks[0];
        // The corner under the near hook is burnt away but for four of its vertices.
        std::vector<TetId> marked;
        for (const VertexId v : near.nodes)
            if (box.vertices(v, 0) + box.vertices(v, 1) < 6.0)
                for (const TetId t : wound.session.tets_at(v))
                    marked.push_back(t);
        std::sort(marked.begin(), marked.end());
        marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
        const mesh::CutResult ablation = wound.session.ablate(marked);
        ASSERT_EQ(ablation.status, mesh::CutStatus::done);
        const OnlineHook whole = near;
        std::erase_if(near.nodes, [&](VertexId v) { return !wound.session.has_vertex(v); });
        ASSERT_GE(near.nodes.size(), 3U);
        ASSERT_LT(near.nodes.size(), whole.nodes.size());
        wound.opening.follow(ablation.delta);
        wound.expect_exact();
        const std::string said = wound.opening.answer().message;
        EXPECT_EQ(said,
            "hook 'near' holds " + std::to_string(near.nodes.size()) + " of its " + std::to_string(whole.nodes.size())
                + " vertices: the others are gone");
        wound.cut(middle_blade()); // other vertices under the ids that became free
        std::size_t reused = 0;
        for (const VertexId v : whole.nodes)
            if (std::find(near.nodes.begin(), near.nodes.end(), v) == near.nodes.end())
                reused += wound.session.has_vertex(v) ? 1 : 0;
        ASSERT_GT(reused, 0U);
        wound.expect_exact();
        EXPECT_EQ(wound.opening.answer().message, said);
        wound.opening.start_rebuild();
        ASSERT_TRUE(wound.opening.adopt_rebuild());
        wound.expect_exact();
        wound.opening.follow(wound.session.undo());
        wound.expect_exact();
        near = whole;
        wound.opening.follow(wound.session.undo());
        wound.expect_exact();
        EXPECT_EQ(wound.opening.answer().message, "") << "it has all of them again";
        // The lip of a cut that was undone is not the lip of the next.
        wound.cut(middle_blade(9.0, 5.0, 20.0));
        OnlineHook lip;
        lip.name = "lip";
        lip.drive.displacement = Vec3(0.0, 1.0, 0.0);
        for (const mesh::LipFace& face : wound.session.lips())
            if (face.side > 0)
                for (const VertexId v : wound.session.tet(face.face.tet).nodes)
                    if (static_cast<std::size_t>(v) >= box.vertex_count()
                        && std::find(lip.nodes.begin(), lip.nodes.end(), v) == lip.nodes.end())
                        lip.nodes.push_back(v);
        ASSERT_GE(lip.nodes.size(), 3U);
        wound.opening.attach(lip);
        wound.opening.follow(wound.session.undo());
        wound.cut(middle_blade(6.0, 11.0, 27.0));
        EXPECT_EQ(wound.opening.answer().status, OnlineStatus::unsupported);
        EXPECT_NE(wound.opening.answer().message.find("hook 'lip' has lost its hold"), std::string::npos);
    }

    TEST(OnlineOpening, ARebuiltFactorIsSwappedInAndFollowsAsBefore)
    {
        for (const OnlineOptions& options : both_ways()) {
            Wound wound(layered_box(), kTissues, options);
            wound.cut(middle_blade(7.0, 8.0, 20.0));
            EXPECT_FALSE(wound.opening.adopt_rebuild());
            wound.opening.start_rebuild();
            wound.cut(middle_blade(9.0, 18.0, 28.0)); // while it is being made
            wound.expect_exact();
            EXPECT_TRUE(wound.opening.adopt_rebuild());
            wound.expect_exact();
            wound.opening.follow(wound.session.undo());
            wound.expect_exact();
            wound.opening.follow(wound.session.undo()); // vertices that the new factor knows are gone
            wound.expect_exact();
            std::mt19937 random(11);
            wound.cut(test_support::random_blade(random, kBox)); // and their ids come back elsewhere
            wound.expect_exact();
        }
    }

    TEST(OnlineOpening, CuttingSetsTensionFreeAndTheWoundGapesWithoutHooks)
    {
        Mat3 tension = Mat3::Zero();
        tension(1, 1) = 0.01;
        for (OnlineOptions options :
            { OnlineOptions { .update_vertices = 1 }, OnlineOptions { .update_vertices = 100000 }, divided_body() }) {
            const mesh::TetMesh box = layered_box();
            for (const Label label : box.labels)
                options.stress_of_element.push_back(label == 2 ? tension : Mat3(Mat3::Zero()));
            mesh::CutSession session(box);
            OnlineOpening opening(session, kTissues, bottom_fixed(box), middle(box), options);
            EXPECT_EQ(whole_answer(opening).displacement.norm(), 0.0);
            const mesh::CutResult cut = session.cut(middle_blade());
            ASSERT_EQ(cut.status, mesh::CutStatus::done);
            opening.follow(cut.delta, session.lips());
            const OnlineAnswer answer = whole_answer(opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            EXPECT_LT(
                difference(answer.displacement, fresh_solution(session, kTissues, {}, {}, opening.stiffness().load())),
                kSameAnswer);
            double gape = 0.0; // a vertex and its copy on the other lip part along y
            for (const mesh::MeshDelta::VertexBorn& born : cut.delta.vertices_born)
                if (born.origin == mesh::MeshDelta::Origin::copy)
                    gape = std::max(
                        gape, std::abs(answer.displacement[3 * born.id + 1] - answer.displacement[3 * born.a + 1]));
            EXPECT_GT(gape, 0.1);
            // With hooks, dragging holds the stress as well.
            const OnlineHook hook = corner_hook(box, false, Vec3(0.0, -1.0, 0.0));
            opening.attach(hook);
            EXPECT_LT(opening.prepare_drag(), kResidual);
            const std::vector<Vec3> moved { Vec3(0.3, -2.0, 0.0) };
            EXPECT_LT(difference(opening.drag(moved),
                          fresh_solution(session, kTissues, { hook }, moved, opening.stiffness().load())),
                kSameAnswer);
            for (int more = 0; more < 3; ++more) { // further cuts after the updated state has dropped the lips
                const mesh::CutResult next = session.cut(middle_blade(6.0 - more, 10.0 + 2.0 * more, 30.0));
                ASSERT_NE(next.status, mesh::CutStatus::cancelled);
                opening.follow(next.delta, session.lips());
                const OnlineAnswer again = whole_answer(opening);
                ASSERT_EQ(again.status, OnlineStatus::solved) << again.message;
                EXPECT_LT(difference(again.displacement,
                              fresh_solution(session, kTissues, { hook }, { hook.drive.displacement },
                                  opening.stiffness().load())),
                    kSameAnswer);
            }
            while (session.can_undo()) {
                const mesh::MeshDelta undone = session.undo();
                opening.follow(undone, session.lips());
            }
            opening.detach(opening.answer().hooks[0]);
            EXPECT_LT(whole_answer(opening).displacement.lpNorm<Eigen::Infinity>(), 1e-12) << "closed again, mm";
        }
    }

    TEST(OnlineOpening, AWoundInASheetUnderTensionGapesAsTheClosedFormSays)
    {
        constexpr double kModulus = 0.2, kRatio = 0.25, kStrain = 0.02;
        // The rim is held where it is, at 15 half lengths of the cut: its pull is of order (1/15)^2.
        const verification::SheetProblem problem { .radius = 600.0, .around = 96 };
        const mesh::TetMesh sheet = verification::sheet_mesh(problem);
        const std::vector<Material> skin(2, test_support::material(kModulus, kRatio));
        for (const PreStrainKind kind : { PreStrainKind::uniaxial_stress, PreStrainKind::equibiaxial }) {
            mesh::CutSession session(sheet);
            OnlineOptions options;
            options.stress_of_element = verification::stress_of_elements(
                sheet, skin, std::vector<PreStrain>(2, { kind, kStrain, Vec3::UnitY(), Vec3::UnitZ() }));
            OnlineOpening opening(session, skin, { .fixed = verification::sheet_rim(problem, sheet) }, {}, options);
            const mesh::CutResult cut = session.cut(verification::sheet_blade(problem));
            ASSERT_EQ(cut.status, mesh::CutStatus::done);
            opening.follow(cut.delta, session.lips());
            const OnlineAnswer answer = whole_answer(opening);
            ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
            double gape = 0.0;
            int count = 0;
            for (const auto& born : cut.delta.vertices_born)
                if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < 1e-9) {
                    gape += std::abs(answer.displacement[3 * born.id + 1] - answer.displacement[3 * born.a + 1]);
                    ++count;
                }
            ASSERT_GT(count, 0);
            const double right = verification::sheet_gape(kind, kStrain, problem.cut_length, kRatio);
            EXPECT_NEAR(gape / count / right, 1.0, 0.02) << "discretisation and rim";
        }
    }

    TEST(OnlineOpening, ForceDrivenLimitedAndSoftHooks)
    {
        Wound wound;
        wound.cut(middle_blade());
        const Vec3 force(0.01, 0.2, 0.05);
        wound.opening.drive(wound.ids[1], { .force_N = force });
        OnlineAnswer answer = whole_answer(wound.opening);
        EXPECT_LT((answer.hook_forces_N[1] - force).norm(), 1e-9 * force.norm());
        // Prescribing where it came to rest asks for the same force.
        wound.hooks[1].drive.displacement = answer.hook_displacements[1];
        EXPECT_LT(
            difference(answer.displacement, fresh_solution(wound.session, kTissues, wound.hooks, wound.pulls())), 1e-9);
        const Vec3 target(0.0, 6.0, 0.0);
        wound.opening.drive(wound.ids[1], { .displacement = target });
        const double unlimited = whole_answer(wound.opening).hook_forces_N[1].norm();
        wound.opening.drive(wound.ids[1], { .displacement = target, .force_limit_N = 0.5 * unlimited });
        answer = whole_answer(wound.opening);
        EXPECT_TRUE(answer.hook_yielded[1]);
        EXPECT_NEAR(answer.hook_forces_N[1].norm(), 0.5 * unlimited, 1e-8 * unlimited);
        const Vec3 slip = target - answer.hook_displacements[1];
        EXPECT_GT(slip.dot(answer.hook_forces_N[1]), 0.999999 * slip.norm() * answer.hook_forces_N[1].norm());
        wound.opening.drive(wound.ids[1], { .displacement = target, .force_limit_N = 2.0 * unlimited });
        EXPECT_FALSE(whole_answer(wound.opening).hook_yielded[1]);
        constexpr double kGrip = 0.05;
        wound.opening.drive(wound.ids[1], { .displacement = target, .grip_N_per_mm = kGrip });
        answer = whole_answer(wound.opening);
        EXPECT_LT((kGrip * (target - answer.hook_displacements[1]) - answer.hook_forces_N[1]).norm(), 1e-9);
        // Dragging knows of grips, limits and forces as well.
        EXPECT_THROW((void)wound.opening.drag_answer(), InputError);
        EXPECT_LT(wound.opening.prepare_drag(), kResidual);
        for (const HookDrive& drive : { HookDrive { .displacement = target, .grip_N_per_mm = kGrip },
                 HookDrive { .displacement = target, .force_limit_N = 0.5 * unlimited }, HookDrive { .force_N = force },
                 HookDrive { .displacement = target } }) {
            wound.opening.drive(wound.ids[1], drive);
            const OnlineAnswer dragged = wound.opening.drag_answer();
            answer = whole_answer(wound.opening);
            EXPECT_TRUE(dragged.whole);
            EXPECT_EQ(dragged.hook_yielded, answer.hook_yielded);
            EXPECT_LT(difference(dragged.displacement, answer.displacement), kSameAnswer);
            for (std::size_t h = 0; h < 2; ++h)
                EXPECT_LT((dragged.hook_forces_N[h] - answer.hook_forces_N[h]).norm(), 1e-9 * unlimited);
        }
    }

    TEST(OnlineOpening, NearlyIncompressibleAndBoneBesideFat)
    {
        {
            Wound wound(layered_box(),
                { test_support::material(1.0, 0.3), test_support::material(0.02, 0.49),
                    test_support::material(0.2, 0.49) });
            wound.cut(middle_blade());
            wound.expect_exact(1e-9);
        }
        mesh::TetMesh box = layered_box(); // bone 1e6 times as stiff as the fat round it
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            box.labels[static_cast<std::size_t>(t)] = box.vertices(box.tet(t)[0], 0) >= 20.0 ? 2 : 1;
        Wound wound(box,
            { test_support::material(1.0, 0.3), test_support::material(0.01, 0.45), test_support::material(1e4, 0.3) });
        wound.cut(middle_blade());
        const OnlineAnswer answer = whole_answer(wound.opening);
        ASSERT_EQ(answer.status, OnlineStatus::solved) << answer.message;
        EXPECT_LT(answer.residual, kResidual);
        EXPECT_GT(answer.reciprocal_condition, 0.0);
        constexpr double kStiffContrast = 1e-7; // round-off times the contrast of 1e6 and some digits
        EXPECT_LT(
            difference(answer.displacement, fresh_solution(wound.session, wound.materials, wound.hooks, wound.pulls())),
            kStiffContrast);
    }

    template <class Call> void expect_refused(const Call& call, const std::string& what, const std::string& where)
    {
        try {
            call();
            FAIL() << "not refused: " << what;
        } catch (const Error& error) {
            EXPECT_NE((std::string(error.what()) + " " + error.where()).find(what), std::string::npos) << error.what();
            EXPECT_NE(error.where().find(where), std::string::npos) << error.where();
        }
    }

    TEST(OnlineOpening, RefusesBadHooksAndBodiesThatFloat)
    {
        Wound wound;
        const mesh::TetMesh box = layered_box();
        const double nan = std::numeric_limits<double>::quiet_NaN();
        OnlineHook hook = corner_hook(box, false, Vec3::Zero());
        const auto attach = [&] { wound.opening.attach(hook); };
        hook.name = "again";
        expect_refused(attach, "two hooks hold one vertex", "hook 'again'");
        hook.nodes = { 0, 1, 2 };
        expect_refused(attach, "fixed", "vertex 0");
        hook.nodes = vertices_where(box, [](const Vec3& p) { return (p - Vec3(16.0, 4.0, 16.0)).norm() < 0.1; });
        expect_refused(attach, "never a point", "hook 'again'");
        hook.nodes = { 100000, 100001, 100002 };
        expect_refused(attach, "no such vertex", "vertex 100000");
        expect_refused([&] { wound.opening.drive(wound.ids[0], { .displacement = Vec3(0.0, nan, 0.0) }); }, "finite",
            "hook 'near'");
        expect_refused(
            [&] { wound.opening.drive(wound.ids[0], { .force_limit_N = -1.0 }); }, "positive", "hook 'near'");
        expect_refused([&] { wound.opening.drive(77, {}); }, "no such hook", "hook 77");
        expect_refused([&] { wound.opening.detach(77); }, "no such hook", "hook 77");
        expect_refused(
            [&] { OnlineOpening(mesh::CutSession(box), kTissues, {}, {}); }, "neither a support nor a hook", "");
        expect_refused(
            [&] {
                OnlineOpening(mesh::CutSession(box), kTissues, { { -4 }, {} }, {});
            },
            "no such vertex", "vertex -4");
        mesh::MeshDelta wrong;
        wrong.tets_gone.push_back({ 3, { 0, 1, 2, 3 }, 1, 3 });
        EXPECT_THROW(wound.opening.follow(wrong), InputError);
        wound.expect_exact(); // all of this has changed nothing
    }

} // namespace online_opening_test
} // namespace retractor::fem
