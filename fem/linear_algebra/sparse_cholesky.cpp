#include "fem/linear_algebra/sparse_cholesky.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/parallel.h"
#include "fem/linear_algebra/partial_factor.h"
#include "fem/linear_algebra/supernodes.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/memory.h"
#include "mesh/base/text_format.h"

#include <cblas.h>
#include <cholmod.h>
#include <omp.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>

namespace retractor::fem {

namespace {

    template <class Scalar> using Columns = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

    // The operations of BLAS in both precisions. L is a lower triangle stored by columns.

    /// Forward substitution, or back substitution with the transpose. Most triangles of a factor are small: a call of
    /// OpenBLAS, which locks a mutex each time, would take longer.
    template <class Scalar>
    void solve_small_lower(CBLAS_TRANSPOSE transposed, int n, const Scalar* L, int stride, Scalar* x)
    {
        using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
        const auto below = [&](int column) {
            return Eigen::Map<const Vector>(L + std::ptrdiff_t { column } * stride + column + 1, n - column - 1);
        };
        const auto rest = [&](int column) { return Eigen::Map<Vector>(x + column + 1, n - column - 1); };
        const auto diagonal = [&](int column) { return L[std::ptrdiff_t { column } * stride + column]; };
        if (transposed == CblasNoTrans)
            for (int j = 0; j < n; ++j) {
                x[j] /= diagonal(j);
                rest(j) -= x[j] * below(j);
            }
        else
            for (int j = n; j-- > 0;)
                x[j] = (x[j] - below(j).dot(rest(j))) / diagonal(j);
    }

    constexpr int kSmallTriangle = 64; // columns

