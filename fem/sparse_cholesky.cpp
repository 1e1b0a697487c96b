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

void SparseCholesky::analyse(SymmetricPattern pattern)
{
    State& s = *state_;
    s.release();
    s.pattern = std::move(pattern);
    if (s.pattern.size() <= 0)
        throw SolverError("there is nothing to solve: the matrix has no unknowns");
    cholmod_sparse a = s.view(nullptr);
    s.factor = cholmod_analyze(&a, &s.common);
    if (s.factor == nullptr || s.common.status < CHOLMOD_OK)
        s.fail("the analysis of the matrix");
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

bool SparseCholesky::analysed() const { return state_->factor != nullptr; }
bool SparseCholesky::factorised() const { return state_->factorised; }
double SparseCholesky::reciprocal_condition() const { return state_->rcond; }
double SparseCholesky::factor_entries() const { return state_->common.lnz; }
std::size_t SparseCholesky::bytes() const { return state_->common.memory_inuse; }

} // namespace retractor
