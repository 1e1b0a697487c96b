// Tension that a cut sets free as a load of everything that solves an opened wound.

#include "fem/error_estimation/error_estimate.h"
#include "fem/io/calculix_deck.h"
#include "fem/io/febio_file.h"
#include "fem/model/pre_strain.h"
#include "fem/statics/driven_opening.h"
#include "fem/statics/opening.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace retractor::fem {
namespace released_tension_test {

    using test_support::hooked_block;
    using test_support::message_of;

    constexpr double kSolved = 1e-8; ///< of the largest displacement: two linear solves of the same equations
    constexpr double kStress = 2e-3; ///< MPa: moves the block by about 1 mm

    /// The block's upper face, hooks and all, has lost a slanting traction.
    ElasticProblem loaded_block(int nodes_per_tet, double stress = kStress)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        for (const mesh::TetFace& face : mesh::boundary_faces(problem.mesh)) {
            const auto corners = mesh::face_vertices(problem.mesh, face);
            if (std::all_of(
                    corners.begin(), corners.end(), [&](VertexId v) { return problem.mesh.vertices(v, 2) > 19.999; }))
                problem.loads.push_back({ face, Vec3(0.3, 0.0, 1.0) * stress });
        }
        return nodes_per_tet == 10 ? with_midpoints(problem) : problem;
    }

    ElasticProblem without_hooks(ElasticProblem problem)
    {
        problem.hooks.clear();
        return problem;
    }

    OpeningResult opened(const ElasticProblem& problem, OpeningOptions options)
    {
        return Opening(problem, std::move(options)).open(problem.hooks);
    }

    double difference(const Points& a, const Points& b) { return (a - b).norm() / b.norm(); }

    TEST(ReleasedTension, OpensAWoundWithoutHooksAsLinearElementsSay)
    {
        for (const int nodes : { 4, 10 }) {
            const ElasticProblem problem = without_hooks(loaded_block(nodes));
            ElasticBody body = tissue_body(problem.mesh, problem.material_of_label, { Elasticity::linear });
            body.set_bed(bed_stiffness(problem.mesh, problem.supports));
            const Eigen::VectorXd u
                = test_support::solve_linear(body, prescribe(problem.mesh, problem.supports, {}).flag,
                    Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows()), nodal_loads(problem));
            const OpeningResult result = opened(problem, { .elasticity = Elasticity::linear, .tolerance = 1e-10 });
            EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
            EXPECT_GT(u.lpNorm<Eigen::Infinity>(), 0.5);
            EXPECT_LT(difference(result.displacement, Eigen::Map<const Points>(u.data(), u.size() / 3, 3)), kSolved);
        }
    }

    TEST(ReleasedTension, HooksBearWhatTheTissueLosesOfIt)
    {
        // Superposition: the hooks' forces with the load are those without it and those that hold the block still.
        const OpeningOptions linear { .elasticity = Elasticity::linear, .tolerance = 1e-10 };
        const ElasticProblem loaded = loaded_block(4);
        ElasticProblem slack = loaded, held = loaded;
        slack.loads.clear();
        for (HookPatch& hook : held.hooks)
            hook.displacement.setZero();
        const OpeningResult all = opened(loaded, linear), pulled = opened(slack, linear), still = opened(held, linear);
        for (std::size_t h = 0; h < 2; ++h) {
            EXPECT_GT(still.hook_forces_N[h].norm(), 0.01);
            EXPECT_LT((all.hook_forces_N[h] - pulled.hook_forces_N[h] - still.hook_forces_N[h]).norm(),
                kSolved * all.hook_forces_N[h].norm());
        }
    }

    TEST(ReleasedTension, TendsToTheLinearAnswerInEveryElasticityElementAndExtent)
    {
        constexpr double kSmall = 1e-3; // of kStress
        constexpr double kNonlinear = 5e-3, kTolerance = 1e-7;
        for (const int nodes : { 4, 10 }) {
            ElasticProblem problem = loaded_block(nodes, kSmall * kStress);
            for (HookPatch& hook : problem.hooks)
                hook.displacement *= kSmall;
            const Points linear
                = opened(problem, { .elasticity = Elasticity::linear, .tolerance = 1e-10 }).displacement;
            for (const Elasticity elasticity : { Elasticity::corotational, Elasticity::hyperelastic }) {
                const OpeningResult result = opened(problem, { .elasticity = elasticity, .tolerance = kTolerance });
                EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
                EXPECT_LT(difference(result.displacement, linear), kNonlinear) << nodes;
            }
            const OpeningResult near = opened(problem,
                { .elasticity = Elasticity::hyperelastic,
                    .near = std::vector<std::uint8_t>(problem.mesh.tet_count(), 1),
                    .tolerance = kTolerance });
            EXPECT_EQ(near.status, OpeningStatus::converged) << near.message;
            EXPECT_LT(difference(near.displacement, linear), kNonlinear) << nodes;
        }
    }

    /// Nothing in the near part is held then.
    TEST(ReleasedTension, ALinearCondensedRegionHoldsWhatIsLoadedNearWithoutHooks)
    {
        ElasticProblem problem = without_hooks(loaded_block(4, 1e-3 * kStress));
        std::vector<std::uint8_t> near; // the upper half
        for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t) {
            const auto corners = problem.mesh.tet(t);
            near.push_back(std::all_of(corners.begin(), corners.end(),
                               [&](VertexId v) { return problem.mesh.vertices(v, 2) > 9.999; })
                    ? 1
                    : 0);
        }
        const Points linear = opened(problem, { .elasticity = Elasticity::linear, .tolerance = 1e-10 }).displacement;
        const OpeningResult result
            = opened(problem, { .elasticity = Elasticity::hyperelastic, .near = near, .tolerance = 1e-7 });
        EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_TRUE(result.far->kept);
        EXPECT_LT(difference(result.displacement, linear), 5e-3);
    }

    TEST(ReleasedTension, AWarmStartAndDrivenHooksKeepIt)
    {
        const ElasticProblem problem = loaded_block(4);
        Opening opening(problem, { .tolerance = 1e-7 });
        const OpeningResult first = opening.open(problem.hooks);
        EXPECT_LT(difference(opening.open(problem.hooks).displacement, first.displacement), 1e-5);
        // A hook that pulls with the force it was found to bear goes to where it was.
        ElasticProblem one = problem;
        one.hooks.resize(1);
        const OpeningOptions linear { .elasticity = Elasticity::linear, .tolerance = 1e-10 };
        const OpeningResult held = opened(one, linear);
        const std::vector<HookDrive> drives { { .force_N = held.hook_forces_N[0] } };
        const DrivenOpening driven = open_driven(one, drives, linear);
        EXPECT_EQ(driven.opening.status, OpeningStatus::converged) << driven.opening.message;
        EXPECT_LT(
            (driven.hooks[0].displacement - one.hooks[0].displacement).norm(), 1e-6 * one.hooks[0].displacement.norm());
    }

    /// On a linear body the estimate is the ten-node answer itself.
    TEST(ReleasedTension, ErrorsAreEstimatedWithIt)
    {
        const ElasticProblem problem = loaded_block(4);
        const OpeningOptions linear { .elasticity = Elasticity::linear, .tolerance = 1e-10 };
        const ErrorEstimate estimate
            = estimate_error(problem, Elasticity::linear, opened(problem, linear).displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        const Points ten_node = opened(with_midpoints(problem), linear).displacement;
        EXPECT_LT(difference(estimate.displacement, ten_node.topRows(estimate.displacement.rows())), 1e-3);
        EXPECT_LT(estimate.algebraic_error, 1e-6);
    }

    TEST(ReleasedTension, IsWrittenForCalculixAndNotForFebio)
    {
        const std::string deck = calculix_deck(loaded_block(10));
        EXPECT_NE(deck.find("*CLOAD\n"), std::string::npos);
        EXPECT_EQ(calculix_deck(test_support::hooked_block(2, 10)).find("*CLOAD"), std::string::npos);
        EXPECT_NE(test_support::message_of([] { (void)febio_file(loaded_block(4)); }).find("without loads"),
            std::string::npos);
    }

    TEST(ReleasedTension, BadLoadsAreRefused)
    {
        ElasticProblem problem = loaded_block(4);
        problem.loads[0].face.tet = 99999;
        EXPECT_NE(test_support::message_of([&] { check_problem(problem); }).find("element 99999"), std::string::npos);
        problem = loaded_block(4);
        OpeningOptions options;
        options.load = Eigen::VectorXd::Zero(3);
        EXPECT_NE(
            test_support::message_of([&] { Opening(problem, options); }).find("in the problem and in the options"),
            std::string::npos);
        problem.loads.clear();
        EXPECT_NE(test_support::message_of([&] { Opening(problem, options); }).find("three finite entries"),
            std::string::npos);
    }

} // namespace released_tension_test
} // namespace retractor::fem
