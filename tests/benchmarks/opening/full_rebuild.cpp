#include "tests/benchmarks/opening/full_rebuild.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/job.h"

#include <algorithm>

namespace retractor::benchmarks {

FullRebuild::FullRebuild(fem::OnlineStiffness stiffness, std::span<const VertexId> fixed,
    std::span<const fem::OnlineHook> hooks, int blas_threads)
    : stiffness_(std::move(stiffness))
    , blas_threads_(blas_threads)
    , prescribed_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(stiffness_.slot_count())))
    , number_(stiffness_.slot_count(), 0)
{
    for (const VertexId v : fixed)
        number_[static_cast<std::size_t>(v)] = -1;
    for (const fem::OnlineHook& hook : hooks)
        for (const VertexId v : hook.nodes) {
            number_[static_cast<std::size_t>(v)] = -1;
            prescribed_.segment<3>(3 * v) = hook.drive.displacement;
        }
    for (VertexId v = 0; v < static_cast<VertexId>(number_.size()); ++v)
        if (number_[static_cast<std::size_t>(v)] == 0 && stiffness_.alive(v)) {
            number_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(free_.size());
            free_.push_back(v);
        } else {
            number_[static_cast<std::size_t>(v)] = -1;
        }
    pattern_.column_start.push_back(0);
    for (const VertexId v : free_)
        for (std::int32_t axis = 0; axis < 3; ++axis) {
            for (const VertexId other : stiffness_.row(v).column)
                if (const std::int32_t i = number_[static_cast<std::size_t>(other)]; i >= 0 && other <= v)
                    for (std::int32_t a = 0; a < (other == v ? axis + 1 : 3); ++a)
                        pattern_.row.push_back(3 * i + a);
            pattern_.column_start.push_back(static_cast<std::int32_t>(pattern_.row.size()));
        }
    values_.resize(pattern_.row.size());
}

void FullRebuild::run()
{
    Stopwatch watch;
    const auto lap = [&] {
        const double ms = 1e3 * watch.seconds();
        watch = Stopwatch();
        return ms;
    };
    stiffness_.assemble();
    std::size_t entry = 0;
    for (const VertexId v : free_) {
        const fem::OnlineStiffness::Row& row = stiffness_.row(v);
        for (std::int32_t axis = 0; axis < 3; ++axis)
            for (std::size_t k = 0; k < row.column.size() && row.column[k] <= v; ++k)
                if (number_[static_cast<std::size_t>(row.column[k])] >= 0)
                    for (std::int32_t a = 0; a < (row.column[k] == v ? axis + 1 : 3); ++a)
                        values_[entry++] = row.value[9 * k + static_cast<std::size_t>(3 * axis + a)];
    }
    assemble_ms = lap();
    fem::SparseCholesky cholesky;
    cholesky.analyse(pattern_);
    analyse_ms = lap();
    {
        // CHOLMOD processes the supernodes one after the other, so only BLAS can use a second core.
        const fem::ScopedBlasThreads while_factoring(blas_threads_);
        cholesky.factorise(values_);
    }
    factor_ms = lap();
    const Eigen::VectorXd pull = -stiffness_.multiply(prescribed_);
    Eigen::MatrixXd right_side(3 * static_cast<Eigen::Index>(free_.size()), 1);
    for (std::size_t i = 0; i < free_.size(); ++i)
        right_side.col(0).segment<3>(3 * static_cast<Eigen::Index>(i)) = pull.segment<3>(3 * free_[i]);
    const Eigen::MatrixXd x = cholesky.solve(right_side);
    solution_ = prescribed_;
    for (std::size_t i = 0; i < free_.size(); ++i)
        solution_.segment<3>(3 * free_[i]) = x.col(0).segment<3>(3 * static_cast<Eigen::Index>(i));
    solve_ms = lap();
}

double full_rebuild_gemm_gflops()
{
    constexpr Eigen::Index kSize = 4096;
    const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(kSize, kSize, 1.0);
    const Stopwatch watch;
    const Eigen::MatrixXd c = fem::product(a, a);
    const double seconds = watch.seconds();
    return 2.0 * static_cast<double>(kSize * kSize * kSize) / seconds * (c(0, 0) > 0.0 ? 1e-9 : 0.0);
}

} // namespace retractor::benchmarks
