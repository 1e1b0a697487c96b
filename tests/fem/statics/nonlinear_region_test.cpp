#include "fem/statics/nonlinear_region.h"

#include "fem/statics/condensed_region.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/equilibrium.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <atomic>
#include <limits>
#include <string>

namespace retractor::fem {
namespace nonlinear_region_test {

    using namespace test_support;

    constexpr double kTight = 1e-9; // settled so far, answers by different ways agree to kSame
    constexpr double kSame = 1e-6; // of the largest displacement

    double difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
    {
        return (a - b).lpNorm<Eigen::Infinity>() / b.lpNorm<Eigen::Infinity>();
    }

    std::vector<std::uint8_t> all_near(const mesh::TetMesh& mesh)
    {
        return std::vector<std::uint8_t>(mesh.tet_count(), 1);
    }

    NonlinearRegion nonlinear_region(const ElasticProblem& p, const std::vector<std::uint8_t>& near,
        NonlinearRegionOptions options = { .tolerance = kTight })
    {
        return { p.mesh, p.material_of_label, p.supports, p.hooks, near, options };
    }

    std::vector<Vec3> hooks_at(const ElasticProblem& problem, double share)
    {
        std::vector<Vec3> at;
        for (const HookPatch& hook : problem.hooks)
            at.push_back(share * hook.displacement);
        return at;
    }

    ElasticBody neo_hookean_body(const ElasticProblem& problem)
    {
        HyperelasticTissue tissue;
        for (const Material& material : problem.material_of_label) {
            const Lame l = material.youngs_modulus_MPa > 0.0 ? lame(material) : Lame { 1.0, 1.0 };
            tissue.laws.emplace_back(NeoHookean { l.mu, l.lambda });
        }
        for (const Label label : problem.mesh.labels)
            tissue.law_of_element.push_back(label);
        return { problem.mesh, std::move(tissue) };
    }

    Equilibrium exact(const ElasticProblem& problem, ElasticBody& body)
    {
        body.set_bed(bed_stiffness(problem.mesh, problem.supports));
        const Prescribed prescribed = prescribe(problem.mesh, problem.supports, problem.hooks);
        EquilibriumSolver solver;
        return solver.solve(body, prescribed.flag, prescribed.value,
            Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows()), { .tolerance = kTight }, {});
    }

    TEST(CondensedRegion, CondensesOntoTheRimWhateverHoldsIt)
    {
        // The rim are the nodes of the top of a box; the box is loose but for two fixed nodes, so that its stiffness on
        // the rim is singular: it can turn about the line through them.
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 5.0); // nodes in layers from below
        const std::size_t rim = 9, nodes = mesh.vertex_count();
        ElasticBody body(mesh, Elasticity::linear, std::vector<Lame>(mesh.tet_count(), Lame { 0.01, 0.05 }));
        std::vector<std::uint8_t> fixed(nodes, 0);
        fixed[0] = fixed[2] = 1;
        const CondensedRegion far(body, fixed, rim);

