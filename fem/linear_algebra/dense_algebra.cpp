#include "fem/linear_algebra/dense_algebra.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <utility>

// The LAPACK functions of OpenBLAS. Debian has no header for them without LAPACKE.
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dgetrf_(const int* m, const int* n, double* a, const int* lda, int* ipiv, int* info);
void dgetrs_(const char* trans, const int* n, const int* nrhs, const double* a, const int* lda, const int* ipiv,
    double* b, const int* ldb, int* info);
void dgecon_(const char* norm, const int* n, const double* a, const int* lda, const double* anorm, double* rcond,
    double* work, int* iwork, int* info);
void dsyev_(const char* jobz, const char* uplo, const int* n, double* a, const int* lda, double* w, double* work,
    const int* lwork, int* info);
}

namespace retractor::fem {

namespace {

    constexpr Eigen::Index kWorthTwoCores = 1000; // rows

    int size(Eigen::Index n) { return static_cast<int>(n); }

    /// Number of columns of a product that the first of two cores computes: half of a large product, else all. The
    /// number depends on the sizes alone, so that one core gives the same bits.
    Eigen::Index columns_of_first(Eigen::Index rows, Eigen::Index columns, Eigen::Index inner)
    {
        constexpr double kWorthAThread = 1e7; // multiplications: about a millisecond
        constexpr Eigen::Index kTogether = 48; // columns; no block of a kernel is split
        const double work = static_cast<double>(rows) * static_cast<double>(columns) * static_cast<double>(inner);
        return work < kWorthAThread ? columns : columns / 2 / kTogether * kTogether;
    }

} // namespace

Eigen::Index half_of_lower(Eigen::Index n)
{
    return static_cast<Eigen::Index>((1.0 - std::sqrt(0.5)) * static_cast<double>(n));
}

void mirror_lower(Eigen::MatrixXd& a)
{
    constexpr Eigen::Index kTile = 64; // both sides of a tile stay in the cache
    for (Eigen::Index j = 0; j < a.cols(); j += kTile)
        for (Eigen::Index i = j; i < a.rows(); i += kTile)
            for (Eigen::Index c = j; c < std::min(j + kTile, a.cols()); ++c)
                for (Eigen::Index r = std::max(i, c + 1); r < std::min(i + kTile, a.rows()); ++r)
                    a(c, r) = a(r, c);
}

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b)
{
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(a.rows(), b.cols());
    if (a.size() == 0 || b.size() == 0)
        return c;
    RETRACTOR_ASSERT(a.cols() == b.rows());
    if (b.cols() == 1)
        cblas_dgemv(CblasColMajor, CblasNoTrans, size(a.rows()), size(a.cols()), 1.0, a.data(), size(a.rows()),
            b.data(), 1, 0.0, c.data(), 1);
    else {
        const auto columns = [&](Eigen::Index from, Eigen::Index to) {
            if (from < to)
                cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, size(a.rows()), size(to - from), size(a.cols()),
                    1.0, a.data(), size(a.rows()), b.col(from).data(), size(b.rows()), 0.0, c.col(from).data(),
                    size(c.rows()));
        };
        if (const Eigen::Index middle = columns_of_first(a.rows(), b.cols(), a.cols()); middle < b.cols()) {
            const ScopedThread other([&] { columns(middle, b.cols()); });
            columns(0, middle);
        } else {
            columns(0, b.cols());
        }
    }
    return c;
}

Eigen::MatrixXd product_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b)
{
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(a.cols(), b.cols());
    if (a.size() == 0 || b.size() == 0)
        return c;
    RETRACTOR_ASSERT(a.rows() == b.rows());
    if (b.cols() == 1)
        cblas_dgemv(CblasColMajor, CblasTrans, size(a.rows()), size(a.cols()), 1.0, a.data(), size(a.rows()), b.data(),
            1, 0.0, c.data(), 1);
    else
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, size(a.cols()), size(b.cols()), size(a.rows()), 1.0,
            a.data(), size(a.rows()), b.data(), size(b.rows()), 0.0, c.data(), size(c.rows()));
    return c;
}

Eigen::MatrixXd times_own_transpose(const Eigen::MatrixXd& lower)
{
    const Eigen::Index n = lower.rows();
    RETRACTOR_ASSERT(lower.cols() == n);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    // A tile of L L^T needs only the columns of L up to its last row. All tiles together take a third of a full
    // product.
    constexpr Eigen::Index kColumns = 128;
    const auto of_columns = [&](Eigen::Index from, Eigen::Index to) {
        for (Eigen::Index j = from; j < to; j += kColumns) {
            const Eigen::Index width = std::min(kColumns, to - j), below = n - j - width;
            cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, size(width), size(j + width), 1.0, lower.data() + j,
                size(n), 0.0, &a(j, j), size(n));
            if (below > 0)
                cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, size(below), size(width), size(j + width), 1.0,
                    lower.data() + j + width, size(n), lower.data() + j, size(n), 0.0, a.data() + j * n + j + width,
                    size(n));
        }
    };
    constexpr Eigen::Index kWorthIt = 500; // rows
    const Eigen::Index middle = n < kWorthIt ? n : n / 2 / kColumns * kColumns;
    if (middle < n) {
        const ScopedThread other([&] { of_columns(middle, n); });
        of_columns(0, middle);
    } else {
        of_columns(0, n);
    }
    mirror_lower(a);
    return a;
}