    void solve_lower(CBLAS_TRANSPOSE transposed, int n, const double* L, int stride, double* x)
    {
        if (n <= kSmallTriangle)
            solve_small_lower(transposed, n, L, stride, x);
        else
            cblas_dtrsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, n, L, stride, x, 1);
    }
    void solve_lower(CBLAS_TRANSPOSE transposed, int n, const float* L, int stride, float* x)
    {
        if (n <= kSmallTriangle)
            solve_small_lower(transposed, n, L, stride, x);
        else
            cblas_strsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, n, L, stride, x, 1);
    }
    void solve_lower(CBLAS_TRANSPOSE transposed, int n, int columns, const double* L, int stride, double* x, int rows)
    {
        cblas_dtrsm(
            CblasColMajor, CblasLeft, CblasLower, transposed, CblasNonUnit, n, columns, 1.0, L, stride, x, rows);
    }
    void solve_lower(CBLAS_TRANSPOSE transposed, int n, int columns, const float* L, int stride, float* x, int rows)
    {
        cblas_strsm(
            CblasColMajor, CblasLeft, CblasLower, transposed, CblasNonUnit, n, columns, 1.0F, L, stride, x, rows);
    }
    /// y = a A x + b y, with the transpose of A where asked
    void multiply(CBLAS_TRANSPOSE transposed, int m, int n, double a, const double* A, int stride, const double* x,
        double b, double* y)
    {
        cblas_dgemv(CblasColMajor, transposed, m, n, a, A, stride, x, 1, b, y, 1);
    }
    void multiply(CBLAS_TRANSPOSE transposed, int m, int n, float a, const float* A, int stride, const float* x,
        float b, float* y)
    {
        cblas_sgemv(CblasColMajor, transposed, m, n, a, A, stride, x, 1, b, y, 1);
    }
    /// Y = a A X + b Y, with the transpose of A where asked
    void multiply(CBLAS_TRANSPOSE transposed, int m, int columns, int n, double a, const double* A, int stride,
        const double* X, int X_rows, double b, double* Y, int Y_rows)
    {
        cblas_dgemm(CblasColMajor, transposed, CblasNoTrans, m, columns, n, a, A, stride, X, X_rows, b, Y, Y_rows);
    }
    void multiply(CBLAS_TRANSPOSE transposed, int m, int columns, int n, float a, const float* A, int stride,
        const float* X, int X_rows, float b, float* Y, int Y_rows)
    {
        cblas_sgemm(CblasColMajor, transposed, CblasNoTrans, m, columns, n, a, A, stride, X, X_rows, b, Y, Y_rows);
    }

    /// A factor with values in double or single precision.
    template <class Scalar> struct FactorOf {
        const Supernodes& f;
        const Scalar* values;
        const Scalar* block(std::size_t s) const { return values + f.value_start[s]; }
    };

    /// Forward substitution with the first `columns` unknowns of supernode s, which begin at row `first` of y, and
    /// subtraction from the rows below. `row_at` gives the row of an unknown in y.
    template <class Scalar, class RowAt>
    void forward(const FactorOf<Scalar>& factor, std::size_t s, Eigen::Index columns, Eigen::Index first,
        const RowAt& row_at, Columns<Scalar>& y, Columns<Scalar>& beyond)
    {
        const Supernodes& f = factor.f;
        if ((y.middleRows(first, columns).array() == 0.0).all())
            return; // no load reaches this supernode; with few loads this holds for most of a factor
        const Eigen::Index rows = f.rows(s) - columns;
        const Scalar* L = factor.block(s);
        const auto n = static_cast<int>(columns), m = static_cast<int>(rows), k = static_cast<int>(y.cols());
        const auto stride = static_cast<int>(f.rows(s)), all = static_cast<int>(y.rows()),
                   most = static_cast<int>(f.most_rows);
        Scalar* own = y.data() + first;
        if (k == 1)
            solve_lower(CblasNoTrans, n, L, stride, own);
        else
            solve_lower(CblasNoTrans, n, k, L, stride, own, all);
        if (m == 0)
            return;
        if (k == 1)
            multiply(CblasNoTrans, m, n, Scalar(1), L + n, stride, own, Scalar(0), beyond.data());
        else
            multiply(CblasNoTrans, m, k, n, Scalar(1), L + n, stride, own, all, Scalar(0), beyond.data(), most);
        for (Eigen::Index c = 0; c < y.cols(); ++c)
            for (Eigen::Index i = 0; i < rows; ++i)
                y(row_at(f.row(s, columns + i)), c) -= beyond(i, c);
    }

    /// Back substitution: the unknowns of supernode s before `given`, from the unknowns after them.
    template <class Scalar>
    void backward(
        const FactorOf<Scalar>& factor, std::size_t s, Eigen::Index given, Columns<Scalar>& y, Columns<Scalar>& beyond)
    {
        const Supernodes& f = factor.f;
        const Eigen::Index first = f.first[s], columns = std::min<Eigen::Index>(f.columns(s), given - first);
        const Eigen::Index rows = f.rows(s) - columns;
        for (Eigen::Index c = 0; c < y.cols(); ++c)
            for (Eigen::Index i = 0; i < rows; ++i)
                beyond(i, c) = y(f.row(s, columns + i), c);
        const Scalar* L = factor.block(s);
        const auto n = static_cast<int>(columns), m = static_cast<int>(rows), k = static_cast<int>(y.cols());
        const auto stride = static_cast<int>(f.rows(s)), all = static_cast<int>(y.rows()),
                   most = static_cast<int>(f.most_rows);
        Scalar* own = y.data() + first;
        if (k == 1) {
            if (m > 0)
                multiply(CblasTrans, m, n, Scalar(-1), L + n, stride, beyond.data(), Scalar(1), own);
            solve_lower(CblasTrans, n, L, stride, own);
            return;
        }
        if (m > 0)
            multiply(CblasTrans, n, k, m, Scalar(-1), L + n, stride, beyond.data(), most, Scalar(1), own, all);
        solve_lower(CblasTrans, n, k, L, stride, own, all);
    }

    /// The row of an unknown in y, when y has all unknowns in the order of elimination.
    constexpr auto in_order = [](Eigen::Index unknown) { return unknown; };

    /// Number of unknowns from which a second core pays.
    constexpr Eigen::Index kUnknownsWorthAThread = 20000;

    template <class Scalar>
    void backward(const FactorOf<Scalar>& factor, const TwoParts& parts, Eigen::Index given, Columns<Scalar>& y)
    {
        const bool two_cores = factor.f.size >= kUnknownsWorthAThread;
        // Memory is taken before the thread starts, so that a failure reaches the caller.
        Columns<Scalar> beyond(factor.f.most_rows, y.cols()), others(two_cores ? factor.f.most_rows : 0, y.cols());
        const auto all_of = [&](const std::vector<std::size_t>& falling, Columns<Scalar>& rows) {
            for (const std::size_t s : falling)
                backward(factor, s, given, y, rows);
        };
        all_of(parts.above, beyond);
        if (two_cores) { // the two parts have no common unknowns
            const ScopedThread other([&] { all_of(parts.below[1], others); });
            all_of(parts.below[0], beyond);
            return;
        }
        all_of(parts.below[1], beyond);
        all_of(parts.below[0], beyond);
    }

    template <class Scalar> void forward(const FactorOf<Scalar>& factor, const TwoParts& parts, Columns<Scalar>& y)
    {
        const Supernodes& f = factor.f;
        Columns<Scalar> beyond(f.most_rows, y.cols());
        const auto all_of = [&](const std::vector<std::size_t>& falling, Columns<Scalar>& in, Columns<Scalar>& rows) {
            for (auto s = falling.rbegin(); s != falling.rend(); ++s)
                forward(factor, *s, f.columns(*s), f.first[*s], in_order, in, rows);
        };
        if (f.size >= kUnknownsWorthAThread) {
            // Both parts subtract from the rows of `above`; the second part does so in a vector of its own.
            Columns<Scalar> apart = Columns<Scalar>::Zero(y.rows(), y.cols()), others(f.most_rows, y.cols());
            for (const std::size_t s : parts.below[1]) {
                apart.middleRows(f.first[s], f.columns(s)) = y.middleRows(f.first[s], f.columns(s));
                y.middleRows(f.first[s], f.columns(s)).setZero();
            }
            {
                const ScopedThread other([&] { all_of(parts.below[1], apart, others); });
                all_of(parts.below[0], y, beyond);
            }
            y += apart;
        } else {
            all_of(parts.below[1], y, beyond);
            all_of(parts.below[0], y, beyond);
        }
        all_of(parts.above, y, beyond);
    }

    /// Memory for CHOLMOD. A factor takes gigabytes, which each factorisation sets to zero: in large pages that takes a
    /// fraction of the time.
    void* allocate(std::size_t bytes)
    {
        constexpr std::size_t kPage = std::size_t { 2 } << 20, kLarge = 8 * kPage;
        if (bytes < kLarge)
            return std::malloc(bytes);
        void* memory = std::aligned_alloc(kPage, (bytes + kPage - 1) / kPage * kPage);
        if (memory != nullptr)
            (void)madvise(memory, bytes, MADV_HUGEPAGE); // advice: without large pages nothing else changes
        return memory;
    }

    Eigen::MatrixXd in_elimination_order(const Eigen::MatrixXd& x, const cholmod_factor& factor)
    {
        const auto* order = static_cast<const int*>(factor.Perm);
        Eigen::MatrixXd ordered(static_cast<Eigen::Index>(factor.n), x.cols());
        for (Eigen::Index c = 0; c < ordered.cols(); ++c)
            for (Eigen::Index i = 0; i < ordered.rows(); ++i)
                ordered(i, c) = x(order[i], c);
        return ordered;
    }

    Eigen::MatrixXd in_matrix_order(const Eigen::MatrixXd& ordered, const cholmod_factor& factor)
    {
        const auto* order = static_cast<const int*>(factor.Perm);
        Eigen::MatrixXd x(ordered.rows(), ordered.cols());
        for (Eigen::Index c = 0; c < ordered.cols(); ++c)
            for (Eigen::Index i = 0; i < ordered.rows(); ++i)
                x(order[i], c) = ordered(i, c);
        return x;
    }

    /// The supernodes of these unknowns and all their ancestors, rising.
    std::vector<std::int32_t> reached_from(const Supernodes& f, const std::vector<Eigen::Index>& unknowns)
    {
        std::vector<std::uint8_t> met(f.count, 0);
        std::vector<std::int32_t> reached;
        for (const Eigen::Index unknown : unknowns)
            for (std::int32_t s = f.supernode_of(unknown); s >= 0 && met[static_cast<std::size_t>(s)] == 0;
                 s = f.parent(static_cast<std::size_t>(s))) {
                met[static_cast<std::size_t>(s)] = 1;
                reached.push_back(s);
            }
        std::sort(reached.begin(), reached.end());
        return reached;
    }

} // namespace

