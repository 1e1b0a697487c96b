#include "fem/linear_algebra/dense_algebra.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/error.h"
#include "tests/support/random_entries.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace retractor::fem {
namespace dense_algebra_test {

    Eigen::MatrixXd positive_definite(Eigen::Index n)
    {
        const Eigen::MatrixXd a = test_support::random_entries(n, n, static_cast<unsigned>(n));
        Eigen::MatrixXd spd = product(a, a.transpose());
        spd.diagonal().array() += 1.0;
        return spd;
    }

    // Small ones at once, large ones in panels on two cores: the last panel narrow, full, and of one column.
    TEST(DenseAlgebra, CholeskyGivesTheMatrixBack)
    {
        for (const Eigen::Index n : { 1, 2, 50, 1000, 1152, 1153 }) {
            const Eigen::MatrixXd a = positive_definite(n);
            Eigen::MatrixXd L = a;
            ASSERT_TRUE(cholesky(L)) << n;
            L.triangularView<Eigen::StrictlyUpper>().setZero();
            const double round_off = static_cast<double>(n) * std::numeric_limits<double>::epsilon() * a.norm();
            EXPECT_LE((product(L, Eigen::MatrixXd(L.transpose())) - a).norm(), round_off) << n;
        }
    }

    TEST(DenseAlgebra, OneThreadAndTwoGiveTheSameBits)
    {
        constexpr Eigen::Index kLarge = 1100; // two cores share from a thousand on
        const Eigen::MatrixXd a = positive_definite(kLarge);
        std::vector<std::int32_t> rows;
        for (std::int32_t i = 0; i < kLarge; ++i)
            rows.push_back(i);
        const auto all = [&] {
            Eigen::MatrixXd L = a, lower = Eigen::MatrixXd::Zero(kLarge, kLarge);
            EXPECT_TRUE(cholesky(L));
            L.triangularView<Eigen::StrictlyUpper>().setZero();
            copy_lower(a, rows, lower);
            const Eigen::MatrixXd lower_part = a.triangularView<Eigen::Lower>();
            EXPECT_EQ(Eigen::MatrixXd(lower.triangularView<Eigen::Lower>()), lower_part);
            return std::vector<Eigen::MatrixXd> { L, product(a, a), times_own_transpose(L) };
        };
        set_solver_threads(1);
        EXPECT_FALSE(solver_has_second_thread());
        const std::vector<Eigen::MatrixXd> one = all();
        set_solver_threads(2);
        EXPECT_TRUE(solver_has_second_thread());
        const std::vector<Eigen::MatrixXd> two = all();
        for (std::size_t i = 0; i < one.size(); ++i)
            EXPECT_EQ(one[i], two[i]) << i;
        const double round_off = static_cast<double>(kLarge) * std::numeric_limits<double>::epsilon() * a.norm();
        EXPECT_LE((two.back() - a).norm(), round_off);
    }

    TEST(DenseAlgebra, CholeskySaysWhenAMatrixIsNotPositiveDefinite)
    {
        for (const Eigen::Index n : { 3, 1200 })
            for (const Eigen::Index bad : { Eigen::Index { 0 }, n / 2, n - 1 }) {
                Eigen::MatrixXd a = positive_definite(n);
                a(bad, bad) = -1.0;
                EXPECT_FALSE(cholesky(a)) << n << " " << bad;
            }
    }

    TEST(DenseAlgebra, ModesGiveTheMatrixBackAndRise)
    {
        constexpr Eigen::Index kRows = 24;
        Eigen::MatrixXd a = test_support::random_entries(kRows, kRows, 3);
        a = (a + a.transpose()).eval(); // has modes of both signs
        const SymmetricModes modes = symmetric_modes(a);
        constexpr double kRoundOff = 10.0 * static_cast<double>(kRows) * std::numeric_limits<double>::epsilon();
        EXPECT_LE(
            (modes.vectors * modes.values.asDiagonal() * modes.vectors.transpose() - a).norm(), kRoundOff * a.norm());
        EXPECT_LE(
            (modes.vectors.transpose() * modes.vectors - Eigen::MatrixXd::Identity(kRows, kRows)).norm(), kRoundOff);
        for (Eigen::Index i = 1; i < kRows; ++i)
            EXPECT_LE(modes.values[i - 1], modes.values[i]);
    }

    TEST(DenseAlgebra, ModesOfAMatrixWithNaNAreRefused)
    {
        Eigen::MatrixXd a = Eigen::MatrixXd::Identity(3, 3);
        a(2, 0) = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW((void)symmetric_modes(a), SolverError);
        EXPECT_EQ(symmetric_modes(Eigen::MatrixXd()).values.size(), 0);
    }

    TEST(DenseAlgebra, ModesAreOfTheLowerTriangleOfASquareMatrix)
    {
        Eigen::MatrixXd a = Eigen::MatrixXd::Identity(3, 3);
        a(0, 2) = 7.0;
        EXPECT_EQ(symmetric_modes(a).values, Eigen::VectorXd::Ones(3));
        EXPECT_THROW((void)symmetric_modes(Eigen::MatrixXd::Ones(3, 4)), InputError);
        EXPECT_THROW((void)symmetric_modes(Eigen::MatrixXd::Ones(4, 3)), InputError);
    }

} // namespace dense_algebra_test
} // namespace retractor::fem
