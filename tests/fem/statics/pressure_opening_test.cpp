// Wounds under pressure: Opening with ElasticProblem::pressures.

#include "fem/error_estimation/error_estimate.h"
#include "fem/io/calculix_deck.h"
#include "fem/io/febio_file.h"
#include "fem/statics/driven_opening.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::fem {
namespace pressure_opening_test {

    using namespace test_support;

    constexpr double kEdge = 2.5, kTop = 5.0, kSide = 10.0; // mm
    constexpr double kArea = kSide * kSide;

    /// A block that a hook holds by its top, pressed on from below.
    ElasticProblem pressed_block(double pressure, double poissons_ratio = 0.0)
    {
        ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(4, 4, 2, kEdge);
        problem.material_of_label = { {}, test_support::material(0.05, poissons_ratio) };
        problem.hooks = { { "top", 1, {}, Vec3::Zero() } };
        for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertex_count()); ++v)
            if (problem.mesh.vertices(v, 2) == kTop)
                problem.hooks[0].nodes.push_back(v);
        problem.pressures = { { "gas",
            verification::faces_where(problem.mesh, [](const Vec3& x) { return x.z() == 0.0; }), pressure } };
        return problem;
    }

    OpeningResult opened(const ElasticProblem& problem, Elasticity elasticity, bool locking_free = false)
    {
        OpeningOptions options { .elasticity = elasticity, .locking_free = locking_free, .tolerance = 1e-9 };
        return Opening(problem, options).open(problem.hooks);
    }

    TEST(PressureOpening, HooksBearWhatPressesAndTheBlockIsASpring)
    {
        const double p = 1e-5; // MPa: a strain of 2e-4
        for (const Elasticity elasticity : { Elasticity::linear, Elasticity::corotational, Elasticity::hyperelastic })
            for (const bool locking_free : { false, true }) {
                const ElasticProblem problem = pressed_block(p);
                const OpeningResult result = opened(problem, elasticity, locking_free);
                ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
                const double nonlinear = elasticity == Elasticity::linear ? 1e-8 : 5e-4; // the strain
                EXPECT_NEAR(result.hook_forces_N[0].z() / (p * kArea), -1.0, nonlinear);
                for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v)
                    EXPECT_NEAR(result.displacement(v, 2), p / 0.05 * (kTop - problem.mesh.vertices(v, 2)),
                        nonlinear * p / 0.05 * kTop);
            }
    }

    TEST(PressureOpening, TenNodeElementsFeelTheSame)
    {
        const double p = 1e-3;
        const ElasticProblem problem = pressed_block(p, 0.4), fine = with_midpoints(problem);
        const OpeningResult plain = opened(problem, Elasticity::linear), quadratic = opened(fine, Elasticity::linear);
        EXPECT_NEAR(plain.hook_forces_N[0].z(), -p * kArea, 1e-8 * p * kArea);
        EXPECT_NEAR(quadratic.hook_forces_N[0].z(), -p * kArea, 1e-8 * p * kArea);
    }

    /// A ring round z, of inner radius 10 and outer radius 15 mm, that next to nothing holds.
    ElasticProblem ring(double pressure)
    {
        constexpr int kAround = 24, kThrough = 3;
        constexpr double kInner = 10.0, kThickness = 5.0, kLeastBed = 1e-7; // N/mm
        ElasticProblem problem;
        const mesh::TetMesh box = mesh::kuhn_box(kAround, kThrough, 1, 1.0);
        problem.mesh = box;
        const auto at = [](double x, double y, double z) {
            const double angle = -2.0 * std::numbers::pi * x / kAround, r = kInner + kThickness * y / kThrough;
            return Vec3(r * std::cos(angle), r * std::sin(angle), 2.0 * z);
        };
        std::map<std::array<long, 3>, VertexId> first; // the box's two ends are one
        std::vector<VertexId> same;
        Points vertices = box.vertices;
        VertexId count = 0;
        for (Eigen::Index v = 0; v < box.vertices.rows(); ++v) {
            const std::array<long, 3> key { std::lround(box.vertices(v, 0)) % kAround, std::lround(box.vertices(v, 1)),
                std::lround(box.vertices(v, 2)) };
            const auto [found, added] = first.insert({ key, count });
            if (added)
                vertices.row(count++) = at(box.vertices(v, 0), box.vertices(v, 1), box.vertices(v, 2)).transpose();
            same.push_back(found->second);
        }
        vertices.conservativeResize(count, 3);
        problem.mesh.vertices = vertices;
        for (VertexId& v : problem.mesh.nodes)
            v = same[static_cast<std::size_t>(v)];
        problem.material_of_label = { {}, test_support::material(0.05, 0.3) };
        for (VertexId v = 0; v < count; ++v)
            problem.supports.bedded.push_back({ v, kLeastBed });
        problem.pressures = { { "blood",
            verification::faces_where(
                problem.mesh, [](const Vec3& x) { return x.head<2>().norm() < kInner + 0.1 * kThickness; }),
            pressure } };
        return problem;
    }

    TEST(PressureOpening, ARingUnderInnerPressureWidensAsLameSays)
    {
        constexpr double kPolygon = 0.02; // 24 sides are no circle
        const double p = 1e-5, E = 0.05, nu = 0.3, a2 = 100.0, b2 = 225.0; // free in height
        const double exact = p * 10.0 / E * ((a2 + b2) / (b2 - a2) + nu);
        const ElasticProblem problem = with_midpoints(ring(p));
        const OpeningResult result = opened(problem, Elasticity::linear);
        ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
        double widened = 0.0;
        int nodes = 0;
        for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v) {
            const Eigen::RowVector2d radius = problem.mesh.vertices.row(v).head<2>();
            if (std::abs(radius.norm() - 10.0) < 1e-9) {
                widened += result.displacement.row(v).head<2>().dot(radius.normalized());
                ++nodes;
            }
        }
        EXPECT_NEAR(widened / nodes / exact, 1.0, kPolygon);
    }

    TEST(PressureOpening, HooksBearWhatPressesOnTheDeformedSurface)
    {
        ElasticProblem problem = pressed_block(0.01, 0.4); // strains of some 20 %
        for (const Elasticity elasticity : { Elasticity::corotational, Elasticity::hyperelastic }) {
            const OpeningResult result = opened(problem, elasticity);
            ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
            const Eigen::VectorXd u
                = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
            Vec3 pressed = Vec3::Zero();
            const Eigen::VectorXd force = external_loads(problem).pressures[0].force(u);
            for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v)
                pressed += force.segment<3>(3 * v);
            EXPECT_LT((result.hook_forces_N[0] + pressed).norm(), 1e-6 * pressed.norm());
            EXPECT_GT(std::abs(pressed.z() / (0.01 * kArea) - 1.0), 0.02) << "another area than at rest";
        }
    }

    TEST(PressureOpening, SuctionPullsAsPressurePushes)
    {
        const OpeningResult pushed = opened(pressed_block(1e-3, 0.4), Elasticity::linear),
                            pulled = opened(pressed_block(-1e-3, 0.4), Elasticity::linear);
        EXPECT_LT((pushed.displacement + pulled.displacement).norm(), 1e-9 * pushed.displacement.norm());
        EXPECT_EQ(opened(pressed_block(-1e-3, 0.4), Elasticity::hyperelastic).status, OpeningStatus::converged);
    }

    /// The estimate's finer elements are under the same pressure, following the same answer.
    TEST(PressureOpening, TheEstimateKnowsOfIt)
    {
        const double p = 2e-3;
        const ElasticProblem problem = pressed_block(p, 0.4);
        const OpeningResult plain = opened(problem, Elasticity::corotational);
        ASSERT_EQ(plain.status, OpeningStatus::converged) << plain.message;
        const OpeningResult quadratic = opened(with_midpoints(problem), Elasticity::corotational);
        ASSERT_EQ(quadratic.status, OpeningStatus::converged) << quadratic.message;
        const ErrorEstimate estimate = estimate_error(problem, Elasticity::corotational, plain.displacement);
        ASSERT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
        const Points corners = quadratic.displacement.topRows(plain.displacement.rows());
        EXPECT_LT((estimate.displacement - corners).norm(), 0.2 * (plain.displacement - corners).norm());
        EXPECT_LT(estimate.algebraic_error, 1e-6); // the answer is at rest under it
    }

    /// Its error is relative to what pressure has done, not to what it could do to all that the surface encloses.
    TEST(PressureOpening, TheEstimatesEnergyIsOneOfDisplacements)
    {
        constexpr double kSmall = 1e-6, kAlike = 0.01; // MPa; bodies that small strains do not tell apart
        ElasticProblem problem = pressed_block(kSmall, 0.4);
        problem.pressures[0].faces = verification::faces_where(
            problem.mesh, [](const Vec3& x) { return x.z() == 0.0 || x.x() == 0.0; }); // round a corner
        const auto error = [&](Elasticity elasticity) {
            const ErrorEstimate estimate
                = estimate_error(problem, elasticity, opened(problem, elasticity).displacement);
            EXPECT_EQ(estimate.status, EstimateStatus::done) << estimate.message;
            return estimate.energy_error;
        };
        EXPECT_NEAR(error(Elasticity::corotational) / error(Elasticity::linear), 1.0, kAlike);
    }

    /// Drawn by a force, the hook goes where pressure and force balance.
    TEST(PressureOpening, DrivenHooksRestWhereForceAndPressureBalance)
    {
        const double p = 1e-4;
        ElasticProblem problem = pressed_block(p);
        for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertex_count()); ++v)
            if (problem.mesh.vertices(v, 2) == 0.0)
                problem.supports.bedded.push_back({ v, 0.01 });
        const std::vector<HookDrive> drives { { .force_N = Vec3(0.0, 0.0, 0.002) } };
        const DrivenOpening driven
            = open_driven(problem, drives, { .elasticity = Elasticity::corotational, .tolerance = 1e-9 });
        ASSERT_EQ(driven.opening.status, OpeningStatus::converged) << driven.opening.message;
        constexpr double kAtRest = 2e-3; // of the force: the hook's last step
        EXPECT_NEAR(driven.opening.hook_forces_N[0].z() / 0.002, 1.0, kAtRest);
    }

    /// A square duct between two held ends.
    ElasticProblem duct(double pressure)
    {
        ElasticProblem problem;
        const mesh::TetMesh box = mesh::kuhn_box(6, 6, 4, 1.0);
        mesh::TetMesh& mesh = problem.mesh;
        mesh.vertices = box.vertices;
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                middle += 0.25 * box.vertices.row(v).transpose();
            if (std::max(std::abs(middle.x() - 3.0), std::abs(middle.y() - 3.0)) < 2.0)
                continue;
            mesh.nodes.insert(mesh.nodes.end(), box.tet(t).begin(), box.tet(t).end());
            mesh.labels.push_back(1);
        }
        problem.material_of_label = { {}, test_support::material(0.05, 0.45) };
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 2) == 0.0 || mesh.vertices(v, 2) == 4.0)
                problem.supports.fixed.push_back(v);
        std::vector<mesh::TetFace> bore = verification::faces_where(
            mesh, [](const Vec3& x) { return std::max(std::abs(x.x() - 3.0), std::abs(x.y() - 3.0)) < 2.1; });
        problem.pressures = { { "blood", std::move(bore), pressure } };
        return problem;
    }

    TEST(PressureOpening, AboveWhatAVesselHoldsThereIsNoEquilibriumAndThatIsSaid)
    {
        const double far_too_much = 0.1; // MPa; its modulus is half of that
        ElasticProblem problem = duct(far_too_much);
        const OpeningResult burst = opened(problem, Elasticity::hyperelastic);
        EXPECT_EQ(burst.status, OpeningStatus::not_converged);
        EXPECT_NE(
            burst.message.find("no equilibrium at p = 100 kPa (blood), last load step that held: "), std::string::npos)
            << burst.message;
        EXPECT_NE(burst.message.find("needs a law that stiffens (fibres)"), std::string::npos) << burst.message;
        const OpeningResult held = opened(duct(0.02 * far_too_much), Elasticity::hyperelastic);
        EXPECT_EQ(held.status, OpeningStatus::converged) << held.message;
        EXPECT_EQ(held.message.find("no equilibrium"), std::string::npos) << held.message;
    }

    TEST(PressureOpening, WhatTissueDoesNotBearIsTheHooksWayOrThePressure)
    {
        // Crushed flat by its hook, under a pressure that moves it by hundredths of a millimetre.
        ElasticProblem crushed = pressed_block(1e-4, 0.3);
        for (VertexId v = 0; v < static_cast<VertexId>(crushed.mesh.vertex_count()); ++v)
            if (crushed.mesh.vertices(v, 2) == 0.0)
                crushed.supports.fixed.push_back(v);
        crushed.pressures[0].faces
            = verification::faces_where(crushed.mesh, [](const Vec3& x) { return x.x() == 0.0; });
        crushed.hooks[0].displacement = -1.2 * kTop * Vec3::UnitZ();
        const OpeningResult by_hook = opened(crushed, Elasticity::hyperelastic);
        EXPECT_EQ(by_hook.status, OpeningStatus::not_converged);
        EXPECT_NE(by_hook.message.find("of the motion of the hooks and supports"), std::string::npos)
            << by_hook.message;
        EXPECT_NE(by_hook.message.find("but not the next step of the hooks"), std::string::npos) << by_hook.message;
        EXPECT_EQ(by_hook.message.find("no equilibrium at p"), std::string::npos) << by_hook.message;

        ElasticProblem burst = duct(0.1);
        burst.hooks = { { "aside", 1, { burst.supports.fixed.back() }, Vec3(0.1, 0.0, 0.0) } };
        burst.supports.fixed.pop_back();
        const OpeningResult by_pressure = opened(burst, Elasticity::hyperelastic);
        EXPECT_EQ(by_pressure.status, OpeningStatus::not_converged);
        EXPECT_NE(by_pressure.message.find("no equilibrium at p = 100 kPa (blood)"), std::string::npos)
            << by_pressure.message;
        EXPECT_NE(by_pressure.message.find("the hooks had made the same share of their motion"), std::string::npos)
            << by_pressure.message;
    }

    TEST(PressureOpening, IsWrittenForCalculixAsAtRestAndRefusedElsewhere)
    {
        const ElasticProblem problem = pressed_block(1e-3);
        EXPECT_NE(calculix_deck(problem).find("*CLOAD"), std::string::npos);
        Vec3 sum = Vec3::Zero();
        const Eigen::VectorXd loads = nodal_loads(problem);
        for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v)
            sum += loads.segment<3>(3 * v);
        EXPECT_LT((sum - Vec3(0.0, 0.0, 1e-3 * kArea)).norm(), 1e-12);
        EXPECT_EQ(test_support::message_of([&] { (void)febio_file(problem); }),
            "pressure of gas: FEBio files are written without pressure");
        OpeningOptions near { .near = std::vector<std::uint8_t>(problem.mesh.tet_count(), 1) };
        EXPECT_EQ(test_support::message_of([&] { (void)Opening(problem, near); }),
            "nonlinear region: a condensed region cannot be combined with pressure");
    }

} // namespace pressure_opening_test
} // namespace retractor::fem