std::vector<std::int32_t> bisect(const SymmetricPattern& graph, const std::vector<std::int32_t>& weight)
{
    RETRACTOR_ASSERT(weight.size() == static_cast<std::size_t>(graph.size()));
    cholmod_common common {};
    cholmod_start(&common);
    common.print = 0;
    SymmetricPattern copy = graph; // METIS does not write into the graph, but does not declare it const
    std::vector<std::int32_t> vertex_weight = weight, edge_weight(graph.row.size(), 1), side(weight.size(), 0);
    cholmod_sparse a {};
    a.nrow = a.ncol = weight.size();
    a.nzmax = copy.row.size();
    a.p = copy.column_start.data();
    a.i = copy.row.data();
    a.itype = CHOLMOD_INT;
    a.xtype = CHOLMOD_PATTERN;
    a.sorted = 1;
    a.packed = 1;
    const auto between = cholmod_metis_bisector(&a, vertex_weight.data(), edge_weight.data(), side.data(), &common);
    cholmod_finish(&common);
    if (between < 0)
        throw SolverError("METIS could not split the graph", "graph of " + std::to_string(weight.size()) + " vertices");
    return side;
}

struct SparseCholesky::State {
    cholmod_common common {};
    cholmod_factor* factor = nullptr;
    SymmetricPattern pattern;
    std::vector<std::int32_t> place; ///< position of each unknown in the order of elimination
    TwoParts parts; ///< of the whole factor
    bool factorised = false;
    float* single = nullptr; ///< values of the factor in single precision, in place of those in double precision
    std::int32_t failed = -1;
    double rcond = 0.0;
    UpdateMemory updates; ///< of the last factorisation, for the next one

