#include "fem/model/elastic_body.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/contact.h"
#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/body_force.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace retractor::fem {
namespace assembly_test {

    using namespace test_support;

    const Material kTissue = test_support::material(1.0, 0.3);

    mesh::TetMesh p1_or_p2(const mesh::TetMesh& mesh, int nodes_per_tet)
    {
        return nodes_per_tet == 10 ? mesh::with_midpoints(mesh) : mesh;
    }

    Vec3 linear_field(const Vec3& p)
    {
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        return gradient * p + Vec3(0.1, 0.2, 0.3);
    }

    TEST(PatchTest, LinearFieldIsExactOnADistortedMesh)
    {
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(4, 2.0, 0.3, 1), n);
            ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
            const Eigen::VectorXd exact = verification::nodal_values(mesh, linear_field);
            const Eigen::VectorXd u = test_support::solve_linear(
                body, test_support::boundary_unknowns(mesh), exact, Eigen::VectorXd::Zero(exact.size()));
            EXPECT_LE((u - exact).cwiseAbs().maxCoeff(), 1e-13) << n; // round-off times a condition of about 1e2
        }
    }

    TEST(PatchTest, LinearFieldIsExactWithASliver)
    {
        constexpr double kHeight = 1e-6; // of the sliver, relative to what it was
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::box_with_sliver(kHeight), n);
            ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
            const Eigen::VectorXd exact = verification::nodal_values(mesh, linear_field);
            const Eigen::VectorXd u = test_support::solve_linear(
                body, test_support::boundary_unknowns(mesh), exact, Eigen::VectorXd::Zero(exact.size()));
            EXPECT_LE((u - exact).cwiseAbs().maxCoeff(), 1e-15 / kHeight)
                << n; // round-off times the sliver's condition
        }
    }

    int zero_eigenvalues(const mesh::TetMesh& mesh, Elasticity model)
    {
        ElasticBody body(mesh, model, test_support::uniform(mesh, kTissue));
        const Eigen::MatrixXd K
            = test_support::dense(body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), true));
        const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
        EXPECT_GE(values.minCoeff(), -1e-13 * values.maxCoeff());
        return static_cast<int>((values.array() < 1e-12 * values.maxCoeff()).count());
    }

    TEST(NullSpace, SixRigidMotionsPerPiece)
    {
        for (const int n : { 4, 10 })
            for (const Elasticity model : { Elasticity::linear, Elasticity::corotational })
                for (int pieces = 1; pieces <= 3; ++pieces)
                    EXPECT_EQ(zero_eigenvalues(verification::side_by_side(
                                                   p1_or_p2(verification::distorted_box(2, 1.0, 0.2, 2), n), pieces),
                                  model),
                        6 * pieces)
                        << n;
    }

    TEST(Rotation, OfNinetyDegreesCostsNothingInCorotationalAndDoesInLinear)
    {
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(3, 1.0, 0.2, 3), n);
            const Eigen::VectorXd u
                = verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p + Vec3(5, 0, 0); });
            const ElasticBody corotational(mesh, Elasticity::corotational, test_support::uniform(mesh, kTissue));
            const ElasticBody linear(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
            const double volume = 27.0;
            EXPECT_LE(corotational.response(u).energy, 1e-26 * volume) << n;
            EXPECT_LE(corotational.response(u).forces.norm(), 1e-12) << n;
            EXPECT_GT(linear.response(u).energy, 0.1 * volume * lame(kTissue).mu) << n;
        }
    }

    TEST(Derivatives, ForcesAndStiffnessOfTheBody)
    {
        std::mt19937 random(9);
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(2, 1.0, 0.2, 5), n);
            ElasticBody body(mesh, Elasticity::corotational, test_support::uniform(mesh, kTissue));
            const auto size = 3 * mesh.vertices.rows();
            const Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(size, [&] { return 0.1 * entry(random); });
            const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(size, [&] { return entry(random); });
            constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
            const auto plus = body.response(u + h * d), minus = body.response(u - h * d);
            EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), body.response(u).forces.dot(d), 1e-7) << n;
            const Eigen::VectorXd Kd = body.stiffness(u, false).multiply(d);
            EXPECT_LE((Kd - (plus.forces - minus.forces) / (2 * h)).norm(), 1e-6 * Kd.norm()) << n;
        }
    }

    // -- Manufactured solution on the unit box: order of convergence.

    constexpr double kPi = std::numbers::pi;
    const Lame kLame = lame(kTissue);

    Vec3 smooth(const Vec3& p)
    {
        const double s = std::sin(kPi * p.x()) * std::sin(kPi * p.y()) * std::sin(kPi * p.z());
        return { s, 0.0, 0.0 };
    }

    /// - div sigma of `smooth`.
    Vec3 smooth_force(const Vec3& p)
    {
        const double sx = std::sin(kPi * p.x()), sy = std::sin(kPi * p.y()), sz = std::sin(kPi * p.z());
        const double cx = std::cos(kPi * p.x()), cy = std::cos(kPi * p.y()), cz = std::cos(kPi * p.z());
        const double shared = kPi * kPi * (kLame.lambda + kLame.mu);
        return { kPi * kPi * 3.0 * kLame.mu * sx * sy * sz + shared * sx * sy * sz, -shared * cx * cy * sz,
            -shared * cx * sy * cz };
    }

    struct Errors {
        double l2 = 0.0, energy = 0.0;
    };

    Errors manufactured(int nodes_per_tet, int cells)
    {
        const mesh::TetMesh mesh = p1_or_p2(mesh::kuhn_box(cells, cells, cells, 1.0 / cells), nodes_per_tet);
        ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
        const Eigen::VectorXd loads = verification::body_force_loads(mesh, smooth_force);
        const Eigen::VectorXd u = test_support::solve_linear(
            body, test_support::boundary_unknowns(mesh), Eigen::VectorXd::Zero(loads.size()), loads);
        // Galerkin: |u - u_h|^2 in energy = a(u, u) - a(u_h, u_h); a(u, u) = pi^2 (4 mu + lambda) / 8.
        const double exact = kPi * kPi * (4.0 * kLame.mu + kLame.lambda) / 8.0;
        return { verification::l2_error(mesh, u, smooth), std::sqrt(exact - loads.dot(u)) };
    }

    TEST(Body, StiffenedElementsRespondAsStifferTissueDoes)
    {
        constexpr double kFactor = 10.0;
        const mesh::TetMesh box = mesh::kuhn_box(2, 2, 2, 20.0);
        const std::vector<TetId> some { 3, 7, 20 };
        const Lame soft { 0.02, 0.1 };
        std::vector<Lame> lame(box.tet_count(), soft);
        ElasticBody body(box, Elasticity::corotational, lame);
        for (const TetId t : some)
            lame[static_cast<std::size_t>(t)] = { kFactor * soft.mu, kFactor * soft.lambda };
        const ElasticBody stiffer(box, Elasticity::corotational, lame);
        Eigen::VectorXd u(3 * box.vertices.rows());
        for (Eigen::Index i = 0; i < u.size(); ++i)
            u[i] = std::sin(1.0 + 7.0 * static_cast<double>(i)); // mm
        const double before = body.response(u).energy;
        body.stiffen(some, kFactor);
        EXPECT_GT(body.response(u).energy, before);
        EXPECT_DOUBLE_EQ(body.response(u).energy, stiffer.response(u).energy);
        EXPECT_TRUE(body.response(u).forces.isApprox(stiffer.response(u).forces));
    }

    TEST(Convergence, ManufacturedSolutionHasTheExpectedOrders)
    {
        struct Case {
            int nodes_per_tet, coarse, fine;
            double l2_order, energy_order;
        };
        constexpr double kSlack = 0.25; // not yet asymptotic on meshes this coarse
        for (const Case& c : { Case { 4, 8, 16, 2.0, 1.0 }, Case { 10, 4, 8, 3.0, 2.0 } }) {
            const Errors coarse = manufactured(c.nodes_per_tet, c.coarse), fine = manufactured(c.nodes_per_tet, c.fine);
            EXPECT_NEAR(std::log2(coarse.l2 / fine.l2), c.l2_order, kSlack) << c.nodes_per_tet;
            EXPECT_NEAR(std::log2(coarse.energy / fine.energy), c.energy_order, kSlack) << c.nodes_per_tet;
        }
    }

    TEST(BadInput, AnElementFoldedByItsMidpointsIsRefused)
    {
        mesh::TetMesh mesh = mesh::with_midpoints(mesh::kuhn_box(1, 1, 1, 1.0));
        const VertexId midpoint = mesh.tet(2)[4];
        mesh.vertices.row(midpoint) += Eigen::RowVector3d(2, 2, 2);
        EXPECT_THROW(ElasticBody(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue)), InputError);
    }

    TEST(BadInput, AFloatingBodyIsNotPositiveDefiniteAndTheNodeIsNamed)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0);
        ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
        std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
        const BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(24), true);
        ConstrainedSolver solver(K.pattern, prescribed);
        BlockMatrix pushed = K; // a negative spring at node 3 makes it indefinite, not merely singular
        const auto diagonal = static_cast<std::size_t>(K.pattern.row_start[4] - 1);
        pushed.values[9 * diagonal + 4] -= 100.0;
        try {
            solver.factorise(pushed);
            FAIL() << "accepted";
        } catch (const SolverError& error) {
            EXPECT_NE(error.where().find("node "), std::string::npos) << error.where();
        }
    }

    TEST(ConstrainedSolver, AnOldFactorPreconditionsAMatrixOfAnotherPattern)
    {
        const mesh::TetMesh mesh = verification::distorted_box(5, 2.0, 0.2, 1);
        ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
        const std::vector<std::uint8_t> prescribed = test_support::boundary_unknowns(mesh);
        const BlockMatrix K = body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 1.0);
        ConstrainedSolver solver(K.pattern, prescribed);
        solver.factorise(K);

        // A spring between two nodes that share no element.
        std::vector<std::int32_t> inner;
        for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
            if (prescribed[3 * v] == 0)
                inner.push_back(static_cast<std::int32_t>(v));
        ASSERT_GE(inner.size(), 2U);
        const std::pair ends(inner.back(), inner.front());
        BlockMatrix with_spring;
        with_spring.pattern = extended_pattern(K.pattern, { ends });
        with_spring.values.assign(9 * with_spring.pattern.block_count(), 0.0);
        ASSERT_EQ(with_spring.pattern.block_count(), K.pattern.block_count() + 1);
        for (std::size_t row = 0, from = 0, to = 0; row < K.pattern.row_count(); ++row)
            for (auto end = static_cast<std::size_t>(with_spring.pattern.row_start[row + 1]); to < end; ++to) {
                const bool added
                    = static_cast<std::int32_t>(row) == ends.first && with_spring.pattern.column[to] == ends.second;
                if (!added)
                    std::copy_n(K.values.begin() + static_cast<std::ptrdiff_t>(9 * from++), 9,
                        with_spring.values.begin() + static_cast<std::ptrdiff_t>(9 * to));
                const bool on_diagonal = with_spring.pattern.column[to] == static_cast<std::int32_t>(row);
                const bool at_end
                    = static_cast<std::int32_t>(row) == ends.first || static_cast<std::int32_t>(row) == ends.second;
                constexpr double kSpring = 3.0; // N/mm, along each axis
                for (const std::size_t i : { 0U, 4U, 8U })
                    with_spring.values[9 * to + i] += added ? -kSpring : on_diagonal && at_end ? kSpring : 0.0;
            }
        const Eigen::VectorXd b = verification::nodal_values(mesh, linear_field);
        ConstrainedSolver fresh(with_spring.pattern, prescribed);
        fresh.factorise(with_spring);
        const Eigen::VectorXd expected = fresh.solve(b);
        const double size = expected.cwiseAbs().maxCoeff();

        solver.change_pattern();
        constexpr double kTolerance = 1e-10;
        const ConstrainedSolver::Iterated iterated = solver.iterate(with_spring, b, kTolerance, 20);
        EXPECT_TRUE(iterated.converged);
        EXPECT_GT(iterated.iterations, 1); // the factor is that of the body without the spring
        EXPECT_LE((iterated.solution - expected).cwiseAbs().maxCoeff(), 100.0 * kTolerance * size);
        solver.factorise(with_spring);
        EXPECT_LE((solver.solve(b) - expected).cwiseAbs().maxCoeff(), 1e-13 * size);
    }

} // namespace assembly_test
} // namespace retractor::fem
