#include "fem/linear_algebra/sparse_cholesky.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/error.h"
#include "tests/support/random_entries.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

namespace retractor::fem {
namespace sparse_cholesky_test {

    struct Matrix {
        SymmetricPattern pattern;
        std::vector<double> values;
        Eigen::MatrixXd dense;
    };

    /// Random sparse matrix, made positive definite by a dominant diagonal.
    Matrix random_matrix(int n, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        Matrix m;
        m.dense = Eigen::MatrixXd::Zero(n, n);
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < j; ++i)
                if (entry(random) > 1.0 - 8.0 / n)
                    m.dense(i, j) = m.dense(j, i) = entry(random);
        for (int j = 0; j < n; ++j)
            m.dense(j, j) = 0.1 + m.dense.col(j).cwiseAbs().sum();
        m.pattern.column_start.push_back(0);
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i <= j; ++i)
                if (m.dense(i, j) != 0.0) {
                    m.pattern.row.push_back(i);
                    m.values.push_back(m.dense(i, j));
                }
            m.pattern.column_start.push_back(static_cast<std::int32_t>(m.pattern.row.size()));
        }
        return m;
    }

    TEST(SparseCholesky, HalvesOfASolveGiveTheInversesEntriesAndThenTheWhole)
    {
        for (const int n : { 1, 5, 50, 300 }) {
            const Matrix m = random_matrix(n, static_cast<unsigned>(n));
            SparseCholesky cholesky;
            cholesky.analyse(m.pattern);
            cholesky.factorise(m.values);
            // Two sets of loads, the second with two entries in a column and one on an unknown of the first.
            const std::vector<SparseCholesky::Load> a { { 0, 0, 1.0 }, { n / 2, 1, -2.0 } },
                b { { n / 3, 0, 0.5 }, { n - 1, 0, 1.0 }, { n / 2, 1, 1.0 }, { n - 1, 0, 1.0 } };
            const auto dense = [&](const std::vector<SparseCholesky::Load>& loads) {
                Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 2);
                for (const auto& load : loads)
                    right(load.unknown, load.column) += load.value;
                return right;
            };
            const SparseCholesky::HalfSolution half_a = cholesky.half_solve(a, 2), half_b = cholesky.half_solve(b, 2);
            const Eigen::MatrixXd x = m.dense.llt().solve(dense(b)), between = dense(a).transpose() * x;
            const double kTol = 1e-12 * x.norm(); // hundreds of sums of numbers near 1
            EXPECT_LE((SparseCholesky::product(half_a, half_b) - between).norm(), kTol) << n;
            EXPECT_LE((cholesky.finish(half_b) - x).norm(), kTol) << n;
        }
    }

    TEST(SparseCholesky, AgreesWithTheDenseSolutionAtManySizes)
    {
        for (const int n : { 1, 2, 3, 5, 8, 17, 50, 120, 300 }) {
            const Matrix m = random_matrix(n, static_cast<unsigned>(n));
            const Eigen::MatrixXd b = test_support::random_entries(n, 3, 7);
            SparseCholesky cholesky;
            cholesky.analyse(m.pattern);
            cholesky.factorise(m.values);
            const Eigen::MatrixXd x = m.dense.llt().solve(b);
            EXPECT_LE((cholesky.solve(b) - x).norm(), 1e-11 * x.norm()) << n;
            EXPECT_GT(cholesky.reciprocal_condition(), 0.0);
            EXPECT_GT(cholesky.bytes(), 0U);
        }
    }

    TEST(SparseCholesky, ARoundedFactorSolvesInSinglePrecisionAndLendsItsMemoryToTheNext)
    {
        for (const int n : { 1, 7, 120, 300 }) {
            Matrix m = random_matrix(n, static_cast<unsigned>(n));
            // Rows of very different sizes, as of bone and fat, and loads below the smallest float.
            for (int j = 0; j < n; ++j)
                for (std::int32_t k = m.pattern.column_start[static_cast<std::size_t>(j)];
                     k < m.pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
                    const auto scale = [](int i) { return i % 2 == 0 ? 1.0 : 1e3; };
                    const int i = m.pattern.row[static_cast<std::size_t>(k)];
                    m.values[static_cast<std::size_t>(k)] *= scale(i) * scale(j);
                    m.dense(i, j) = m.dense(j, i) = m.values[static_cast<std::size_t>(k)];
                }
            const Eigen::VectorXd b = 1e-60 * test_support::random_entries(n, 1, 7);
            const Eigen::VectorXd x = m.dense.llt().solve(b);
            SparseCholesky cholesky;
            cholesky.analyse(m.pattern);
            cholesky.factorise(m.values);
            const std::size_t bytes = cholesky.bytes();
            cholesky.round_to_single();
            cholesky.round_to_single(); // changes nothing
            EXPECT_TRUE(cholesky.rounded());
            EXPECT_EQ(cholesky.bytes(), bytes);
            const Eigen::VectorXd rounded = cholesky.solve_rounded(b);
            // Round-off of floats, times the condition of the scaled matrix (below 100).
            constexpr double kTol = 1e-5;
            EXPECT_LE(((rounded - x).array() / (x.array().abs() + 1e-3 * x.norm())).abs().maxCoeff(), kTol) << n;
            EXPECT_EQ(cholesky.solve_rounded(Eigen::VectorXd::Zero(n)).norm(), 0.0);
            cholesky.factorise(m.values);
            EXPECT_FALSE(cholesky.rounded());
            EXPECT_EQ(cholesky.bytes(), bytes);
            EXPECT_LE((cholesky.solve(b) - x).norm(), 1e-10 * x.norm()) << n;
        }
    }

    TEST(SparseCholesky, NewValuesOnTheSamePattern)
    {
        Matrix m = random_matrix(60, 1);
        SparseCholesky cholesky;
        cholesky.analyse(m.pattern);
        cholesky.factorise(m.values);
        for (double& v : m.values)
            v *= 2.0;
        cholesky.factorise(m.values);
        const Eigen::VectorXd b = Eigen::VectorXd::Ones(60);
        EXPECT_LE((2.0 * m.dense * cholesky.solve(b) - b).norm(), 1e-12);
    }

    TEST(SparseCholesky, TheTrailingBlockIsTheSchurComplementAndFillsInTheRest)
    {
        for (const int n : { 6, 40, 200 }) {
            const Matrix m = random_matrix(n, 5);
            const int last = n / 3;
            std::vector<std::int32_t> order(static_cast<std::size_t>(n));
            for (int i = 0; i < n; ++i)
                order[static_cast<std::size_t>(i)] = (i + last) % n; // the first unknowns come last
            SparseCholesky cholesky;
            cholesky.analyse_in_order(m.pattern, order);
            cholesky.factorise(m.values);
            EXPECT_EQ(cholesky.elimination_order(), order);
            cholesky.keep_factor_only();
            const Eigen::MatrixXd L = cholesky.trailing_factor(last);
            const Eigen::MatrixXd inner = m.dense.bottomRightCorner(n - last, n - last);
            const Eigen::MatrixXd cross = m.dense.bottomLeftCorner(n - last, last);
            const Eigen::MatrixXd schur
                = m.dense.topLeftCorner(last, last) - cross.transpose() * inner.llt().solve(cross);
            EXPECT_LE((L * L.transpose() - schur).norm(), 1e-13 * schur.norm()) << n;
            for (const int cases : { 1, 4 }) {
                Eigen::MatrixXd x = test_support::random_entries(n, cases, 7);
                const Eigen::MatrixXd expected = -inner.llt().solve(cross * x.topRows(last));
                cholesky.fill_from_trailing(last, x);
                EXPECT_LE((x.bottomRows(n - last) - expected).norm(), 1e-13 * expected.norm()) << n;
            }
        }
        SparseCholesky cholesky;
        EXPECT_THROW(cholesky.analyse_in_order(random_matrix(4, 1).pattern, { 0, 1, 1, 2 }), InputError);
        EXPECT_THROW(cholesky.analyse_in_order(random_matrix(4, 1).pattern, { 0, 1, 2 }), InputError);
    }

    std::vector<std::int32_t> as_numbered(int n)
    {
        std::vector<std::int32_t> order(static_cast<std::size_t>(n));
        std::iota(order.begin(), order.end(), 0);
        return order;
    }

    TEST(SparseCholesky, CondensingTakesOffWhatTheSchurComplementLacksAndFillsInTheRest)
    {
        constexpr double kRoundOff = 1e-12;
        for (const int n : { 6, 40, 200, 700 })
            for (const int last : { 1, n / 3, n - 1 }) {
                const Matrix m = random_matrix(n, 11);
                const Eigen::MatrixXd inner = m.dense.topLeftCorner(n - last, n - last),
                                      cross = m.dense.topRightCorner(n - last, last);
                const Eigen::MatrixXd expected = -cross.transpose() * inner.llt().solve(cross);
                SparseCholesky cholesky;
                cholesky.analyse_in_order(m.pattern, as_numbered(n));
                for (int again = 0; again < 2; ++again) { // the second time over the first's numbers
                    Eigen::MatrixXd added = cholesky.condense(m.values, last);
                    added = added.selfadjointView<Eigen::Lower>();
                    EXPECT_LE((added - expected).norm(), kRoundOff * (1.0 + expected.norm())) << n << ", " << last;
                }
                Eigen::MatrixXd x = test_support::random_entries(n, 3, 7);
                const Eigen::MatrixXd inside = -inner.llt().solve(cross * x.bottomRows(last));
                cholesky.fill_from_trailing(last, x);
                EXPECT_LE((x.topRows(n - last) - inside).norm(), kRoundOff * (1.0 + inside.norm())) << n;
                const Eigen::MatrixXd load = test_support::random_entries(n, 2, 8);
                Eigen::MatrixXd y = load;
                cholesky.reduce_to_trailing(last, y);
                const Eigen::MatrixXd alone = inner.llt().solve(load.topRows(n - last));
                EXPECT_LE((y.bottomRows(last) - (load.bottomRows(last) - cross.transpose() * alone)).norm(),
                    kRoundOff * (1.0 + alone.norm()));
                y.bottomRows(last).setZero();
                cholesky.fill_from_trailing_loaded(last, y);
                EXPECT_LE((y.topRows(n - last) - alone).norm(), kRoundOff * (1.0 + alone.norm()));
            }
    }

    TEST(SparseCholesky, CondensingHasTheSameBitsOnOneCoreAndOnTwo)
    {
        // A grid, its last row condensed onto, the rest in an order that has two halves of about the same work.
        constexpr int kColumns = 60, kRows = 40, kSize = kColumns * kRows;
        SymmetricPattern grid, upper_rows;
        std::vector<double> values;
        grid.column_start.push_back(0);
        for (int v = 0; v < kSize; ++v) {
            if (v >= kColumns) {
                grid.row.push_back(v - kColumns);
                values.push_back(-1.0);
            }
            if (v % kColumns > 0) {
                grid.row.push_back(v - 1);
                values.push_back(-1.1);
            }
            grid.row.push_back(v);
            values.push_back(4.3 + 1e-3 * v);
            grid.column_start.push_back(static_cast<std::int32_t>(grid.row.size()));
        }
        constexpr int kFirst = kSize - kColumns;
        upper_rows.column_start.assign(grid.column_start.begin(), grid.column_start.begin() + kFirst + 1);
        upper_rows.row.assign(grid.row.begin(), grid.row.begin() + upper_rows.column_start.back());
        SparseCholesky dissected;
        dissected.analyse(upper_rows, Ordering::nested_dissection);
        std::vector<std::int32_t> order = dissected.elimination_order();
        for (int v = kFirst; v < kSize; ++v)
            order.push_back(v);
        std::vector<Eigen::MatrixXd> added;
        for (const int threads : { 1, 2 }) {
            set_solver_threads(threads);
            SparseCholesky cholesky;
            cholesky.analyse_in_order(grid, order);
            added.push_back(cholesky.condense(values, kColumns));
        }
        set_solver_threads(2);
        EXPECT_EQ(added[0], added[1]);
        EXPECT_LT(added[0].diagonal().maxCoeff(), -0.1); // each has a neighbour that was condensed
    }

    TEST(SparseCholesky, CondensingNamesTheUnknownWhereItCannotGoOn)
    {
        Matrix m = random_matrix(40, 5);
        SparseCholesky cholesky;
        std::vector<std::int32_t> order = as_numbered(40);
        std::reverse(order.begin(), order.end());
        cholesky.analyse_in_order(m.pattern, order);
        const auto diagonal = [&](std::size_t unknown) -> double& {
            return m.values[static_cast<std::size_t>(m.pattern.column_start[unknown + 1]) - 1];
        };
        diagonal(3) = -1.0; // among the last: not read
        EXPECT_NO_THROW(cholesky.condense(m.values, 10));
        diagonal(25) = -1.0;
        EXPECT_THROW(cholesky.condense(m.values, 10), SolverError);
        EXPECT_EQ(cholesky.failed_unknown(), 25);
        diagonal(12) = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(cholesky.condense(m.values, 10), SolverError);
        EXPECT_EQ(cholesky.failed_unknown(), 12);
    }

    TEST(SparseCholesky, ASolveInTwoHalvesRoundTheTrailingUnknownsIsTheSolve)
    {
        constexpr int kSize = 150, kTrailing = 40;
        const Matrix m = random_matrix(kSize, 5);
        std::vector<std::int32_t> order;
        for (std::int32_t i = 0; i < kSize; ++i)
            order.push_back(i);
        SparseCholesky cholesky;
        cholesky.analyse_in_order(m.pattern, order);
        cholesky.factorise(m.values);
        const Eigen::MatrixXd b = test_support::random_entries(kSize, 2, 7);
        Eigen::MatrixXd x = b;
        cholesky.reduce_to_trailing(kTrailing, x);
        const Eigen::MatrixXd L = cholesky.trailing_factor(kTrailing);
        x.bottomRows(kTrailing) = (L * L.transpose()).llt().solve(x.bottomRows(kTrailing)).eval();
        cholesky.fill_from_trailing_loaded(kTrailing, x);
        const Eigen::MatrixXd exact = m.dense.llt().solve(b);
        EXPECT_LE((x - exact).norm(), 1e-11 * exact.norm());
    }

    TEST(Bisect, PutsAFewVerticesBetweenTwoSides)
    {
        // A grid of 12 x 4 vertices: a column of four, or a line as short, parts it.
        constexpr int kLong = 12, kShort = 4;
        SymmetricPattern grid;
        grid.column_start.push_back(0);
        for (int v = 0; v < kLong * kShort; ++v) {
            const int x = v / kShort, y = v % kShort;
            for (const auto& [dx, dy] : { std::pair { -1, 0 }, { 0, -1 }, { 0, 1 }, { 1, 0 } })
                if (x + dx >= 0 && x + dx < kLong && y + dy >= 0 && y + dy < kShort)
                    grid.row.push_back((x + dx) * kShort + y + dy);
            grid.column_start.push_back(static_cast<std::int32_t>(grid.row.size()));
        }
        const std::vector<std::int32_t> side = bisect(grid, std::vector<std::int32_t>(kLong * kShort, 1));
        const auto count = [&](std::int32_t which) { return std::count(side.begin(), side.end(), which); };
        EXPECT_LE(count(2), kShort + 1);
        EXPECT_GE(std::min(count(0), count(1)), kLong * kShort / 4);
        for (int v = 0; v < kLong * kShort; ++v)
            for (auto k = grid.column_start[static_cast<std::size_t>(v)];
                 k < grid.column_start[static_cast<std::size_t>(v) + 1]; ++k)
                EXPECT_NE(side[static_cast<std::size_t>(v)]
                        + side[static_cast<std::size_t>(grid.row[static_cast<std::size_t>(k)])],
                    1);
    }

    TEST(SparseCholesky, LargeSystemsAreSolvedOnTwoCoresAsWell)
    {
        constexpr int kSide = 30, n = kSide * kSide * kSide, last = kSide * kSide;
        SymmetricPattern pattern;
        std::vector<double> values;
        Eigen::VectorXd diagonal(n);
        const auto couples = [&](int j, int step, bool inside) {
            if (inside) {
                pattern.row.push_back(j - step);
                values.push_back(-1.0 - 0.1 * (j % 7));
            }
        };
        pattern.column_start.push_back(0);
        for (int j = 0; j < n; ++j) {
            couples(j, kSide * kSide, j >= kSide * kSide);
            couples(j, kSide, j / kSide % kSide > 0);
            couples(j, 1, j % kSide > 0);
            pattern.row.push_back(j);
            values.push_back(diagonal[j] = 10.0 + 0.01 * (j % 13));
            pattern.column_start.push_back(static_cast<std::int32_t>(pattern.row.size()));
        }
        const auto multiply = [&](const Eigen::MatrixXd& x) {
            Eigen::MatrixXd y = Eigen::MatrixXd::Zero(n, x.cols());
            for (int j = 0; j < n; ++j)
                for (auto k = static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)]);
                     k < static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j) + 1]); ++k) {
                    y.row(pattern.row[k]) += values[k] * x.row(j);
                    if (pattern.row[k] != j)
                        y.row(j) += values[k] * x.row(pattern.row[k]);
                }
            return y;
        };
        SparseCholesky dissected;
        dissected.analyse(pattern);
        std::vector<std::int32_t> order = dissected.elimination_order();
        std::stable_partition(order.begin(), order.end(), [](std::int32_t i) { return i < n - last; });
        SparseCholesky kept_last;
        kept_last.analyse_in_order(pattern, order);
        for (SparseCholesky* cholesky : { &dissected, &kept_last }) {
            cholesky->factorise(values);
            for (const int cases : { 1, 3 }) {
                const Eigen::MatrixXd b = test_support::random_entries(n, cases, 7);
                EXPECT_LE((multiply(cholesky->solve(b)) - b).norm(), 1e-13 * b.norm());
            }
        }
        for (const int cases : { 1, 3 }) {
            Eigen::MatrixXd x = test_support::random_entries(n, cases, 7);
            const Eigen::MatrixXd given = x.bottomRows(last);
            kept_last.fill_from_trailing(last, x);
            EXPECT_EQ(x.bottomRows(last), given);
            EXPECT_LE(multiply(x).topRows(n - last).norm(), 1e-13 * given.norm());
        }
        const Eigen::VectorXd b = test_support::random_entries(n, 1, 7);
        const Eigen::VectorXd by_two_cores = dissected.solve(b);
        dissected.round_to_single();
        EXPECT_LE((multiply(dissected.solve_rounded(b)) - b).norm(), 1e-5 * b.norm());
        set_solver_threads(1);
        dissected.factorise(values); // in the memory of the rounded factor
        const Eigen::VectorXd by_one_core = dissected.solve(b);
        set_solver_threads(2);
        EXPECT_EQ(by_one_core, by_two_cores);
        for (const int unknown : { 0, n - 1 }) {
            std::vector<double> indefinite = values;
            indefinite[static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(unknown) + 1]) - 1]
                = -diagonal[unknown];
            EXPECT_THROW(dissected.factorise(indefinite), SolverError);
            EXPECT_FALSE(dissected.factorised());
            EXPECT_GE(dissected.failed_unknown(), 0);
        }
        dissected.factorise(values);
        EXPECT_EQ(dissected.solve(b), by_two_cores);
        // The memory of the updates is kept, and does not grow: the same sizes come again, in another order.
        const std::size_t bytes = dissected.bytes();
        constexpr double kMostGrown = 1.5;
        for (int again = 0; again < 10; ++again) {
            dissected.factorise(values);
            EXPECT_LE(static_cast<double>(dissected.bytes()), kMostGrown * static_cast<double>(bytes));
        }
    }

    TEST(SparseCholesky, DenseBlocksOfAllSizesAreSolvedInBothPrecisions)
    {
        for (const int n : { 1, 2, 63, 64, 65, 200 }) { // one supernode: small ones have a substitution of their own
            const Eigen::MatrixXd random = test_support::random_entries(n, n, 7);
            const Eigen::MatrixXd dense = random * random.transpose() + n * Eigen::MatrixXd::Identity(n, n);
            SymmetricPattern pattern { .column_start = { 0 }, .row = {} };
            std::vector<double> values;
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i <= j; ++i) {
                    pattern.row.push_back(i);
                    values.push_back(dense(i, j));
                }
                pattern.column_start.push_back(static_cast<std::int32_t>(pattern.row.size()));
            }
            SparseCholesky cholesky;
            cholesky.analyse(pattern);
            cholesky.factorise(values);
            const Eigen::VectorXd b = test_support::random_entries(n, 1, 3);
            EXPECT_LE((dense * cholesky.solve(b) - b).norm(), 1e-12 * b.norm()) << n;
            cholesky.round_to_single();
            EXPECT_LE((dense * cholesky.solve_rounded(b) - b).norm(), 1e-4 * b.norm()) << n;
        }
    }

    TEST(SparseCholesky, NotPositiveDefiniteNamesTheUnknown)
    {
        Matrix m = random_matrix(40, 2);
        for (std::size_t k = 0; k < m.pattern.row.size(); ++k)
            if (static_cast<std::size_t>(m.pattern.column_start[18]) == k + 1) // the diagonal closes its column
                m.values[k] = -5.0;
        SparseCholesky cholesky;
        cholesky.analyse(m.pattern);
        try {
            cholesky.factorise(m.values);
            FAIL() << "accepted";
        } catch (const SolverError& error) {
            EXPECT_NE(std::string(error.what()).find("not positive definite"), std::string::npos);
            EXPECT_EQ(error.where(), "unknown 17");
            EXPECT_EQ(cholesky.failed_unknown(), 17);
        }
        EXPECT_FALSE(cholesky.factorised());
    }

    TEST(SparseCholesky, NaNAndNothingAreRefused)
    {
        Matrix m = random_matrix(10, 3);
        m.values[4] = std::numeric_limits<double>::quiet_NaN();
        SparseCholesky cholesky;
        cholesky.analyse(m.pattern);
        EXPECT_THROW(cholesky.factorise(m.values), SolverError);
        EXPECT_THROW(cholesky.analyse({ { 0 }, {} }), SolverError);
    }

    TEST(Blas, IsOpenBlas) { EXPECT_NE(blas_description().find("OpenBLAS"), std::string::npos) << blas_description(); }

} // namespace sparse_cholesky_test
} // namespace retractor::fem