    State()
    {
        static std::once_flag once; // the setting is for the whole process
        std::call_once(once, [] { SuiteSparse_config.malloc_func = allocate; }); // freed and resized as by malloc()
        cholmod_start(&common);
        common.print = 0; // failures are thrown, not printed
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
        common.postorder = 1;
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State()
    {
        release();
        cholmod_finish(&common);
    }
    void release()
    {
        release_single();
        cholmod_free_factor(&factor, &common);
        updates.release();
        factorised = false;
    }
    void release_single()
    {
        if (single != nullptr)
            single = static_cast<float*>(cholmod_free(factor->xsize, sizeof(double), single, &common));
    }
    /// Gives the memory of a factor in single precision back to the next factor in double precision: fresh memory would
    /// be set to zero once more.
    void reuse_single()
    {
        if (single == nullptr)
            return;
        factor->x = std::exchange(single, nullptr);
        factor->xtype = CHOLMOD_REAL;
    }
    /// The arrays as a CHOLMOD matrix; CHOLMOD does not write into them.
    cholmod_sparse view(const double* values)
    {
        cholmod_sparse a {};
        a.nrow = a.ncol = static_cast<std::size_t>(pattern.size());
        a.nzmax = pattern.row.size();
        a.p = pattern.column_start.data();
        a.i = pattern.row.data();
        a.x = const_cast<double*>(values);
        a.stype = 1; // upper triangle
        a.itype = CHOLMOD_INT;
        a.xtype = values == nullptr ? CHOLMOD_PATTERN : CHOLMOD_REAL;
        a.dtype = CHOLMOD_DOUBLE;
        a.sorted = 1;
        a.packed = 1;
        return a;
    }
    void factorise_by_cholmod(const std::vector<double>& values)
    {
        cholmod_sparse a = view(values.data());
        // CHOLMOD would start four threads per block of columns, which on two cores wait for each other longer than
        // they work. The setting belongs to the calling thread and is restored for the caller's OpenMP.
        const int levels = omp_get_max_active_levels();
        omp_set_max_active_levels(0);
        cholmod_factorize(&a, factor, &common);
        omp_set_max_active_levels(levels);
        if (common.status == CHOLMOD_NOT_POSDEF)
            not_positive_definite(static_cast<Eigen::Index>(factor->minor));
        if (common.status < CHOLMOD_OK)
            fail("the factorisation");
    }
    /// Factors all but the last `count` unknowns of the order. @return as PartialFactor::trailing
    Eigen::MatrixXd factorise_on_two_cores(
        const std::vector<double>& values, UpdateMemory& memory, Eigen::Index count = 0)
    {
        // Allocates the values; a factor with values is overwritten.
        if (cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, factor, &common) == 0)
            fail("the factorisation");
        const Supernodes f(*factor);
        PartialFactor partial;
        try {
            partial = factor_before(f, static_cast<double*>(factor->x), f.size - count, pattern, place, values, memory);
        } catch (const std::bad_alloc&) {
            common.status = CHOLMOD_OUT_OF_MEMORY;
            fail("the factorisation");
        }
        if (partial.stopped_at >= 0)
            not_positive_definite(partial.stopped_at);
        return std::move(partial.trailing);
    }
    /// Stores the order of elimination and the parts of the factor. Call after the analysis.
    void keep_places()
    {
        parts = two_parts(Supernodes(*factor), static_cast<Eigen::Index>(factor->n));
        const auto* order = static_cast<const int*>(factor->Perm);
        place.resize(factor->n);
        for (std::size_t i = 0; i < place.size(); ++i)
            place[static_cast<std::size_t>(order[i])] = static_cast<std::int32_t>(i);
    }
    /// Call before the values of the factor are allocated.
    /// @throws SolverError where the factor needs more memory than is available
    void refuse_what_does_not_fit() const
    {
        constexpr double kWorthALook = 0.1 * kGiB; // smaller factors are not worth the reading of two files
        const double needed = static_cast<double>(factor->xsize * sizeof(double));
        if (factor->xtype != CHOLMOD_PATTERN || needed < kWorthALook)
            return;
        if (const auto available = available_memory(); available && needed > *available)
            throw SolverError(
                formatted("the factorisation needs %.1f GiB of memory, and %.1f GiB are available: choose "
                          "longer edges or a draft, or close other programs",
                    needed / kGiB, *available / kGiB),
                "matrix of " + std::to_string(pattern.size()) + " unknowns");
    }
    /// @throws SolverError naming the first entry that is not finite
    void check(const std::vector<double>& values)
    {
        const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
        if (bad == values.end())
            return;
        failed = pattern.row[static_cast<std::size_t>(bad - values.begin())];
        throw SolverError("the matrix has an entry that is not finite", "unknown " + std::to_string(failed));
    }
    [[noreturn]] void not_positive_definite(Eigen::Index eliminated)
    {
        failed = static_cast<const int*>(factor->Perm)[eliminated];
        throw SolverError("the matrix is not positive definite", "unknown " + std::to_string(failed));
    }
    [[noreturn]] void fail(const char* doing) const
    {
        const std::string reason = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
            : common.status == CHOLMOD_TOO_LARGE                          ? "the factor is too large for 32-bit indices"
                                                 : "CHOLMOD status " + std::to_string(common.status);
        throw SolverError(
            std::string(doing) + " failed: " + reason, "matrix of " + std::to_string(pattern.size()) + " unknowns");
    }
};

