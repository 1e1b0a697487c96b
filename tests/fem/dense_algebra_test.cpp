#include "fem/dense_algebra.h"
#include "fem/sparse_cholesky.h"
#include "random_entries.h"

#include <gtest/gtest.h>

#include <limits>

namespace retractor {
namespace {

    Eigen::MatrixXd positive_definite(Eigen::Index n)
    {
        const Eigen::MatrixXd a = random_entries(n, n, static_cast<unsigned>(n));
        Eigen::MatrixXd spd = product(a, a.transpose());
        spd.diagonal().array() += 1.0;
        return spd;
    }

    // Small ones at once, large ones in panels on two cores: the last panel narrow, full, and of one column.
    TEST(DenseAlgebra, CholeskyGivesTheMatrixBack)
    {
        set_blas_threads(1); // as in the programs
        for (const Eigen::Index n : { 1, 2, 50, 1000, 1152, 1153 }) {
            const Eigen::MatrixXd a = positive_definite(n);
            Eigen::MatrixXd L = a;
            ASSERT_TRUE(cholesky(L)) << n;
            L.triangularView<Eigen::StrictlyUpper>().setZero();
            const double round_off = static_cast<double>(n) * std::numeric_limits<double>::epsilon() * a.norm();
            EXPECT_LE((product(L, Eigen::MatrixXd(L.transpose())) - a).norm(), round_off) << n;
        }
    }

    TEST(DenseAlgebra, CholeskySaysWhenAMatrixIsNotPositiveDefinite)
    {
        set_blas_threads(1);
        for (const Eigen::Index n : { 3, 1200 })
            for (const Eigen::Index bad : { Eigen::Index { 0 }, n / 2, n - 1 }) {
                Eigen::MatrixXd a = positive_definite(n);
                a(bad, bad) = -1.0;
                EXPECT_FALSE(cholesky(a)) << n << " " << bad;
            }
    }

} // namespace
} // namespace retractor
