#include "haptics/condensed/contact_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <random>

namespace retractor::haptics {
namespace contact_solver_test {

    constexpr double kRoundOff = 1e-10; // of well-conditioned systems of at most 24 unknowns, of order 1

    struct Problem {
        Eigen::MatrixXd C;
        Eigen::VectorXd d;
    };

    Problem random_problem(Eigen::Index n, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return entry(random); });
        return { a * a.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n),
            Eigen::VectorXd::NullaryExpr(n, [&] { return entry(random); }) };
    }

    void load(ContactSolver& solver, const Problem& p)
    {
        for (Eigen::Index a = 0; a < p.d.size(); ++a) {
            solver.demand(static_cast<std::size_t>(a)) = p.d[a];
            for (Eigen::Index b = 0; b <= a; ++b)
                solver.compliance(static_cast<std::size_t>(a), static_cast<std::size_t>(b)) = p.C(a, b);
        }
    }

    Eigen::VectorXd forces(const ContactSolver& solver, Eigen::Index n)
    {
        return Eigen::VectorXd::NullaryExpr(
            n, [&](Eigen::Index a) { return solver.force(static_cast<std::size_t>(a)); });
    }

    TEST(ContactSolver, TwoPointsInClosedForm)
    {
        // The first pushes the second out of contact: f = d / C alone.
        ContactSolver solver(2);
        load(solver, { (Eigen::Matrix2d() << 2.0, 1.0, 1.0, 3.0).finished(), Eigen::Vector2d(4.0, 1.0) });
        ASSERT_TRUE(solver.solve(2));
        EXPECT_DOUBLE_EQ(solver.force(0), 2.0);
        EXPECT_DOUBLE_EQ(solver.force(1), 0.0);
        EXPECT_DOUBLE_EQ(solver.stiffness(0, 2), 0.5);
        ASSERT_TRUE((solver.pressing(0) = solver.pressing(1) = 1, solver.hold(2)));
        EXPECT_NEAR(solver.force(1), -0.4, kRoundOff); // held, it would be pulled
    }

    TEST(ContactSolver, ForcesPushAndAreComplementaryFromAnyGuess)
    {
        for (unsigned seed = 0; seed < 200; ++seed) {
            const auto n = static_cast<Eigen::Index>(1 + seed % 24);
            const Problem p = random_problem(n, seed);
            ContactSolver solver(24);
            load(solver, p);
            Eigen::VectorXd first;
            for (const int guess : { 0, 1, 2 }) {
                for (Eigen::Index a = 0; a < n; ++a)
                    solver.pressing(static_cast<std::size_t>(a)) = guess == 2 ? (a % 2 == 0) : guess == 1;
                ASSERT_TRUE(solver.solve(static_cast<std::size_t>(n))) << seed;
                const Eigen::VectorXd f = forces(solver, n), gap = p.C * f - p.d;
                EXPECT_GE(f.minCoeff(), 0.0) << seed;
                EXPECT_GE(gap.minCoeff(), -kRoundOff) << seed;
                EXPECT_LT((f.array() * gap.array()).abs().maxCoeff(), kRoundOff) << seed;
                if (guess == 0)
                    first = f;
                EXPECT_LT((f - first).cwiseAbs().maxCoeff(), kRoundOff) << seed; // the answer is unique
            }
        }
    }

    TEST(ContactSolver, AGoodGuessTakesOneFactorisation)
    {
        const Problem p = random_problem(24, 7);
        ContactSolver solver(24);
        load(solver, p);
        ASSERT_TRUE(solver.solve(24));
        ASSERT_TRUE(solver.solve(24));
        EXPECT_EQ(solver.factorisations(), 1);
    }

    TEST(ContactSolver, StiffnessIsTheDerivativeOfTheForceByTheDemand)
    {
        Problem p = random_problem(12, 3);
        p.d = p.d.cwiseAbs();
        ContactSolver solver(12);
        load(solver, p);
        ASSERT_TRUE(solver.solve(12));
        const double k = solver.stiffness(0, 6), before = forces(solver, 6).sum();
        constexpr double kStep = 1e-6;
        for (std::size_t a = 0; a < 6; ++a)
            solver.demand(a) += kStep;
        ASSERT_TRUE(solver.solve(12));
        EXPECT_NEAR((forces(solver, 6).sum() - before) / kStep, k, 1e-6 * std::abs(k)); // linear while the set stays
    }

    TEST(ContactSolver, WhatIsNotPositiveDefiniteHasNoAnswer)
    {
        ContactSolver solver(2);
        load(solver, { (Eigen::Matrix2d() << 1.0, 2.0, 2.0, 1.0).finished(), Eigen::Vector2d(1.0, 1.0) });
        EXPECT_FALSE(solver.solve(2));
        load(solver, { (Eigen::Matrix2d() << std::nan(""), 0.0, 0.0, 1.0).finished(), Eigen::Vector2d(1.0, 1.0) });
        EXPECT_FALSE(solver.solve(2));
        EXPECT_TRUE(solver.solve(0));
    }

} // namespace contact_solver_test
} // namespace retractor::haptics