SparseCholesky::SparseCholesky()
    : state_(std::make_unique<State>())
{
}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(SymmetricPattern pattern, Ordering ordering)
{
    State& s = *state_;
    s.common.method[0].ordering = ordering == Ordering::minimum_degree ? CHOLMOD_AMD : CHOLMOD_METIS;
    s.common.postorder = 1;
    s.release();
    s.pattern = std::move(pattern);
    if (s.pattern.size() <= 0)
        throw SolverError("there is nothing to solve: the matrix has no unknowns");
    cholmod_sparse a = s.view(nullptr);
    s.factor = cholmod_analyze(&a, &s.common);
    if (s.factor == nullptr || s.common.status < CHOLMOD_OK)
        s.fail("the analysis of the matrix");
    s.keep_places();
}

void SparseCholesky::analyse_in_order(SymmetricPattern pattern, std::vector<std::int32_t> order)
{
    State& s = *state_;
    s.release();
    s.pattern = std::move(pattern);
    std::vector<std::int32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size(); ++i)
        if (sorted[i] != static_cast<std::int32_t>(i))
            throw InputError("the order of elimination is not a permutation");
    if (s.pattern.size() <= 0 || order.size() != static_cast<std::size_t>(s.pattern.size()))
        throw InputError("the order of elimination needs each unknown of the matrix once");
    s.common.method[0].ordering = CHOLMOD_GIVEN;
    // Such factors are kept for a long time. These settings store fewer zeros when supernodes are joined than the
    // default, which is tuned for speed.
    s.common.zrelax[0] = 0.4;
    s.common.zrelax[1] = 0.05;
    s.common.zrelax[2] = 0.02;
    s.common.postorder = 0; // postordering would change the given order
    cholmod_sparse a = s.view(nullptr);
    s.factor = cholmod_analyze_p(&a, order.data(), nullptr, 0, &s.common);
    if (s.factor == nullptr || s.common.status < CHOLMOD_OK)
        s.fail("the analysis of the matrix");
    s.keep_places();
}

