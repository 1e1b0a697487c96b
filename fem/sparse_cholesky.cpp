#include "fem/sparse_cholesky.h"

#include "mesh/base/error.h"

#include <cblas.h>
#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor {

void set_blas_threads(int threads) { openblas_set_num_threads(std::max(threads, 1)); }

std::string blas_description()
{
    return std::string(openblas_get_config()) + ", core " + openblas_get_corename() + ", "
        + std::to_string(openblas_get_num_threads()) + " thread(s)";
}

namespace {

    /// A supernodal factor's arrays: dense blocks of columns with the same rows, the diagonal block first.
    struct Supernodes {
        explicit Supernodes(const cholmod_factor& f)
            : count(f.nsuper)
            , size(static_cast<Eigen::Index>(f.n))
            , first(static_cast<const int*>(f.super))
            , row_start(static_cast<const int*>(f.pi))
            , value_start(static_cast<const int*>(f.px))
            , row_list(static_cast<const int*>(f.s))
            , values(static_cast<const double*>(f.x))
        {
            for (std::size_t s = 0; s < count; ++s)
                most_rows = std::max(most_rows, rows(s));
        }
        Eigen::Index columns(std::size_t s) const { return first[s + 1] - first[s]; }
        Eigen::Index rows(std::size_t s) const { return row_start[s + 1] - row_start[s]; }
        Eigen::Index row(std::size_t s, Eigen::Index i) const { return row_list[row_start[s] + i]; }
        Eigen::Map<const Eigen::MatrixXd> block(std::size_t s) const
        {
            return { values + value_start[s], rows(s), columns(s) };
        }

        std::size_t count;
        Eigen::Index size, most_rows = 0;
        const int *first, *row_start, *value_start, *row_list;
        const double* values;
    };

} // namespace

struct SparseCholesky::State {
    cholmod_common common {};
    cholmod_factor* factor = nullptr;
    SymmetricPattern pattern;
    bool factorised = false;
    std::int32_t failed = -1;
    double rcond = 0.0;
    // Work space that CHOLMOD keeps from one solve to the next.
    cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;

    State()
    {
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
        cholmod_free_factor(&factor, &common);
        cholmod_free_dense(&x, &common);
        cholmod_free_dense(&y, &common);
        cholmod_free_dense(&e, &common);
        factorised = false;
    }
    /// CHOLMOD's view of the arrays; it does not write into them.
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
    s.common.postorder = 0; // it would change the order
    cholmod_sparse a = s.view(nullptr);
    s.factor = cholmod_analyze_p(&a, order.data(), nullptr, 0, &s.common);
    if (s.factor == nullptr || s.common.status < CHOLMOD_OK)
        s.fail("the analysis of the matrix");
}

std::vector<std::int32_t> SparseCholesky::elimination_order() const
{
    const auto* first = static_cast<const int*>(state_->factor->Perm);
    return { first, first + state_->factor->n };
}

void SparseCholesky::factorise(const std::vector<double>& values)
{
    State& s = *state_;
    s.factorised = false;
    s.failed = -1;
    const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad != values.end()) {
        const auto entry = static_cast<std::size_t>(bad - values.begin());
        s.failed = s.pattern.row[entry];
        throw SolverError("the matrix has an entry that is not finite", "unknown " + std::to_string(s.failed));
    }
    cholmod_sparse a = s.view(values.data());
    cholmod_factorize(&a, s.factor, &s.common);
    if (s.common.status == CHOLMOD_NOT_POSDEF) {
        s.failed = static_cast<const int*>(s.factor->Perm)[s.factor->minor];
        throw SolverError("the matrix is not positive definite", "unknown " + std::to_string(s.failed));
    }
    if (s.common.status < CHOLMOD_OK)
        s.fail("the factorisation");
    s.rcond = cholmod_rcond(s.factor, &s.common);
    s.factorised = true;
}

std::int32_t SparseCholesky::failed_unknown() const { return state_->failed; }

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right_sides)
{
    State& s = *state_;
    cholmod_dense b {};
    b.nrow = b.d = static_cast<std::size_t>(right_sides.rows());
    b.ncol = static_cast<std::size_t>(right_sides.cols());
    b.nzmax = b.nrow * b.ncol;
    b.x = const_cast<double*>(right_sides.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    if (!cholmod_solve2(CHOLMOD_A, s.factor, &b, nullptr, &s.x, nullptr, &s.y, &s.e, &s.common))
        s.fail("the solution");
    return Eigen::Map<const Eigen::MatrixXd>(
        static_cast<const double*>(s.x->x), right_sides.rows(), right_sides.cols());
}

Eigen::MatrixXd SparseCholesky::trailing_factor(Eigen::Index count) const
{
    const Supernodes f(*state_->factor);
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
    const Supernodes f(*state_->factor);
    const Eigen::Index given = f.size - count, cases = x.cols();
    const auto* order = static_cast<const int*>(state_->factor->Perm);
    Eigen::MatrixXd ordered(f.size, cases), beyond(f.most_rows, cases);
    for (Eigen::Index i = given; i < f.size; ++i)
        ordered.row(i) = x.row(order[i]);
    for (std::size_t s = f.count; s-- > 0;) {
        const Eigen::Index first = f.first[s], columns = std::min<Eigen::Index>(f.columns(s), given - first);
        if (columns <= 0)
            continue;
        const Eigen::Index rows = f.rows(s) - columns;
        for (Eigen::Index c = 0; c < cases; ++c)
            for (Eigen::Index i = 0; i < rows; ++i)
                beyond(i, c) = ordered(f.row(s, columns + i), c);
        const double* L = f.block(s).data();
        const auto stride = static_cast<int>(f.rows(s));
        const auto n = static_cast<int>(columns), m = static_cast<int>(rows), k = static_cast<int>(cases);
        double* out = ordered.data() + first;
        if (k == 1) {
            if (m > 0)
                cblas_dgemv(CblasColMajor, CblasTrans, m, n, -1.0, L + n, stride, beyond.data(), 1, 0.0, out, 1);
            else
                std::fill(out, out + n, 0.0);
            cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, n, L, stride, out, 1);
            continue;
        }
        const auto all = static_cast<int>(f.size), most = static_cast<int>(f.most_rows);
        if (m > 0)
            cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, n, k, m, -1.0, L + n, stride, beyond.data(), most, 0.0,
                out, all);
        else
            ordered.middleRows(first, columns).setZero();
        cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, k, 1.0, L, stride, out, all);
    }
    for (Eigen::Index i = 0; i < given; ++i)
        x.row(order[i]) = ordered.row(i);
}

void SparseCholesky::keep_factor_only()
{
    State& s = *state_;
    cholmod_free_dense(&s.x, &s.common);
    cholmod_free_dense(&s.y, &s.common);
    cholmod_free_dense(&s.e, &s.common);
    cholmod_free_work(&s.common);
    s.pattern = {};
}

bool SparseCholesky::analysed() const { return state_->factor != nullptr; }
bool SparseCholesky::factorised() const { return state_->factorised; }
double SparseCholesky::reciprocal_condition() const { return state_->rcond; }
double SparseCholesky::factor_entries() const { return state_->common.lnz; }
std::size_t SparseCholesky::bytes() const { return state_->common.memory_inuse; }

} // namespace retractor