void copy_lower(const Eigen::MatrixXd& from, const std::vector<std::int32_t>& rows, Eigen::Ref<Eigen::MatrixXd> to)
{
    RETRACTOR_ASSERT(to.cols() == static_cast<Eigen::Index>(rows.size()) && to.rows() == to.cols());
    struct Run { // consecutive rows, copied together
        Eigen::Index at, from, length;
    };
    std::vector<Run> runs;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (i > 0 && rows[i] == rows[i - 1] + 1)
            ++runs.back().length;
        else
            runs.push_back({ static_cast<Eigen::Index>(i), rows[i], 1 });
    const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
        std::size_t first = 0;
        for (Eigen::Index j = begin; j < end; ++j) {
            while (runs[first].at + runs[first].length <= j)
                ++first;
            const double* column = from.col(rows[static_cast<std::size_t>(j)]).data();
            for (std::size_t r = first; r < runs.size(); ++r) // from the run of the diagonal down
                std::copy_n(column + runs[r].from, runs[r].length, to.col(j).data() + runs[r].at);
        }
    };
    if (to.cols() < kWorthTwoCores)
        return columns(0, to.cols());
    const ScopedThread other([&] { columns(half_of_lower(to.cols()), to.cols()); });
    columns(0, half_of_lower(to.cols()));
}

void subtract_lower_product(Eigen::Ref<Eigen::MatrixXd> a, const Eigen::Ref<const Eigen::MatrixXd>& b,
    const Eigen::Ref<const Eigen::MatrixXd>& c, Cores cores)
{
    const Eigen::Index n = a.rows();
    constexpr Eigen::Index kColumns = 96;
    if (b.cols() == 0 || n == 0)
        return;
    RETRACTOR_ASSERT(a.cols() == n && b.rows() == n && c.rows() == n && b.cols() == c.cols());
    const auto columns = [&](Eigen::Index from, Eigen::Index to) {
        for (Eigen::Index j = from; j < to; j += kColumns)
            cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, size(n - j), size(std::min(kColumns, to - j)),
                size(b.cols()), -1.0, b.data() + j, size(b.outerStride()), c.data() + j, size(c.outerStride()), 1.0,
                a.col(j).data() + j, size(a.outerStride()));
    };
    if (cores == Cores::one)
        return columns(0, n);
    const Eigen::Index middle = (half_of_lower(n) + kColumns - 1) / kColumns * kColumns;
    const ScopedThread other([&] { columns(std::min(middle, n), n); });
    columns(0, std::min(middle, n));
}

void invert_from_factor(Eigen::MatrixXd& L)
{
    if (L.size() == 0)
        return;
    const int n = size(L.rows());
    int info = 0;
    dpotri_("L", &n, L.data(), &n, &info);
    if (info != 0)
        throw SolverError("a dense factor is singular", "unknown " + std::to_string(info - 1));
    mirror_lower(L);
}

namespace {

    /// Divides the rows `from` to `to` of the panel (columns j to j + width) by its factored diagonal block.
    void divide_panel(Eigen::MatrixXd& a, Eigen::Index j, Eigen::Index width, Eigen::Index from, Eigen::Index to)
    {
        if (from < to)
            cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, size(to - from), size(width),
                1.0, &a(j, j), size(a.rows()), &a(from, j), size(a.rows()));
    }

    /// Subtracts the product of the panel from the columns `from` to `to` of the lower triangle.
    void take_off_panel(Eigen::MatrixXd& a, Eigen::Index j, Eigen::Index width, Eigen::Index from, Eigen::Index to)
    {
        constexpr Eigen::Index kColumns = 128;
        const Eigen::Index n = a.rows();
        for (Eigen::Index c = from; c < to; c += kColumns)
            cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, size(n - c), size(std::min(kColumns, to - c)),
                size(width), -1.0, &a(c, j), size(n), &a(c, j), size(n), 1.0, &a(c, c), size(n));
    }

} // namespace

Eigen::Index factor_block(double* a, Eigen::Index columns, Eigen::Index stride)
{
    const int n = size(columns), lda = size(stride);
    int info = 0;
    dpotrf_("L", &n, a, &lda, &info);
    return info - 1;
}