std::vector<std::int32_t> SparseCholesky::elimination_order() const
{
    RETRACTOR_ASSERT(analysed());
    const auto* first = static_cast<const int*>(state_->factor->Perm);
    return { first, first + state_->factor->n };
}

void SparseCholesky::factorise(const std::vector<double>& values)
{
    State& s = *state_;
    RETRACTOR_ASSERT(analysed());
    RETRACTOR_ASSERT(values.size() == s.pattern.row.size()); // keep_factor_only() deletes the pattern
    s.factorised = false;
    s.failed = -1;
    s.check(values);
    s.reuse_single();
    s.refuse_what_does_not_fit();
    if (s.factor->n >= kUnknownsWorthAThread)
        s.factorise_on_two_cores(values, s.updates);
    else
        s.factorise_by_cholmod(values);
    s.rcond = cholmod_rcond(s.factor, &s.common);
    s.factorised = true;
}

std::int32_t SparseCholesky::failed_unknown() const { return state_->failed; }

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right_sides) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(state_->factorised && !rounded());
    RETRACTOR_ASSERT(right_sides.rows() == f.size);
    Eigen::MatrixXd ordered = in_elimination_order(right_sides, *state_->factor);
    const FactorOf<double> factor { f, f.values };
    forward(factor, state_->parts, ordered);
    backward(factor, state_->parts, f.size, ordered);
    return in_matrix_order(ordered, *state_->factor);
}

void SparseCholesky::round_to_single()
{
    State& s = *state_;
    RETRACTOR_ASSERT(s.factorised);
    if (rounded())
        return;
    cholmod_factor& factor = *s.factor;
    // Rounds in place: a float ends before the double after it begins.
    auto* bytes = static_cast<unsigned char*>(factor.x);
    for (std::size_t i = 0; i < factor.xsize; ++i) {
        double value = 0.0;
        std::memcpy(&value, bytes + i * sizeof(double), sizeof(double));
        const auto single = static_cast<float>(value);
        std::memcpy(bytes + i * sizeof(float), &single, sizeof(float));
    }
    s.single = static_cast<float*>(factor.x);
    factor.x = nullptr; // CHOLMOD takes the factor for one that is analysed only
    factor.xtype = CHOLMOD_PATTERN;
}

bool SparseCholesky::rounded() const { return state_->single != nullptr; }

Eigen::VectorXd SparseCholesky::solve_rounded(const Eigen::VectorXd& right_side) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(rounded());
    RETRACTOR_ASSERT(right_side.size() == f.size);
    const double largest = right_side.lpNorm<Eigen::Infinity>();
    if (!(largest > 0.0) || !std::isfinite(largest))
        return largest == 0.0 ? Eigen::VectorXd::Zero(f.size) : Eigen::VectorXd::Constant(f.size, std::nan(""));
    const auto* order = static_cast<const int*>(state_->factor->Perm);
    Columns<float> ordered(f.size, 1); // scaled, so that no small right side underflows
    for (Eigen::Index i = 0; i < f.size; ++i)
        ordered(i, 0) = static_cast<float>(right_side[order[i]] / largest);
    const FactorOf<float> factor { f, state_->single };
    forward(factor, state_->parts, ordered);
    backward(factor, state_->parts, f.size, ordered);
    Eigen::VectorXd x(f.size);
    for (Eigen::Index i = 0; i < f.size; ++i)
        x[order[i]] = largest * static_cast<double>(ordered(i, 0));
    return x;
}