        const auto n = 3 * static_cast<Eigen::Index>(nodes), r = 3 * static_cast<Eigen::Index>(rim);
        Eigen::MatrixXd K(n, n);
        for (Eigen::Index i = 0; i < n; ++i)
            K.col(i) = body.last_stiffness().multiply(Eigen::VectorXd::Unit(n, i));
        for (const Eigen::Index v : { 0, 2 }) {
            K.middleRows(3 * v, 3).setZero();
            K.middleCols(3 * v, 3).setZero();
            K.block<3, 3>(3 * v, 3 * v).setIdentity();
        }
        const Eigen::MatrixXd inner = K.topLeftCorner(n - r, n - r), across = K.topRightCorner(n - r, r);
        const Eigen::MatrixXd follow = -inner.ldlt().solve(across);
        const Eigen::MatrixXd schur = K.bottomRightCorner(r, r) + across.transpose() * follow;
        constexpr double kRoundOff = 1e-12;
        EXPECT_LT((far.stiffness() - schur).cwiseAbs().maxCoeff(), kRoundOff * schur.cwiseAbs().maxCoeff() * 10.0);
        const Eigen::VectorXd moved = Eigen::VectorXd::LinSpaced(r, -1.0, 2.0);
        const Eigen::VectorXd field = far.field(moved);
        EXPECT_LT((field.head(n - r) - follow * moved).lpNorm<Eigen::Infinity>(), 1e-10);
        EXPECT_EQ(field.tail(r), moved);
    }

    TEST(NonlinearRegion, WithEverythingNearIsTheFullyNonlinearProblem)
    {
        for (const int nodes_per_tet : { 4, 10 }) {
            const ElasticProblem problem = test_support::hooked_block(nodes_per_tet == 4 ? 4 : 2, nodes_per_tet);
            NonlinearRegion field = nonlinear_region(problem, all_near(problem.mesh));
            EXPECT_EQ(field.rim_vertices(), 0U);
            const NearFrame dragged = field.drag(hooks_at(problem, 1.0));
            EXPECT_TRUE(dragged.reached);
            const NearFrame settled = field.settle();
            ASSERT_EQ(settled.status, NearStatus::settled) << settled.message;
            ElasticBody body = neo_hookean_body(problem);
            const Equilibrium reference = exact(problem, body);
            ASSERT_EQ(reference.status, EquilibriumStatus::converged);
            EXPECT_LT(difference(settled.displacement, reference.displacement), kSame);
            const Prescribed prescribed = prescribe(problem.mesh, problem.supports, problem.hooks);
            const std::vector<Vec3> forces = hook_forces(reference.forces, prescribed, 2);
            for (std::size_t h = 0; h < 2; ++h)
                EXPECT_LT((settled.hook_forces_N[h] - forces[h]).norm(), kSame * forces[h].norm());
        }
    }

    TEST(NonlinearRegion, TakesTheRotatingModelsToo)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        for (const Elasticity model : { Elasticity::corotational, Elasticity::corotational_linear }) {
            NonlinearRegion field
                = nonlinear_region(problem, all_near(problem.mesh), { .elasticity = model, .tolerance = kTight });
            (void)field.drag(hooks_at(problem, 1.0));
            const NearFrame settled = field.settle();
            ASSERT_EQ(settled.status, NearStatus::settled) << settled.message;
            ElasticBody body(problem.mesh, model, element_parameters(problem.mesh, problem.material_of_label));
            EXPECT_LT(difference(settled.displacement, exact(problem, body).displacement), kSame);
        }
    }

    TEST(NonlinearRegion, BoundedTissueComesToRestFromAnyAnswerAndLetsHooksPassFlatElements)
    {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        // Two elements of 0.01 mm height at a hook: neo-Hookean tissue lets it move by no more.
        for (const TetId flat : { 0, 17 }) {
            const auto nodes = problem.mesh.tet(flat);
            const Vec3 a = problem.mesh.vertices.row(nodes[0]), b = problem.mesh.vertices.row(nodes[1]),
                       c = problem.mesh.vertices.row(nodes[2]);
            const Vec3 normal = (b - a).cross(c - a).normalized();
            const Vec3 d = problem.mesh.vertices.row(nodes[3]);
            problem.mesh.vertices.row(nodes[3]) = d - (normal.dot(d - a) - 0.01) * normal;
        }
        const auto near = all_near(problem.mesh);
        NonlinearRegion dragged
            = nonlinear_region(problem, near, { .elasticity = Elasticity::corotational_linear, .tolerance = kTight });
        EXPECT_TRUE(dragged.drag(hooks_at(problem, 1.0)).reached);
        const NearFrame right = dragged.settle();
        ASSERT_EQ(right.status, NearStatus::settled) << right.message;
        NearFrame wrong = right;
        wrong.displacement *= -3.0; // most elements turned over
        for (Vec3& hook : wrong.hook_displacements)
            hook *= -3.0;
        NonlinearRegion other
            = nonlinear_region(problem, near, { .elasticity = Elasticity::corotational_linear, .tolerance = kTight });
        other.start_from(wrong);
        (void)other.drag(hooks_at(problem, 1.0));
        const NearFrame back = other.settle();
        ASSERT_EQ(back.status, NearStatus::settled) << back.message;
        EXPECT_LT(back.residual, kTight);
        EXPECT_LT(difference(back.displacement, right.displacement), kSame) << "the block has one rest";
    }

    TEST(NonlinearRegion, LoadsAreBorneAsByTheLinearBodyWhereTheyAreSmall)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        const std::vector<std::uint8_t> near = test_support::near_hooks(problem);
        Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
        VertexId loaded = -1, far = -1;
        std::vector<std::uint8_t> is_near(problem.mesh.vertex_count(), 0);
        for (std::size_t t = 0; t < near.size(); ++t)
            for (const VertexId v : problem.mesh.tet(static_cast<TetId>(t)))
                is_near[static_cast<std::size_t>(v)] |= near[t];
        const Prescribed prescribed = prescribe(problem.mesh, problem.supports, problem.hooks);
        for (VertexId v = 0; v < static_cast<VertexId>(is_near.size()); ++v)
            if (prescribed.flag[3 * static_cast<std::size_t>(v)] == 0)
                (is_near[static_cast<std::size_t>(v)] != 0 ? loaded : far) = v;
        constexpr double kSmallN = 1e-4, kLinear = 1e-3; // strains of about as much
        load.segment<3>(3 * loaded) = Vec3(kSmallN, -kSmallN, 0.5 * kSmallN);
        ElasticBody body(problem.mesh, Elasticity::linear, element_parameters(problem.mesh, problem.material_of_label));
        body.set_loads({ .nodal = load });
        ElasticProblem still = problem;
        for (HookPatch& hook : still.hooks)
            hook.displacement.setZero();
        const Equilibrium reference = exact(still, body);
        for (const Elasticity model : { Elasticity::hyperelastic, Elasticity::corotational_linear }) {
            NonlinearRegion field
                = nonlinear_region(problem, near, { .elasticity = model, .tolerance = kTight, .load = load });
            const NearFrame settled = field.settle();
            ASSERT_EQ(settled.status, NearStatus::settled) << settled.message;
            EXPECT_LT(difference(settled.displacement, reference.displacement), kLinear);
        }
        // Without hooks: no node of the near part is held, and no force is left there by which to judge the others.
        ElasticProblem unhooked = problem;
        unhooked.hooks.clear();
        const Equilibrium free = exact(unhooked, body);
        constexpr double kSeenByEnergy = 1e-5; // forces of 1e-9 N change an energy of the block's by its round-off
        NonlinearRegion field = nonlinear_region(unhooked, near,
            { .elasticity = Elasticity::corotational_linear, .tolerance = kSeenByEnergy, .load = load });
        const NearFrame settled = field.settle();
        ASSERT_EQ(settled.status, NearStatus::settled) << settled.message;
        EXPECT_LT(difference(settled.displacement, free.displacement), kLinear);
        load[3 * far] = 1.0;
        EXPECT_NE(test_support::message_of([&] {
            (void)nonlinear_region(problem, near, { .load = load });
        }).find("a node that is not near is loaded"),
            std::string::npos);
        EXPECT_EQ(test_support::message_of(
                      [&] { (void)nonlinear_region(problem, near, { .load = Eigen::VectorXd::Zero(3) }); }),
            "nonlinear region: a load has three entries per vertex");
    }

    TEST(NonlinearRegion, LeavesNoForceOnAnyFreeNodeOfEitherPart)
    {
        // Near and far elements put together again by themselves: their forces cancel at each free node.
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        const std::vector<std::uint8_t> near = test_support::near_hooks(problem);
        NonlinearRegion field = nonlinear_region(problem, near);
        EXPECT_GT(field.rim_vertices(), 0U);
        EXPECT_LT(field.near_elements(), problem.mesh.tet_count() / 2 + problem.mesh.tet_count() / 4);
        (void)field.drag(hooks_at(problem, 1.0));
        const NearFrame settled = field.settle();
        ASSERT_EQ(settled.status, NearStatus::settled) << settled.message;
        const std::vector<Lame> lame = element_parameters(problem.mesh, problem.material_of_label);
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(settled.displacement.size());
        for (std::size_t t = 0; t < problem.mesh.tet_count(); ++t) {
            const auto nodes = problem.mesh.tet(static_cast<TetId>(t));
            mesh::TetMesh one { Points(4, 3), 4, { 0, 1, 2, 3 }, { 1 } };
            Eigen::VectorXd u(12);
            for (int a = 0; a < 4; ++a) {
                one.vertices.row(a) = problem.mesh.vertices.row(nodes[static_cast<std::size_t>(a)]);
                u.segment<3>(3 * a) = settled.displacement.segment<3>(3 * nodes[static_cast<std::size_t>(a)]);
            }
            const ElasticBody body = near[t] != 0
                ? ElasticBody(one, verification::uniform_tissue(one, NeoHookean { lame[t].mu, lame[t].lambda }))
                : ElasticBody(one, Elasticity::linear, { lame[t] });
            const Eigen::VectorXd f = body.response(u).forces;
            for (int a = 0; a < 4; ++a)
                forces.segment<3>(3 * nodes[static_cast<std::size_t>(a)]) += f.segment<3>(3 * a);
        }
        const std::vector<double> bed = bed_stiffness(problem.mesh, problem.supports);
        const Prescribed prescribed = prescribe(problem.mesh, problem.supports, problem.hooks);
        double largest = 0.0, free = 0.0;
        for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v) {
            const Vec3 f
                = forces.segment<3>(3 * v) + bed[static_cast<std::size_t>(v)] * settled.displacement.segment<3>(3 * v);
            largest = std::max(largest, f.norm());
            if (prescribed.flag[static_cast<std::size_t>(3 * v)] == 0)
                free = std::max(free, f.norm());
        }
        EXPECT_LT(free, 10.0 * kTight * largest);
    }

    TEST(NonlinearRegion, SaysWhatTheFarTissuesOwnLawWouldChange)
    {
        // Newton's step is off by the square of its length: told ever better as the hooks move less.
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        for (const Elasticity elasticity : { Elasticity::hyperelastic, Elasticity::corotational }) {
            std::vector<double> field_off, force_off;
            for (const double share : { 0.2, 0.1 }) {
                NonlinearRegion linear = nonlinear_region(problem, test_support::near_hooks(problem),
                                    { .elasticity = elasticity, .tolerance = kTight }),
                                whole = nonlinear_region(
                                    problem, all_near(problem.mesh), { .elasticity = elasticity, .tolerance = kTight });
                (void)linear.drag(hooks_at(problem, share));
                (void)linear.settle();
                linear.refresh();
                const NearFrame before = linear.settle();
                const FarChange told = linear.far_change();
                ASSERT_TRUE(told.finite);
                (void)whole.drag(hooks_at(problem, share));
                const NearFrame after = whole.settle();
                const Eigen::VectorXd change = after.displacement - before.displacement;
                field_off.push_back((told.displacement - change).norm() / change.norm());
                const Vec3 force = after.hook_forces_N[0] - before.hook_forces_N[0];
                force_off.push_back((told.hook_forces_N[0] - force).norm() / force.norm());
            }
            EXPECT_LT(field_off[0], 0.5);
            EXPECT_LT(field_off[1], 0.65 * field_off[0]);
            EXPECT_LT(force_off[0], 0.5);
            EXPECT_LT(force_off[1], 0.65 * force_off[0]);
        }
    }

    TEST(NonlinearRegion, HasNothingToChangeWithoutACondensedRegion)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        NonlinearRegion field = nonlinear_region(problem, all_near(problem.mesh));
        (void)field.drag(hooks_at(problem, 0.5));
        const FarChange change = field.far_change();
        EXPECT_TRUE(change.finite);
        EXPECT_EQ(change.displacement, Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows()));
    }

    TEST(NonlinearRegion, BecomesLinearElasticityAsTheHooksMoveLess)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        ElasticBody body(problem.mesh, Elasticity::linear, element_parameters(problem.mesh, problem.material_of_label));
        const Eigen::VectorXd linear = exact(problem, body).displacement;
        std::vector<double> off;
        for (const double share : { 0.02, 0.01 }) {
            NonlinearRegion field = nonlinear_region(problem, test_support::near_hooks(problem));
            (void)field.drag(hooks_at(problem, share));
            off.push_back(difference(field.settle().displacement / share, linear));
        }
        EXPECT_LT(off[0], 0.05);
        EXPECT_NEAR(off[0] / off[1], 2.0, 0.1); // first order in the motion
    }

    TEST(NonlinearRegion, SettlesInTheSamePlaceByAnyWay)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        NonlinearRegion at_once = nonlinear_region(problem, test_support::near_hooks(problem)),
                        by_frames = nonlinear_region(problem, test_support::near_hooks(problem));
        (void)at_once.drag(hooks_at(problem, 1.0));
        constexpr int kFrames = 20;
        for (int f = 1; f <= kFrames; ++f) // on, somewhat too far, and back
            (void)by_frames.drag(hooks_at(problem, 1.3 * f / kFrames));
        const NearFrame frame = by_frames.drag(hooks_at(problem, 1.0));
        const NearFrame settled = by_frames.settle();
        EXPECT_LT(difference(settled.displacement, at_once.settle().displacement), kSame);
        EXPECT_LT(difference(frame.displacement, settled.displacement), 0.02); // what the eye is shown
        EXPECT_LE(settled.residual, kTight);
        EXPECT_GT(frame.residual, settled.residual);
    }

    TEST(NonlinearRegion, HooksSlipAtTheirLimit)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        for (const Elasticity model : { Elasticity::hyperelastic, Elasticity::corotational_linear }) {
            const NonlinearRegionOptions options { .elasticity = model, .tolerance = kTight };
            NonlinearRegion free = nonlinear_region(problem, test_support::near_hooks(problem), options);
            (void)free.drag(hooks_at(problem, 1.0));
            const NearFrame unlimited = free.settle();
            ASSERT_EQ(unlimited.status, NearStatus::settled);
            const double limit = 0.7 * unlimited.hook_forces_N[0].norm();
            NonlinearRegion limited = nonlinear_region(problem, test_support::near_hooks(problem), options);
            std::vector<HookDrive> drives = prescribed_drives(hooks_at(problem, 1.0));
            for (HookDrive& drive : drives)
                drive.force_limit_N = limit;
            (void)limited.drag(drives);
            const NearFrame rest = limited.settle();
            ASSERT_EQ(rest.status, NearStatus::settled) << rest.message;
            bool any = false;
            for (std::size_t h = 0; h < 2; ++h) {
                const Vec3 slip = problem.hooks[h].displacement - rest.hook_displacements[h];
                const Vec3 force = rest.hook_forces_N[h];
                if (rest.hook_yielded[h]) {
                    any = true;
                    EXPECT_NEAR(force.norm(), limit, kSame * limit);
                    EXPECT_NEAR(slip.dot(force), slip.norm() * force.norm(), kSame * slip.norm() * force.norm());
                } else {
                    EXPECT_EQ(slip.norm(), 0.0);
                    EXPECT_LE(force.norm(), limit);
                }
            }
            EXPECT_TRUE(any);
            // It is where it would be with the hooks held there.
            (void)free.drag(rest.hook_displacements);
            EXPECT_LT(difference(free.settle().displacement, rest.displacement), kSame);
            // Let go again, they go all the way.
            (void)limited.drag(hooks_at(problem, 1.0));
            const NearFrame again = limited.settle();
            EXPECT_EQ(again.hook_yielded, std::vector<bool>(2, false));
            EXPECT_LT(difference(again.displacement, unlimited.displacement), kSame);
            for (const double wrong : { 0.0, std::numeric_limits<double>::quiet_NaN() }) {
                drives[1].force_limit_N = wrong;
                EXPECT_NE(test_support::message_of([&] { (void)limited.drag(drives); }).find("must be positive"),
                    std::string::npos);
            }
        }
    }

    TEST(NonlinearRegion, HooksThatPullWithAForceRestWhereAPositionBearsIt)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        for (const Elasticity model : { Elasticity::hyperelastic, Elasticity::corotational_linear }) {
            const NonlinearRegionOptions options { .elasticity = model, .tolerance = kTight };
            NonlinearRegion drawn = nonlinear_region(problem, test_support::near_hooks(problem), options);
            (void)drawn.drag(hooks_at(problem, 1.0));
            const NearFrame there = drawn.settle();
            ASSERT_EQ(there.status, NearStatus::settled);
            NonlinearRegion pulled = nonlinear_region(problem, test_support::near_hooks(problem), options);
            std::vector<HookDrive> drives(2);
            drives[0].force_N = there.hook_forces_N[0];
            drives[1].displacement = problem.hooks[1].displacement; // and one that is drawn
            (void)pulled.drag(drives);
            const NearFrame rest = pulled.settle();
            ASSERT_EQ(rest.status, NearStatus::settled) << rest.message;
            EXPECT_LT(difference(rest.displacement, there.displacement), kSame);
            EXPECT_LT((rest.hook_forces_N[0] - there.hook_forces_N[0]).norm(), kSame * there.hook_forces_N[0].norm());
            EXPECT_FALSE(rest.hook_yielded[0]);
            // Through a grip: as far as leaves the force that it passes on.
            const double grip = there.hook_forces_N[0].norm() / there.hook_displacements[0].norm();
            drives[0] = { .displacement = there.hook_displacements[0] + there.hook_forces_N[0] / grip,
                .grip_N_per_mm = grip };
            (void)pulled.drag(drives);
            EXPECT_LT(difference(pulled.settle().displacement, there.displacement), kSame);
        }
    }

    TEST(NonlinearRegion, HooksThatWereNotDrawnYetSlipUnderTension)
    {
        // The tissue pulls by itself; the hooks hold it where it was, and may not pull as hard as that takes.
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        const std::vector<std::uint8_t> near = test_support::near_hooks(problem);
        const Prescribed prescribed = prescribe(problem.mesh, problem.supports, problem.hooks);
        Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
        for (std::size_t t = 0; t < near.size(); ++t)
            for (const VertexId v : problem.mesh.tet(static_cast<TetId>(t)))
                if (near[t] != 0 && prescribed.flag[3 * static_cast<std::size_t>(v)] == 0)
                    load.segment<3>(3 * v) = Vec3(0.03, 0.0, 0.006);
        const NonlinearRegionOptions options { .tolerance = kTight, .load = load };
        NonlinearRegion held = nonlinear_region(problem, near, options),
                        slips = nonlinear_region(problem, near, options);
        const NearFrame at_rest = held.settle();
        const double limit = 0.5 * at_rest.hook_forces_N[0].norm();
        ASSERT_GT(limit, 0.0);
        std::vector<HookDrive> drives(problem.hooks.size());
        for (HookDrive& drive : drives)
            drive.force_limit_N = limit;
        (void)slips.drag(drives);
        const NearFrame rest = slips.settle();
        ASSERT_EQ(rest.status, NearStatus::settled) << rest.message;
        EXPECT_TRUE(rest.hook_yielded[0]);
        EXPECT_GT(rest.hook_displacements[0].norm(), 0.0);
        EXPECT_NEAR(rest.hook_forces_N[0].norm(), limit, kSame * limit);
    }

    TEST(NonlinearRegion, IsPreparedInPartsThatCanBeCancelled)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        NonlinearRegion field = nonlinear_region(problem, test_support::near_hooks(problem)),
                        other = nonlinear_region(problem, test_support::near_hooks(problem));
        std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_FALSE(field.prepare(job));
        cancel.store(false);
        EXPECT_TRUE(field.prepare(job));
        cancel.store(true);
        EXPECT_TRUE(field.prepare(job)) << "there is nothing left to do";
        (void)field.drag(hooks_at(problem, 1.0));
        (void)other.drag(hooks_at(problem, 1.0)); // prepared as it is needed
        EXPECT_EQ(field.settle().displacement, other.settle().displacement);
    }

    TEST(NonlinearRegion, GoesOnFromAnotherAnswer)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        NonlinearRegion near = nonlinear_region(problem, test_support::near_hooks(problem)),
                        whole = nonlinear_region(problem, all_near(problem.mesh));
        const NearFrame frame = near.drag(hooks_at(problem, 1.0));
        whole.start_from(frame);
        const NearFrame settled = whole.settle();
        ElasticBody body = neo_hookean_body(problem);
        EXPECT_LT(difference(settled.displacement, exact(problem, body).displacement), kSame);
        EXPECT_EQ(settled.hook_displacements, hooks_at(problem, 1.0));
    }

    TEST(NonlinearRegion, TurnsNoElementOverWhereHooksCrushTheTissue)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        for (HookPatch& hook : problem.hooks)
            hook.displacement = Vec3(0.0, 0.0, -26.0); // through the block's fixed bottom, 20 mm below
        NonlinearRegion field = nonlinear_region(problem, all_near(problem.mesh));
        const ElasticBody body = neo_hookean_body(problem);
        bool stopped = false;
        for (int f = 1; f <= 13; ++f) {
            const NearFrame frame = field.drag(hooks_at(problem, f / 13.0));
            const auto ratios = body.deformation(frame.displacement).smallest_ratio;
            EXPECT_GT(*std::min_element(ratios.begin(), ratios.end()), 0.0) << "frame " << f;
            stopped = stopped || !frame.reached;
            EXPECT_EQ(frame.reached, frame.hook_displacements == hooks_at(problem, f / 13.0));
        }
        EXPECT_TRUE(stopped);
        const NearFrame back = field.drag(hooks_at(problem, 0.2));
        EXPECT_TRUE(back.reached) << back.message;
    }

    TEST(NonlinearRegion, GivesTheSameBitsAgain)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        NonlinearRegion first = nonlinear_region(problem, test_support::near_hooks(problem)),
                        second = nonlinear_region(problem, test_support::near_hooks(problem));
        for (const double share : { 0.1, 0.2, 0.25 })
            EXPECT_EQ(
                first.drag(hooks_at(problem, share)).displacement, second.drag(hooks_at(problem, share)).displacement);
    }

    TEST(NonlinearRegion, IsCancelled)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        NonlinearRegion field = nonlinear_region(problem, all_near(problem.mesh));
        (void)field.drag(hooks_at(problem, 1.0));
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(field.settle(job).status, NearStatus::cancelled);
    }

    TEST(NonlinearRegion, RefusesWhatItCannotSolve)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const auto near = all_near(problem.mesh);
        EXPECT_EQ(test_support::message_of(
                      [&] { (void)nonlinear_region(problem, near, { .elasticity = Elasticity::linear }); }),
            "nonlinear region: the nonlinear region is nonlinear: hyperelastic, corotational or corotational_linear");
        EXPECT_EQ(test_support::message_of([&] {
            (void)nonlinear_region(problem, { 1, 0 });
        }),
            "nonlinear region: a nonlinear region needs a flag for each element");
        EXPECT_EQ(test_support::message_of(
                      [&] { (void)nonlinear_region(problem, std::vector<std::uint8_t>(near.size(), 0)); }),
            "nonlinear region: no element is near");
        std::vector<std::uint8_t> without_hook = near;
        const VertexId held = problem.hooks[0].nodes.front();
        for (TetId t = 0; t < static_cast<TetId>(near.size()); ++t)
            for (const VertexId v : problem.mesh.tet(t))
                if (v == held)
                    without_hook[static_cast<std::size_t>(t)] = 0;
        EXPECT_NE(test_support::message_of([&] {
            (void)nonlinear_region(problem, without_hook);
        }).find("an element that is not near"),
            std::string::npos);
        EXPECT_EQ(test_support::message_of([&] { (void)elements_near(problem.mesh, Points(0, 3), 1.0); }),
            "nonlinear region: elements are near some points, within a positive distance");
        ElasticProblem loose = problem;
        loose.supports = {};
        loose.hooks.clear();
        EXPECT_NE(test_support::message_of([&] { (void)nonlinear_region(loose, near); }), "");
        NonlinearRegion field = nonlinear_region(problem, near);
        EXPECT_EQ(test_support::message_of([&] { (void)field.drag(std::vector<Vec3>(1, Vec3::Zero())); }),
            "nonlinear region: there are 2 hooks");
        EXPECT_EQ(test_support::message_of([&] {
            (void)field.drag(std::vector<Vec3>(2, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
        }),
            "hook '0': a hook's displacement and force must be finite");
        NearFrame turned = field.drag(hooks_at(problem, 0.1));
        turned.displacement *= 1e4;
        EXPECT_EQ(test_support::message_of([&] { field.start_from(turned); }),
            "nonlinear region: the start solution turns an element over");
    }

} // namespace nonlinear_region_test
} // namespace retractor::fem
