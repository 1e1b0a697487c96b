#include "fem/statics/parameter_sensitivity.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/frame_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
namespace parameter_sensitivity_test {

    constexpr double kRoundOff = 1e-9; ///< relative, of one linear solve
    constexpr double kSolved = 1e-5; ///< relative; openings are solved to 1e-9 of the largest nodal force
    /// Of the largest derivative: a central difference over +-10 % leaves the third derivative by ln E over 6, times
    /// ln(1.1)^2 or 0.9 %.
    constexpr double kDifference = 0.015;
    constexpr double kChange = 0.1;

    /// The tissues and the springs of the block.
    std::vector<StiffnessParameter> parameters_of(const ElasticProblem& problem)
    {
        std::vector<std::size_t> springs(problem.supports.bedded.size());
        std::iota(springs.begin(), springs.end(), 0U);
        std::vector<StiffnessParameter> parameters { { .name = "lower", .labels = { 1 } },
            { .name = "upper", .labels = { 2 } } };
        if (!springs.empty())
            parameters.push_back({ .name = "bed", .springs = springs });
        return parameters;
    }

    /// The problem with one parameter times a factor.
    ElasticProblem scaled(ElasticProblem problem, const StiffnessParameter& parameter, double factor)
    {
        for (const Label label : parameter.labels)
            problem.material_of_label[label].youngs_modulus_MPa *= factor;
        for (const std::size_t spring : parameter.springs)
            problem.supports.bedded[spring].stiffness *= factor;
        for (FaceTraction& load : problem.loads)
            if (std::ranges::count(parameter.labels, problem.mesh.labels[static_cast<std::size_t>(load.face.tet)]) > 0)
                load.traction *= factor;
        return problem;
    }

    Eigen::MatrixXd motions_of_hooks(const ElasticProblem& problem)
    {
        return hook_motions(prescribe(problem.mesh, problem.supports, problem.hooks), problem.hooks.size());
    }

    ParameterSensitivity differentiate(
        const ElasticProblem& problem, const TissueModel& model, const Points& displacement)
    {
        return parameter_sensitivity(problem, model, displacement, parameters_of(problem), motions_of_hooks(problem));
    }

    /// The derivative of a vector of results by ln of one parameter, from two solutions.
    Eigen::VectorXd difference(const ElasticProblem& problem, const StiffnessParameter& parameter,
        const std::function<Eigen::VectorXd(const ElasticProblem&)>& solve)
    {
        return (solve(scaled(problem, parameter, 1.0 + kChange)) - solve(scaled(problem, parameter, 1.0 - kChange)))
            / std::log((1.0 + kChange) / (1.0 - kChange));
    }

    Eigen::VectorXd flat(const Points& displacement)
    {
        return Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
    }

    /// A column of two materials in series, 30 mm and 20 mm long, that is pulled at its upper end.
    struct Column {
        static constexpr double kLower = 30.0, kUpper = 20.0, kArea = 400.0, kPulled = 2.0; // mm, mm2
        static constexpr double kSoft = 0.05, kHard = 0.4; // MPa
        ElasticProblem problem;
        double of_lower = (kLower / kSoft) / (kLower / kSoft + kUpper / kHard);
        double force = kPulled * kArea / (kLower / kSoft + kUpper / kHard);