SparseCholesky::HalfSolution SparseCholesky::half_solve(std::span<const Load> loads, Eigen::Index columns) const
{
    const Supernodes f(*state_->factor);
    std::vector<Eigen::Index> loaded; // positions in the order of elimination
    RETRACTOR_ASSERT(state_->factorised && !rounded());
    for (const Load& load : loads) {
        RETRACTOR_ASSERT(load.unknown >= 0 && load.unknown < f.size);
        RETRACTOR_ASSERT(load.column >= 0 && load.column < columns);
        loaded.push_back(state_->place[static_cast<std::size_t>(load.unknown)]);
    }
    HalfSolution half;
    half.supernodes = reached_from(f, loaded);
    for (const std::int32_t s : half.supernodes)
        half.start.push_back(half.start.back() + f.columns(static_cast<std::size_t>(s)));
    half.values = Eigen::MatrixXd::Zero(half.start.back(), columns);
    // The rows below a supernode rise, so each search starts where the last search ended.
    std::size_t last = 0;
    const auto row_at = [&](Eigen::Index unknown) {
        const auto within = [&] {
            const auto s = static_cast<std::size_t>(half.supernodes[last]);
            return f.first[s] <= unknown && unknown < f.first[s + 1];
        };
        if (!within())
            last = static_cast<std::size_t>(std::upper_bound(half.supernodes.begin(), half.supernodes.end(), unknown,
                                                [&](Eigen::Index u, std::int32_t s) { return u < f.first[s]; })
                - half.supernodes.begin() - 1);
        return half.start[last] + unknown - f.first[half.supernodes[last]];
    };
    for (std::size_t i = 0; i < loads.size(); ++i)
        half.values(row_at(loaded[i]), loads[i].column) += loads[i].value;
    Eigen::MatrixXd beyond(f.most_rows, columns);
    for (std::size_t i = 0; i < half.supernodes.size(); ++i) {
        const auto s = static_cast<std::size_t>(half.supernodes[i]);
        forward(FactorOf<double> { f, f.values }, s, f.columns(s), half.start[i], row_at, half.values, beyond);
    }
    return half;
}

Eigen::MatrixXd SparseCholesky::product(const HalfSolution& a, const HalfSolution& b)
{
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(a.values.cols(), b.values.cols());
    for (std::size_t i = 0, j = 0; i < a.supernodes.size() && j < b.supernodes.size();) {
        if (a.supernodes[i] != b.supernodes[j]) {
            ++(a.supernodes[i] < b.supernodes[j] ? i : j);
            continue;
        }
        std::size_t same = 1; // number of common supernodes that follow each other; one product serves all of them
        while (i + same < a.supernodes.size() && j + same < b.supernodes.size()
            && a.supernodes[i + same] == b.supernodes[j + same])
            ++same;
        const Eigen::Index rows = a.start[i + same] - a.start[i];
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, static_cast<int>(sum.rows()), static_cast<int>(sum.cols()),
            static_cast<int>(rows), 1.0, a.values.data() + a.start[i], static_cast<int>(a.values.rows()),
            b.values.data() + b.start[j], static_cast<int>(b.values.rows()), 1.0, sum.data(),
            static_cast<int>(sum.rows()));
        i += same;
        j += same;
    }
    return sum;
}