bool cholesky(Eigen::MatrixXd& a)
{
    if (a.size() == 0)
        return true;
    RETRACTOR_ASSERT(a.rows() == a.cols());
    constexpr Eigen::Index kPanel = 192;
    const int n = size(a.rows());
    int info = 0;
    if (n < kWorthTwoCores) {
        dpotrf_("L", &n, a.data(), &n, &info);
        return info == 0;
    }
    for (Eigen::Index j = 0; j < n; j += kPanel) {
        const Eigen::Index width = std::min<Eigen::Index>(kPanel, n - j), below = j + width;
        const int order = size(width);
        dpotrf_("L", &order, &a(j, j), &n, &info);
        if (info != 0)
            return false;
        const Eigen::Index rows = (below + n) / 2; // divides the panel into halves
        {
            const ScopedThread other([&] { divide_panel(a, j, width, rows, n); });
            divide_panel(a, j, width, below, rows);
        }
        // Divides the rest of the triangle into two equal areas.
        const Eigen::Index columns = below + half_of_lower(n - below);
        const ScopedThread other([&] { take_off_panel(a, j, width, columns, n); });
        take_off_panel(a, j, width, below, columns);
    }
    return true;
}

void forward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b)
{
    if (b.size() != 0)
        cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, size(L.rows()), size(b.cols()),
            1.0, L.data(), size(L.rows()), b.data(), size(b.rows()));
}

void backward(const Eigen::MatrixXd& L, Eigen::MatrixXd& b)
{
    if (b.size() != 0)
        cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, size(L.rows()), size(b.cols()), 1.0,
            L.data(), size(L.rows()), b.data(), size(b.rows()));
}

void divide_by_transpose(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> b, Cores cores)
{
    const auto rows = [&](Eigen::Index from, Eigen::Index to) {
        if (from < to && b.cols() > 0)
            cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, size(to - from),
                size(b.cols()), 1.0, L.data(), size(L.outerStride()), b.data() + from, size(b.outerStride()));
    };
    constexpr Eigen::Index kTogether = 48, kWorthHalving = 200; // rows
    const Eigen::Index middle = b.rows() < kWorthHalving ? b.rows() : b.rows() / 2 / kTogether * kTogether;
    if (cores == Cores::one || middle == b.rows()) {
        rows(0, middle);
        rows(middle, b.rows());
        return;
    }
    const ScopedThread other([&] { rows(middle, b.rows()); });
    rows(0, middle);
}

void invert_positive_definite(Eigen::MatrixXd& a, const std::string& what)
{
    if (!cholesky(a))
        throw SolverError(what + " is not positive definite");
    invert_from_factor(a);
}

SymmetricModes symmetric_modes(Eigen::MatrixXd a)
{
    if (a.rows() != a.cols())
        throw InputError("a matrix of " + std::to_string(a.rows()) + " rows and " + std::to_string(a.cols())
                + " columns has no eigenvalues",
            "modes");
    SymmetricModes modes { .values = Eigen::VectorXd(a.rows()), .vectors = {} };
    if (a.size() == 0)
        return modes;
    if (!a.allFinite())
        throw SolverError("a matrix with NaN or infinity has no eigenvalues");
    const int n = size(a.rows());
    int info = 0;
    const int ask_for_size = -1;
    double wanted = 0.0;
    dsyev_("V", "L", &n, a.data(), &n, modes.values.data(), &wanted, &ask_for_size, &info);
    const int length = static_cast<int>(wanted);
    std::vector<double> work(static_cast<std::size_t>(length));
    dsyev_("V", "L", &n, a.data(), &n, modes.values.data(), work.data(), &length, &info);
    if (info != 0)
        throw SolverError("the eigenvalues of a symmetric matrix were not found");
    modes.vectors = std::move(a);
    return modes;
}

DenseLu::DenseLu(Eigen::MatrixXd a)
    : lu_(std::move(a))
    , exchanges_(static_cast<std::size_t>(lu_.rows()))
    , rcond_(1.0)
{
    RETRACTOR_ASSERT(lu_.rows() == lu_.cols());
    if (lu_.size() == 0)
        return;
    const int n = size(lu_.rows());
    const double norm = lu_.cwiseAbs().colwise().sum().maxCoeff();
    int info = 0;
    dgetrf_(&n, &n, lu_.data(), &n, exchanges_.data(), &info);
    rcond_ = 0.0;
    if (info != 0)
        return;
    std::vector<double> work(4 * static_cast<std::size_t>(n));
    std::vector<int> integers(static_cast<std::size_t>(n));
    dgecon_("1", &n, lu_.data(), &n, &norm, &rcond_, work.data(), integers.data(), &info);
}

void DenseLu::solve(Eigen::MatrixXd& b) const
{
    if (b.size() == 0)
        return;
    RETRACTOR_ASSERT(b.rows() == lu_.rows());
    const int n = size(lu_.rows()), cases = size(b.cols());
    int info = 0;
    dgetrs_("N", &n, &cases, lu_.data(), &n, exchanges_.data(), b.data(), &n, &info);
}

} // namespace retractor::fem
