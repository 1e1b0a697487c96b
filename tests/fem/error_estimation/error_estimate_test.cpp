#include "fem/error_estimation/error_estimate.h"

#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace retractor::fem {
namespace error_estimate_test {

    using namespace test_support;

    constexpr double kSolved = 1e-10; // relative residual: nothing beside errors of discretisation

    OpeningResult answer_of(const ElasticProblem& problem, Elasticity elasticity, double tolerance = kSolved)
    {
        OpeningOptions options;
        options.elasticity = elasticity;
        options.tolerance = tolerance;
        Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
        OpeningResult result = opening.open(problem.hooks);
        EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
        return result;
    }

    /// What the estimate claims over what is true; the ratio must be 0.5 to 3.
    void expect_effective(double claimed, double truth, const std::string& what)
    {
        constexpr double kLeast = 0.5, kMost = 3.0;
        EXPECT_GE(claimed / truth, kLeast) << what;
        EXPECT_LE(claimed / truth, kMost) << what;
    }

    /// A bar along x, clamped at one end; the other is moved without turning.
    ElasticProblem moved_bar(int across, const Vec3& displacement, double poissons_ratio)
    {
        constexpr int kSlenderness = 10;
        constexpr double kHeight = 4.0;
        ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(kSlenderness * across, across, across, kHeight / across);
        problem.material_of_label = { {}, test_support::material(0.5, poissons_ratio) };
        problem.hooks = { { .name = "end", .side = 1, .nodes = {}, .displacement = displacement } };
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v)
            if (problem.mesh.vertices(v, 0) < 1e-9)
                problem.supports.fixed.push_back(v);
            else if (problem.mesh.vertices(v, 0) > kSlenderness * kHeight - 1e-9)
                problem.hooks[0].nodes.push_back(v);
        return problem;
    }

    TEST(ErrorEstimate, EffectiveOnABarWhoseEndIsMovedAcross)
    {
        // 12 E I d / L^3, softened by shear with kappa 5/6 [Timoshenko 1921]; no Poisson effect.
        constexpr double E = 0.5, h = 4.0, L = 40.0, d = 2.0, I = h * h * h * h / 12.0;
        constexpr double kShear = 12.0 * E * I / (5.0 / 6.0 * 0.5 * E * h * h * L * L);
        const double exact = 12.0 * E * I * d / (L * L * L) / (1.0 + kShear);
        double last = 1e9;
        for (const int across : { 1, 2, 4 }) {
            const ElasticProblem bar = moved_bar(across, Vec3(0.0, d, 0.0), 0.0);
            const OpeningResult answer = answer_of(bar, Elasticity::linear);
            const ErrorEstimate estimate = estimate_error(bar, Elasticity::linear, answer.displacement);
            ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
            const double truth = std::abs(answer.hook_forces_N[0].norm() - exact);
            const double claimed = (answer.hook_forces_N[0] - estimate.hook_forces_N[0]).norm() / kErrorShare;
            expect_effective(claimed, truth, std::to_string(across) + " across");
            EXPECT_LT(claimed, last); // it falls with the mesh
            last = claimed;
        }
    }

    TEST(ErrorEstimate, EffectiveOnABlockUnderPatches)
    {
        const ElasticProblem finest = with_midpoints(test_support::hooked_block(8, 4));
        const OpeningResult truth = answer_of(finest, Elasticity::linear);
        const auto displacement_at = [](const ElasticProblem& problem, const Points& displacement, const Vec3& at) {
            Eigen::Index node = 0;
            (problem.mesh.vertices.rowwise() - at.transpose()).rowwise().norm().minCoeff(&node);
            return Vec3(displacement.row(node));
        };
        for (const int fineness : { 2, 4, 6 }) {
            const ElasticProblem block = test_support::hooked_block(fineness, 4);
            const OpeningResult answer = answer_of(block, Elasticity::linear);
            const ErrorEstimate estimate = estimate_error(block, Elasticity::linear, answer.displacement);
            ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
            const std::string what = "fineness " + std::to_string(fineness);
            for (std::size_t h = 0; h < block.hooks.size(); ++h)
                expect_effective((answer.hook_forces_N[h] - estimate.hook_forces_N[h]).norm() / kErrorShare,
                    (answer.hook_forces_N[h] - truth.hook_forces_N[h]).norm(), what + ", " + block.hooks[h].name);
            for (const Vec3& at : { Vec3(30.0, 20.0, 20.0), Vec3(20.0, 0.0, 20.0) }) { // between the hooks, at the side
                const Vec3 here = displacement_at(block, answer.displacement, at);
                expect_effective((here - displacement_at(block, estimate.displacement, at)).norm() / kErrorShare,
                    (here - displacement_at(finest, truth.displacement, at)).norm(), what + ", free surface");
            }
            constexpr int kIterations = 60; // whatever the mesh: about 30 here
            EXPECT_LE(estimate.iterations, kIterations);
        }
    }

    TEST(ErrorEstimate, IsWhatTenNodeElementsGiveOnTheSameMesh)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        const struct {
            Elasticity elasticity;
            double tolerance; ///< relative to the change
        } models[] = { { Elasticity::linear, 5e-3 }, { Elasticity::corotational, 0.1 },
            { Elasticity::hyperelastic, 0.1 } }; // one step of Newton's
        for (const auto& model : models) {
            const OpeningResult answer = answer_of(block, model.elasticity);
            const OpeningResult finer = answer_of(with_midpoints(block), model.elasticity);
            const ErrorEstimate estimate = estimate_error(block, model.elasticity, answer.displacement);
            ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
            for (std::size_t h = 0; h < block.hooks.size(); ++h) {
                const double change = (finer.hook_forces_N[h] - answer.hook_forces_N[h]).norm();
                EXPECT_LE((finer.hook_forces_N[h] - estimate.hook_forces_N[h]).norm(), model.tolerance * change);
            }
            const Points there = finer.displacement.topRows(answer.displacement.rows());
            EXPECT_LE((there - estimate.displacement).norm(), model.tolerance * (there - answer.displacement).norm());
        }
    }

    TEST(ErrorEstimate, EffectiveForLockingFreeAndTenNodeElements)
    {
        // Nearly incompressible, where plain elements lock. The truth is carried on from two meshes of ten-node
        // elements: at the rims of patches forces go to their limit like the edge's length.
        for (const double nu : { 0.45, 0.49 }) {
            const auto skin = [nu](ElasticProblem problem) {
                problem.material_of_label = { {}, test_support::material(0.2, nu), test_support::material(0.2, nu) };
                return problem;
            };
            const auto ten_nodes = [&](int fineness) {
                return answer_of(with_midpoints(skin(test_support::hooked_block(fineness, 4))), Elasticity::linear)
                    .hook_forces_N;
            };
            const std::vector<Vec3> coarse = ten_nodes(6), fine = ten_nodes(8);
            // At 0.49 elements as large as a patch see up to 3.5 times their error.
            for (const int fineness : nu > 0.46 ? std::vector { 4 } : std::vector { 2, 4 }) {
                const ElasticProblem block = skin(test_support::hooked_block(fineness, 4));
                Opening opening(block.mesh, block.material_of_label, block.supports,
                    { .elasticity = Elasticity::linear, .locking_free = true, .tolerance = kSolved });
                const OpeningResult answer = opening.open(block.hooks);
                const ErrorEstimate estimate = estimate_error(block, Elasticity::linear, answer.displacement);
                ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
                const double lacking
                    = ten_node_share(with_midpoints(block), Elasticity::linear, estimate.ten_node, estimate.plain);
                for (std::size_t h = 0; h < block.hooks.size(); ++h) {
                    const Vec3 truth = fine[h] - 3.0 * (coarse[h] - fine[h]), &ten = estimate.hook_forces_N[h];
                    const double of_ten = lacking * (estimate.plain_forces_N[h] - ten).norm();
                    const std::string what = "nu " + std::to_string(nu) + ", fineness " + std::to_string(fineness)
                        + ", " + block.hooks[h].name;
                    expect_effective((answer.hook_forces_N[h] - ten).norm() + of_ten,
                        (answer.hook_forces_N[h] - truth).norm(), "locking-free, " + what);
                    expect_effective(of_ten, (ten - truth).norm(), "ten nodes, " + what);
                }
            }
        }
    }

    TEST(ErrorEstimate, KnowsWhatPlainElementsSayOfWhatOthersAnswered)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        Opening opening(block.mesh, block.material_of_label, block.supports,
            { .elasticity = Elasticity::linear, .locking_free = true, .tolerance = kSolved });
        const ErrorEstimate estimate
            = estimate_error(block, Elasticity::linear, opening.open(block.hooks).displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        const OpeningResult plain = answer_of(block, Elasticity::linear);
        constexpr double kRoundOff = 1e-8;
        EXPECT_LE((estimate.plain - plain.displacement).cwiseAbs().maxCoeff(), kRoundOff);
        for (std::size_t h = 0; h < block.hooks.size(); ++h)
            EXPECT_LE((estimate.plain_forces_N[h] - plain.hook_forces_N[h]).norm(),
                kRoundOff * plain.hook_forces_N[h].norm());
        EXPECT_EQ(estimate.ten_node.head(3 * block.mesh.vertices.rows()),
            Eigen::Map<const Eigen::VectorXd>(estimate.displacement.data(), estimate.displacement.size()));
    }

    /// Of tissue that stretches: the tangent has negative eigenvalues in many elements and is positive definite all the
    /// same. With these lifted the plain step would stay short.
    ElasticProblem stretched_block(double poissons_ratio, double times)
    {
        ElasticProblem block = test_support::hooked_block(2, 4);
        block.material_of_label
            = { {}, test_support::material(0.2, poissons_ratio), test_support::material(0.2, poissons_ratio) };
        for (HookPatch& hook : block.hooks)
            hook.displacement *= times;
        return block;
    }

    TEST(ErrorEstimate, APlainStepGoesBackToThePlainAnswer)
    {
        const ElasticProblem block = stretched_block(0.45, 1.0);
        const OpeningResult answer = answer_of(block, Elasticity::hyperelastic);
        Points moved = answer.displacement;
        Eigen::Index node = 0;
        (block.mesh.vertices.rowwise() - Eigen::RowVector3d(30.0, 20.0, 10.0)).rowwise().norm().minCoeff(&node);
        constexpr double kMoved = 0.01; // mm
        moved(node, 1) += kMoved;
        const ErrorEstimate estimate = estimate_error(block, Elasticity::hyperelastic, moved);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        constexpr double kSecondOrder = 0.01; // of the way, at this length; 0.09 is left where the tangent is lifted
        EXPECT_LE((estimate.plain - answer.displacement).norm(), kSecondOrder * kMoved);
    }

    TEST(ErrorEstimate, KnowsWhatPlainElementsSayOfStretchedTissue)
    {
        const ElasticProblem block = stretched_block(0.3, 3.0);
        Opening opening(block.mesh, block.material_of_label, block.supports,
            { .elasticity = Elasticity::hyperelastic, .locking_free = true, .tolerance = kSolved });
        const OpeningResult answer = opening.open(block.hooks);
        ASSERT_EQ(answer.status, OpeningStatus::converged) << answer.message;
        const ErrorEstimate estimate = estimate_error(block, Elasticity::hyperelastic, answer.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        const OpeningResult plain = answer_of(block, Elasticity::hyperelastic);
        constexpr double kOneStep = 0.075; // of the way, what a Newton step leaves; one of a lifted tangent 0.1
        EXPECT_LE(
            (estimate.plain - plain.displacement).norm(), kOneStep * (answer.displacement - plain.displacement).norm());
    }

    /// Two blocks of 10 x 10 x 5 mm, one above the other and beside it a little, pressed together by 1 mm. The last
    /// `stiff_mm` of every 5 mm along x are bone.
    ElasticProblem pressed_blocks(double edge_mm, double poissons_ratio, double stiff_mm)
    {
        constexpr double kSide = 10.0, kHeight = 5.0, kGap = 0.3, kPress = 1.3, kRoundOff = 1e-9;
        const int across = static_cast<int>(std::lround(kSide / edge_mm));
        ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(across, across, across / 2, edge_mm);
        const mesh::TetMesh upper = problem.mesh;
        const auto before = static_cast<VertexId>(upper.vertex_count());
        problem.mesh.vertices.conservativeResize(2 * upper.vertices.rows(), 3);
        problem.mesh.vertices.bottomRows(upper.vertices.rows())
            = upper.vertices.rowwise() + Eigen::RowVector3d(0.6, 0.4, kHeight + kGap);
        for (const VertexId v : upper.nodes)
            problem.mesh.nodes.push_back(v + before);
        problem.mesh.labels.insert(problem.mesh.labels.end(), upper.tet_count(), Label { 2 });
        for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t) {
            double middle = 0.0;
            for (const VertexId v : problem.mesh.tet(t))
                middle += 0.25 * problem.mesh.vertices(v, 0);
            if (std::fmod(middle, 0.5 * kSide) < stiff_mm)
                problem.mesh.labels[static_cast<std::size_t>(t)] = 3;
        }
        problem.material_of_label = { {}, test_support::material(0.05, poissons_ratio),
            test_support::material(0.02, poissons_ratio), test_support::material(1000.0, 0.3) };
        problem.hooks = { { "press", 1, {}, Vec3(0.0, 0.0, -kPress) } };
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v)
            if (problem.mesh.vertices(v, 2) < kRoundOff)
                problem.supports.fixed.push_back(v);
            else if (problem.mesh.vertices(v, 2) > 2.0 * kHeight + kGap - kRoundOff)
                problem.hooks[0].nodes.push_back(v);
        return problem;
    }

    ErrorEstimate estimate_pressed(const ElasticProblem& problem)
    {
        OpeningOptions options;
        options.elasticity = Elasticity::linear;
        options.tolerance = 1e-8;
        options.contact.emplace();
        Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
        const OpeningResult answer = opening.open(problem.hooks);
        EXPECT_EQ(answer.status, OpeningStatus::converged) << answer.message;
        EXPECT_GT(answer.contact.touching, 20U);
        return estimate_error(problem, Elasticity::linear, answer.displacement, {}, options.contact);
    }

    TEST(ErrorEstimate, ContactTakesNoMoreIterations)
    {
        for (const double edge : { 2.5, 1.25 })
            for (const double nu : { 0.3, 0.45 }) {
                const ErrorEstimate estimate = estimate_pressed(pressed_blocks(edge, nu, 0.0));
                EXPECT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
                constexpr int kIterations = 60; // 25 to 41; without contact they are no fewer
                EXPECT_LE(estimate.iterations, kIterations) << edge << " mm, nu " << nu;
            }
        // Bone to bone and to muscle, each a few elements wide.
        const ErrorEstimate estimate = estimate_pressed(pressed_blocks(2.5, 0.3, 2.6));
        EXPECT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
    }

    TEST(ErrorEstimate, FlatElementsTakeLongerButHaveOne)
    {
        ElasticProblem block = test_support::hooked_block(2, 4);
        block.mesh.vertices.col(2) *= 0.05; // elements of 10 x 10 x 0.5 mm, stiff upon soft
        block.material_of_label = { {}, test_support::material(0.04, 0.0), test_support::material(2000.0, 0.0) };
        for (HookPatch& hook : block.hooks)
            hook.displacement *= 0.01; // else they turn over
        const OpeningResult answer = answer_of(block, Elasticity::linear, 1e-6);
        const ErrorEstimate estimate = estimate_error(block, Elasticity::linear, answer.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message; // by 400 iterations it was not
        const OpeningResult finer = answer_of(with_midpoints(block), Elasticity::linear, 1e-6);
        constexpr double kSame = 1e-2;
        for (std::size_t h = 0; h < block.hooks.size(); ++h)
            EXPECT_LE((estimate.hook_forces_N[h] - finer.hook_forces_N[h]).norm(),
                kSame * (answer.hook_forces_N[h] - finer.hook_forces_N[h]).norm());
    }

    TEST(ErrorEstimate, SeesALinearCondensedRegionAsWell)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        Points wound(1, 3);
        wound.row(0) = block.mesh.vertices.row(block.hooks[0].nodes.front());
        std::vector<std::uint8_t> near = elements_near(block.mesh, wound, 1.0);
        for (TetId t = 0; t < static_cast<TetId>(block.mesh.tet_count()); ++t)
            for (const VertexId v : block.mesh.tet(t))
                for (const HookPatch& hook : block.hooks)
                    if (std::find(hook.nodes.begin(), hook.nodes.end(), v) != hook.nodes.end())
                        near[static_cast<std::size_t>(t)] = 1;
        Opening opening(block.mesh, block.material_of_label, block.supports,
            { .elasticity = Elasticity::hyperelastic,
                .near = near,
                .far_tolerance = std::numeric_limits<double>::infinity(),
                .tolerance = 1e-8 });
        const OpeningResult answer = opening.open(block.hooks);
        ASSERT_EQ(answer.status, OpeningStatus::converged) << answer.message;
        const OpeningResult finer = answer_of(with_midpoints(block), Elasticity::hyperelastic);
        const ErrorEstimate estimate = estimate_error(block, Elasticity::hyperelastic, answer.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        EXPECT_GT(estimate.algebraic_error, 1e-6); // of the nonlinear equations beyond
        const Points there = finer.displacement.topRows(answer.displacement.rows());
        EXPECT_LE((there - estimate.displacement).norm(), 0.1 * (there - answer.displacement).norm());
    }

    TEST(ErrorEstimate, NoneWhereTheAnswerTurnsTissueOver)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        Points u = answer_of(block, Elasticity::linear).displacement;
        Eigen::Index node = 0;
        (block.mesh.vertices.rowwise() - Eigen::RowVector3d(30.0, 20.0, 10.0)).rowwise().norm().minCoeff(&node);
        u(node, 1) += 100.0;
        const ErrorEstimate estimate = estimate_error(block, Elasticity::hyperelastic, u);
        EXPECT_EQ(estimate.status, EstimateStatus::not_converged);
        EXPECT_NE(estimate.message.find("turned over"), std::string::npos) << estimate.message;
    }

    TEST(ErrorEstimate, NoneForLinearFields)
    {
        const ElasticProblem bar = moved_bar(2, Vec3(3.0, 0.0, 0.0), 0.0); // stretched: u = 3 x / L
        const OpeningResult answer = answer_of(bar, Elasticity::linear);
        const ErrorEstimate estimate = estimate_error(bar, Elasticity::linear, answer.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        constexpr double kRoundOff = 1e-10;
        EXPECT_LE(estimate.energy_error, kRoundOff);
        EXPECT_LE(estimate.algebraic_error, kRoundOff);
        EXPECT_LE((estimate.displacement - answer.displacement).cwiseAbs().maxCoeff(), kRoundOff);
        EXPECT_LE((estimate.hook_forces_N[0] - answer.hook_forces_N[0]).norm(), kRoundOff);
    }

    TEST(ErrorEstimate, NoneForABodyThatIsOnlyMoved)
    {
        ElasticProblem bar = moved_bar(2, Vec3(3.0, -1.0, 2.0), 0.3);
        bar.supports.fixed.clear();
        const OpeningResult answer = answer_of(bar, Elasticity::corotational);
        const ErrorEstimate estimate = estimate_error(bar, Elasticity::corotational, answer.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        EXPECT_LE((estimate.displacement - answer.displacement).cwiseAbs().maxCoeff(), 1e-9);
    }

    TEST(ErrorEstimate, WhatWasLeftUnsolvedIsSeenAndUndone)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        const OpeningResult answer = answer_of(block, Elasticity::linear);
        const ErrorEstimate solved = estimate_error(block, Elasticity::linear, answer.displacement);
        Points wrong = answer.displacement;
        Eigen::Index node = 0;
        (block.mesh.vertices.rowwise() - Eigen::RowVector3d(30.0, 20.0, 10.0)).rowwise().norm().minCoeff(&node);
        wrong(node, 1) += 0.5;
        ElasticBody body(block.mesh, Elasticity::linear, element_parameters(block.mesh, block.material_of_label));
        body.set_bed(bed_stiffness(block.mesh, block.supports));
        const auto energy_norm = [&](const Points& u) {
            const Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(u.data(), u.size());
            return std::sqrt(vector.dot(body.stiffness(vector, 0.0).multiply(vector)));
        };
        const ErrorEstimate estimate = estimate_error(block, Elasticity::linear, wrong);
        const double expected = energy_norm(wrong - answer.displacement) / energy_norm(wrong);
        EXPECT_NEAR(estimate.algebraic_error, expected, 1e-6 * expected);
        EXPECT_LE(solved.algebraic_error, 1e-8);
        EXPECT_GT(estimate.energy_error, solved.energy_error * energy_norm(answer.displacement) / energy_norm(wrong));
        for (std::size_t h = 0; h < block.hooks.size(); ++h) {
            const double change = (answer.hook_forces_N[h] - solved.hook_forces_N[h]).norm();
            EXPECT_LE((estimate.hook_forces_N[h] - solved.hook_forces_N[h]).norm(), 1e-2 * change);
        }
    }

    TEST(ErrorEstimate, MidpointsAreHeldWhereAWholeFaceIs)
    {
        const ElasticProblem fine = with_midpoints(test_support::hooked_block(2, 4));
        const ElasticProblem direct = test_support::hooked_block(2, 10); // every node on the held surfaces
        EXPECT_EQ(fine.supports.fixed.size(), direct.supports.fixed.size());
        for (std::size_t h = 0; h < fine.hooks.size(); ++h)
            EXPECT_EQ(fine.hooks[h].nodes.size(), direct.hooks[h].nodes.size());
    }

    TEST(ErrorEstimate, BadInputIsRefused)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        const Points answer = answer_of(block, Elasticity::linear).displacement;
        const auto refused = [](const ElasticProblem& problem, Elasticity model, const Points& u, const char* word) {
            try {
                (void)estimate_error(problem, model, u);
                ADD_FAILURE() << "accepted: " << word;
            } catch (const InputError& error) {
                EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
            }
        };
        refused(with_midpoints(block), Elasticity::linear, answer, "four-node");
        refused(block, Elasticity::linear, answer.topRows(3), "one displacement per node");
        Points bad = answer;
        bad(5, 1) = std::nan("");
        refused(block, Elasticity::linear, bad, "not finite");
        bad = answer;
        bad.row(block.hooks[0].nodes.front()).array() += 0.1;
        refused(block, Elasticity::linear, bad, "not where a support or hook holds it");
    }

    TEST(ErrorEstimate, CancelledIsAStatus)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        const Points answer = answer_of(block, Elasticity::linear).displacement;
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(estimate_error(block, Elasticity::linear, answer, job).status, EstimateStatus::cancelled);
    }

} // namespace error_estimate_test
} // namespace retractor::fem