Eigen::MatrixXd SparseCholesky::finish(const HalfSolution& half) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(state_->factorised && !rounded());
    RETRACTOR_ASSERT(half.start.size() == half.supernodes.size() + 1);
    Eigen::MatrixXd ordered = Eigen::MatrixXd::Zero(f.size, half.values.cols());
    for (std::size_t i = 0; i < half.supernodes.size(); ++i)
        ordered.middleRows(f.first[half.supernodes[i]], half.start[i + 1] - half.start[i])
            = half.values.middleRows(half.start[i], half.start[i + 1] - half.start[i]);
    backward(FactorOf<double> { f, f.values }, state_->parts, f.size, ordered);
    return in_matrix_order(ordered, *state_->factor);
}

Eigen::MatrixXd SparseCholesky::condense(const std::vector<double>& values, Eigen::Index count)
{
    State& s = *state_;
    RETRACTOR_ASSERT(analysed());
    RETRACTOR_ASSERT(values.size() == s.pattern.row.size());
    RETRACTOR_ASSERT(count >= 0 && count <= static_cast<Eigen::Index>(s.pattern.size()));
    s.factorised = false;
    s.failed = -1;
    s.check(values);
    s.release_single();
    UpdateMemory memory; // a condensed part is seldom condensed again
    return s.factorise_on_two_cores(values, memory, count);
}

Eigen::MatrixXd SparseCholesky::trailing_factor(Eigen::Index count) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(state_->factorised && !rounded());
    RETRACTOR_ASSERT(count >= 0 && count <= f.size);
    const Eigen::Index first = f.size - count;
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t s = 0; s < f.count; ++s)
        for (Eigen::Index j = std::max<Eigen::Index>(first - f.first[s], 0); j < f.columns(s); ++j)
            for (Eigen::Index i = j; i < f.rows(s); ++i)
                L(f.row(s, i) - first, f.first[s] + j - first) = f.block(s)(i, j);
    return L;
}

void SparseCholesky::fill_from_trailing(Eigen::Index count, Eigen::MatrixXd& x) const
{
    const auto n = static_cast<Eigen::Index>(state_->factor->n);
    RETRACTOR_ASSERT(count >= 0 && count <= n && x.rows() == n);
    const auto* order = static_cast<const int*>(state_->factor->Perm);
    for (Eigen::Index c = 0; c < x.cols(); ++c)
        for (Eigen::Index i = 0; i < n - count; ++i)
            x(order[i], c) = 0.0;
    fill_from_trailing_loaded(count, x);
}

void SparseCholesky::reduce_to_trailing(Eigen::Index count, Eigen::MatrixXd& x) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(f.values != nullptr && x.rows() == f.size);
    RETRACTOR_ASSERT(count >= 0 && count <= f.size);
    const Eigen::Index end = f.size - count;
    Eigen::MatrixXd ordered = in_elimination_order(x, *state_->factor), beyond(f.most_rows, x.cols());
    for (std::size_t s = 0; s < f.count && f.first[s] < end; ++s)
        forward(FactorOf<double> { f, f.values }, s, std::min<Eigen::Index>(f.columns(s), end - f.first[s]), f.first[s],
            in_order, ordered, beyond);
    x = in_matrix_order(ordered, *state_->factor);
}

void SparseCholesky::fill_from_trailing_loaded(Eigen::Index count, Eigen::MatrixXd& x) const
{
    const Supernodes f(*state_->factor);
    RETRACTOR_ASSERT(f.values != nullptr && x.rows() == f.size);
    RETRACTOR_ASSERT(count >= 0 && count <= f.size);
    const Eigen::Index given = f.size - count;
    Eigen::MatrixXd ordered = in_elimination_order(x, *state_->factor);
    backward(FactorOf<double> { f, f.values }, two_parts(f, given), given, ordered);
    x = in_matrix_order(ordered, *state_->factor);
}

void SparseCholesky::keep_factor_only()
{
    State& s = *state_;
    cholmod_free_work(&s.common);
    s.updates.release();
    s.pattern = {};
}

bool SparseCholesky::analysed() const { return state_->factor != nullptr; }
bool SparseCholesky::factorised() const { return state_->factorised; }
double SparseCholesky::reciprocal_condition() const { return state_->rcond; }
std::size_t SparseCholesky::bytes() const
{
    return state_->common.memory_inuse + state_->updates.bytes() + state_->place.size() * sizeof(std::int32_t);
}

} // namespace retractor::fem