        Column()
        {
            problem.mesh = mesh::kuhn_box(2, 2, 5, 10.0);
            for (std::size_t t = 0; t < problem.mesh.tet_count(); ++t) {
                double middle = 0.0;
                for (const VertexId v : problem.mesh.tet(static_cast<TetId>(t)))
                    middle += 0.25 * problem.mesh.vertices(v, 2);
                problem.mesh.labels[t] = middle < kLower ? 1 : 2;
            }
            problem.material_of_label
                = { {}, { "soft", kSoft, 0.0, 1e-9, "test" }, { "hard", kHard, 0.0, 1e-9, "test" } };
            problem.hooks = { { .name = "top", .side = 1, .nodes = {}, .displacement = Vec3(0.0, 0.0, kPulled) } };
            for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v) {
                if (problem.mesh.vertices(v, 2) < 1e-6)
                    problem.supports.fixed.push_back(v);
                if (problem.mesh.vertices(v, 2) > kLower + kUpper - 1e-6)
                    problem.hooks[0].nodes.push_back(v);
            }
        }
    };

    TEST(ParameterSensitivity, OfTwoSpringsInSeriesIsTheirShareOfTheCompliance)
    {
        const Column column;
        const OpeningResult opened
            = Opening(column.problem, { .elasticity = Elasticity::linear }).open(column.problem.hooks);
        ASSERT_NEAR(opened.hook_forces_N[0].z(), column.force, kRoundOff * column.force);
        const ParameterSensitivity found = differentiate(column.problem, { Elasticity::linear }, opened.displacement);
        const EquilibriumSensitivity held = with_held_hooks(column.problem, found);
        EXPECT_NEAR(held.hook_forces_N(2, 0), column.force * column.of_lower, kRoundOff * column.force);
        EXPECT_NEAR(held.hook_forces_N(2, 1), column.force * (1.0 - column.of_lower), kRoundOff * column.force);
        // The joint of the two rises by d ln E_1 times -of_lower (1 - of_lower) of the pull.
        const double risen = -Column::kPulled * column.of_lower * (1.0 - column.of_lower);
        for (VertexId v = 0; v < column.problem.mesh.vertices.rows(); ++v) {
            const bool at_joint = std::abs(column.problem.mesh.vertices(v, 2) - Column::kLower) < 1e-6;
            EXPECT_TRUE(!at_joint || std::abs(held.displacement(3 * v + 2, 0) - risen) < kRoundOff * Column::kPulled);
        }
    }

    TEST(ParameterSensitivity, OfAHookThatPullsWithAForceIsThatOfItsWay)
    {
        const Column column;
        const std::vector<HookDrive> drives { { .force_N = Vec3(0.0, 0.0, column.force) } };
        const OpeningResult opened
            = Opening(column.problem, { .elasticity = Elasticity::linear }).open(column.problem.hooks);
        const ParameterSensitivity found = differentiate(column.problem, { Elasticity::linear }, opened.displacement);
        const auto followed = with_driven_hooks(
            column.problem, found, Vec3(0.0, 0.0, Column::kPulled), opened.hook_forces_N[0], drives);
        ASSERT_TRUE(followed);
        const VertexId top = column.problem.hooks[0].nodes.front();
        constexpr double kDrive = 1e-6; // the difference over the drives leaves the error of their search
        EXPECT_LT(followed->hook_forces_N.norm(), kDrive * column.force);
        EXPECT_NEAR(followed->displacement(3 * top + 2, 0), -Column::kPulled * column.of_lower, kDrive);
        EXPECT_NEAR(followed->displacement(3 * top + 2, 1), -Column::kPulled * (1.0 - column.of_lower), kDrive);
    }

    struct Model {
        TissueModel model;
        int nodes_per_tet;
    };
    const std::vector<Model> kModels { { { Elasticity::linear }, 4 }, { { Elasticity::corotational }, 4 },
        { { Elasticity::hyperelastic }, 4 }, { { Elasticity::corotational, true }, 4 },
        { { Elasticity::corotational }, 10 }, { { Elasticity::hyperelastic }, 10 } };

    OpeningResult opened_exactly(const ElasticProblem& problem, const TissueModel& model)
    {
        OpeningResult opened = Opening(
            problem, { .elasticity = model.elasticity, .locking_free = model.locking_free, .tolerance = 1e-9 })
                                   .open(problem.hooks);
        EXPECT_EQ(opened.status, OpeningStatus::converged) << opened.message;
        return opened;
    }

    TEST(ParameterSensitivity, AddsUpToTheForcesAndMovesNothingWhenAllStiffnessGrows)
    {
        for (const Model& each : kModels) {
            const ElasticProblem problem = test_support::hooked_block(2, each.nodes_per_tet);
            const OpeningResult opened = opened_exactly(problem, each.model);
            const EquilibriumSensitivity held
                = with_held_hooks(problem, differentiate(problem, each.model, opened.displacement));
            const Eigen::VectorXd forces = packed(opened.hook_forces_N), sum = held.hook_forces_N.rowwise().sum();
            EXPECT_LT((sum - forces).norm(), kSolved * forces.norm());
            EXPECT_LT(held.displacement.rowwise().sum().norm(), kSolved * flat(opened.displacement).norm());
        }
    }

    TEST(ParameterSensitivity, AddsUpWithTensionToo)
    {
        for (const Model& each : kModels) {
            ElasticProblem problem = test_support::hooked_block(2, 4);
            for (const mesh::TetFace& face : mesh::boundary_faces(problem.mesh)) {
                const auto corners = mesh::face_vertices(problem.mesh, face);
                if (std::ranges::all_of(corners, [&](VertexId v) { return problem.mesh.vertices(v, 2) > 19.999; }))
                    problem.loads.push_back({ face, Vec3(0.3, 0.0, 1.0) * 2e-3 });
            }
            if (each.nodes_per_tet == 10)
                problem = with_midpoints(problem);
            const OpeningResult opened = opened_exactly(problem, each.model);
            const EquilibriumSensitivity held
                = with_held_hooks(problem, differentiate(problem, each.model, opened.displacement));
            const Eigen::VectorXd forces = packed(opened.hook_forces_N);
            EXPECT_LT((held.hook_forces_N.rowwise().sum() - forces).norm(), kSolved * forces.norm());
        }
    }

    TEST(ParameterSensitivity, IsTheDifferenceOfSolutionsWithOtherModuli)
    {
        for (const Model& each : kModels) {
            const ElasticProblem problem = test_support::hooked_block(2, each.nodes_per_tet);
            const OpeningResult opened = opened_exactly(problem, each.model);
            const EquilibriumSensitivity held
                = with_held_hooks(problem, differentiate(problem, each.model, opened.displacement));
            const auto parameters = parameters_of(problem);
            for (std::size_t p = 0; p < parameters.size(); ++p) {
                const auto column = static_cast<Eigen::Index>(p);
                const Eigen::Index hooks = held.hook_forces_N.rows(), nodes = held.displacement.rows();
                const Eigen::VectorXd other = difference(problem, parameters[p], [&](const ElasticProblem& scaled_one) {
                    const OpeningResult result = opened_exactly(scaled_one, each.model);
                    Eigen::VectorXd both(hooks + nodes);
                    both << packed(result.hook_forces_N), flat(result.displacement);
                    return both;
                });
                EXPECT_LT((held.hook_forces_N.col(column) - other.head(hooks)).norm(),
                    kDifference * held.hook_forces_N.norm());
                EXPECT_LT(
                    (held.displacement.col(column) - other.tail(nodes)).norm(), kDifference * held.displacement.norm());
            }
        }
    }

    TEST(ParameterSensitivity, OfDrivenHooksIsTheDifferenceOfOpenings)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        // The first hook slips at its limit, which is below what it needs for its way; the second pulls with a force.
        const std::vector<HookDrive> drives {
            { .displacement = Vec3(-6.0, 0.0, 0.0), .grip_N_per_mm = 3.0, .force_limit_N = 1.0 },
            { .force_N = Vec3(1.5, 0.0, 0.3) }
        };
        for (const Elasticity elasticity : { Elasticity::linear, Elasticity::corotational }) {
            const OpeningOptions options { .elasticity = elasticity, .tolerance = 1e-9 };
            const DrivenOpening opened = open_driven(block, drives, options);
            ASSERT_EQ(opened.opening.status, OpeningStatus::converged) << opened.opening.message;
            ASSERT_TRUE(opened.yielded[0]);
            ElasticProblem problem = block;
            problem.hooks = opened.hooks;
            std::vector<Vec3> at;
            for (const HookPatch& hook : opened.hooks)
                at.push_back(hook.displacement);
            const auto followed
                = with_driven_hooks(problem, differentiate(problem, { elasticity }, opened.opening.displacement),
                    packed(at), packed(opened.opening.hook_forces_N), drives);
            ASSERT_TRUE(followed);
            const auto parameters = parameters_of(problem);
            for (std::size_t p = 0; p < parameters.size(); ++p) {
                const Eigen::VectorXd moved = difference(block, parameters[p], [&](const ElasticProblem& other) {
                    return flat(open_driven(other, drives, options).opening.displacement);
                });
                EXPECT_LT((followed->displacement.col(static_cast<Eigen::Index>(p)) - moved).norm(),
                    kDifference * followed->displacement.norm());
            }
        }
    }

    TEST(ParameterSensitivity, OfARetractorIsTheDifferenceOfBalances)
    {
        const ElasticProblem block = test_support::hooked_block(2, 4);
        constexpr double kPlay = 30.0 * std::numbers::pi / 180.0;
        // Blades that turn freely, blades without play, and blades without play on a frame whose direction is held.
        for (const auto& [play, held] : { std::pair(kPlay, false), std::pair(0.0, false), std::pair(0.0, true) }) {
            BladeFrame frame;
            frame[0]
                = { .pivot = Vec3(15.0, 20.0, 30.0), .arm = Vec3::UnitY(), .outward = -Vec3::UnitX(), .play = play };
            frame[1]
                = { .pivot = Vec3(45.0, 20.0, 30.0), .arm = Vec3::UnitY(), .outward = Vec3::UnitX(), .play = play };
            for (const RackDrive& drive : { RackDrive { .distance_mm = 6.0 }, RackDrive { .force_N = 1.0 } }) {
                const OpeningOptions options { .elasticity = Elasticity::corotational, .tolerance = 1e-8 };
                const auto open = [&, is_held = held](const ElasticProblem& problem) {
                    FrameOpening opened = open_with_frame(
                        problem, frame, drive, options, { .tolerance = 1e-6, .direction_is_held = is_held });
                    EXPECT_EQ(opened.opening.status, OpeningStatus::converged) << opened.opening.message;
                    return opened;
                };
                const FrameOpening opened = open(block);
                ElasticProblem problem = block;
                problem.hooks = opened.blades;
                const auto parameters = parameters_of(problem);
                const ParameterSensitivity found = parameter_sensitivity(problem, { Elasticity::corotational },
                    opened.opening.displacement, parameters, blade_motions(problem.mesh, problem.hooks));
                const EquilibriumSensitivity balanced = with_balanced_frame(problem, found,
                    { .frame = frame,
                        .state = opened.state,
                        .loads = opened.loads,
                        .driven_by_force = drive.force_N.has_value(),
                        .direction_is_held = held });
                const double force = packed(opened.opening.hook_forces_N).norm();
                for (std::size_t p = 0; p < parameters.size(); ++p) {
                    const auto column = static_cast<Eigen::Index>(p);
                    const Eigen::VectorXd other
                        = difference(block, parameters[p], [&](const ElasticProblem& scaled_one) {
                              const FrameOpening result = open(scaled_one);
                              Eigen::VectorXd both(6 + balanced.displacement.rows());
                              both << packed(result.opening.hook_forces_N), flat(result.opening.displacement);
                              return both;
                          });
                    EXPECT_LT((balanced.hook_forces_N.col(column) - other.head<6>()).norm(), kDifference * force)
                        << parameters[p].name;
                    EXPECT_LT((balanced.displacement.col(column) - other.tail(balanced.displacement.rows())).norm(),
                        kDifference * balanced.displacement.norm())
                        << parameters[p].name;
                }
            }
        }
    }

    TEST(ParameterSensitivity, RefusesBadInputByName)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const Eigen::MatrixXd motions = motions_of_hooks(problem);
        Points rest = Points::Zero(problem.mesh.vertices.rows(), 3);
        const auto refusal = [&](const std::vector<StiffnessParameter>& parameters) {
            return test_support::message_of(
                [&] { (void)parameter_sensitivity(problem, { Elasticity::linear }, rest, parameters, motions); });
        };
        EXPECT_EQ(refusal({ { .name = "fat" } }), "parameter 'fat': the parameter has neither a label nor a spring");
        EXPECT_EQ(refusal({ { .name = "fat", .labels = { 9 } } }), "parameter 'fat': no element has the label 9");
        EXPECT_EQ(refusal({ { .name = "fat", .labels = { 1 } }, { .name = "skin", .labels = { 2, 1 } } }),
            "parameter 'skin': the parameter 'fat' has the label 1 too");
        EXPECT_EQ(refusal({ { .name = "bed", .springs = { 100000 } } }), "parameter 'bed': there is no spring 100000");
        EXPECT_EQ(refusal({ { .name = "bed", .springs = { 1 } }, { .name = "joint", .springs = { 1 } } }),
            "parameter 'joint': the parameter 'bed' has the spring 1 too");
        rest(0, 0) = NAN;
        EXPECT_EQ(refusal({}), "displacement: a displacement is not finite");
        rest.conservativeResize(2, 3);
        EXPECT_NE(refusal({}).find("2 displacements for"), std::string::npos);
    }

} // namespace parameter_sensitivity_test
} // namespace retractor::fem
