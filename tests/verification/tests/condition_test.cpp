#include "tests/verification/framework/condition.h"

#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace retractor::verification {
namespace condition_test {

    using namespace test_support;

    constexpr double kClose = 0.03; // power iteration comes from below and stops early

    /// Condition number of the free part, by all its eigenvalues. @param scaled to a unit diagonal first.
    double exact_condition(const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed, bool scaled)
    {
        const Eigen::MatrixXd all = test_support::dense(K);
        std::vector<Eigen::Index> free;
        for (std::size_t i = 0; i < prescribed.size(); ++i)
            if (prescribed[i] == 0)
                free.push_back(static_cast<Eigen::Index>(i));
        Eigen::MatrixXd A = all(free, free);
        if (scaled) {
            const Eigen::VectorXd d = A.diagonal().cwiseSqrt().cwiseInverse();
            A = d.asDiagonal() * A * d.asDiagonal();
        }
        const Eigen::VectorXd values
            = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
        return values.maxCoeff() / values.minCoeff();
    }

    TEST(Condition, AgreesWithTheEigenvaluesAlsoOfStiffOnSoft)
    {
        const mesh::TetMesh mesh = distorted_box(3, 1.0, 0.2, 3);
        std::vector<fem::Lame> parameters = test_support::uniform(mesh, test_support::material(1.0, 0.3));
        for (std::size_t t = 0; t < parameters.size() / 2; ++t)
            parameters[t] = fem::lame(test_support::material(1e4, 0.3));
        fem::ElasticBody body(mesh, fem::Elasticity::linear, parameters);
        Held held = hold_nothing(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            for (int axis = 0; axis < 3 && mesh.vertices(v, 2) == 0.0; ++axis)
                hold(held, v, axis);
        const fem::BlockMatrix& K = body.stiffness(held.target, 0.0);
        const ConditionEstimate estimate = estimate_condition(K, held.prescribed);
        const double number = exact_condition(K, held.prescribed, false),
                     scaled = exact_condition(K, held.prescribed, true);
        EXPECT_NEAR(estimate.number / number, 1.0, kClose);
        EXPECT_NEAR(estimate.scaled / scaled, 1.0, kClose);
        EXPECT_LE(estimate.scaled, 0.1 * estimate.number) << "scaling takes the ratio of the moduli out";
    }

    TEST(Condition, IsOneWhereNothingIsFree)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0);
        fem::ElasticBody body(
            mesh, fem::Elasticity::linear, test_support::uniform(mesh, test_support::material(1.0, 0.3)));
        const std::vector<std::uint8_t> all(3 * mesh.vertex_count(), 1);
        EXPECT_EQ(estimate_condition(body.stiffness(Eigen::VectorXd::Zero(24), 0.0), all).number, 1.0);
    }

    TEST(Condition, ABodyThatFloatsIsRefused)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0);
        fem::ElasticBody body(
            mesh, fem::Elasticity::linear, test_support::uniform(mesh, test_support::material(1.0, 0.3)));
        std::vector<std::uint8_t> held(3 * mesh.vertex_count(), 0);
        held[0] = held[1] = 1;
        const fem::BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(24), 0.0);
        const std::string said = test_support::message_of([&] {
            const ConditionEstimate estimate = estimate_condition(K, held);
            if (estimate.number > 1e14) // round-off made it definite
                throw SolverError("not positive definite");
        });
        EXPECT_NE(said.find("not positive definite"), std::string::npos) << said;
    }

} // namespace condition_test
} // namespace retractor::verification
