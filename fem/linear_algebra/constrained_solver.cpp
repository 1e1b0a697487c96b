#include "fem/linear_algebra/constrained_solver.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace retractor::fem {

ConstrainedSolver::ConstrainedSolver(const BlockPattern& pattern, std::vector<std::uint8_t> prescribed)
    : prescribed_(std::move(prescribed))
{
    analyse(pattern);
}

void ConstrainedSolver::analyse(const BlockPattern& pattern)
{
    RETRACTOR_ASSERT(prescribed_.size() == 3 * pattern.row_count());
    pattern_changed_ = false;
    free_.clear();
    value_source_.clear();
    std::vector<std::int32_t> number(prescribed_.size(), -1);
    SymmetricPattern upper;
    upper.column_start.push_back(0);
    // One scalar row of a block row of the lower triangle is a column of the upper triangle.
    for (std::size_t node = 0; node < pattern.row_count(); ++node)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t unknown = 3 * node + axis;
            if (prescribed_[unknown] != 0 || pattern.row_start[node] == pattern.row_start[node + 1])
                continue;
            number[unknown] = static_cast<std::int32_t>(free_.size());
            free_.push_back(static_cast<std::int32_t>(unknown));
            for (auto block = pattern.row_start[node]; block < pattern.row_start[node + 1]; ++block) {
                const auto other = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(block)]);
                for (std::size_t k = 0; k < 3; ++k)
                    if (const std::int32_t row = number[3 * other + k]; row >= 0) {
                        upper.row.push_back(row);
                        value_source_.push_back(
                            static_cast<std::int32_t>(9 * static_cast<std::size_t>(block) + 3 * axis + k));
                    }
            }
            upper.column_start.push_back(static_cast<std::int32_t>(upper.row.size()));
        }
    values_.resize(value_source_.size());
    if (!free_.empty())
        cholesky_.analyse(std::move(upper));
}

void ConstrainedSolver::factorise(const BlockMatrix& K)
{
    RETRACTOR_ASSERT(K.values.size() == 9 * K.pattern.block_count());
    if (pattern_changed_)
        analyse(K.pattern);
    if (free_.empty())
        return;
    for (std::size_t i = 0; i < value_source_.size(); ++i)
        values_[i] = K.values[static_cast<std::size_t>(value_source_[i])];
    try {
        cholesky_.factorise(values_);
    } catch (const SolverError& error) {
        if (cholesky_.failed_unknown() < 0)
            throw;
        const std::int32_t unknown = free_[static_cast<std::size_t>(cholesky_.failed_unknown())];
        throw SolverError(std::string("stiffness: ") + error.what(),
            "node " + std::to_string(unknown / 3) + ", axis " + "xyz"[unknown % 3]);
    }
}

Eigen::VectorXd ConstrainedSolver::solve(const Eigen::VectorXd& b) { return solve_all(b); }

Eigen::MatrixXd ConstrainedSolver::solve_all(const Eigen::MatrixXd& b)
{
    RETRACTOR_ASSERT(b.rows() == static_cast<Eigen::Index>(prescribed_.size()));
    if (free_.empty())
        return Eigen::MatrixXd::Zero(b.rows(), b.cols());
    Eigen::MatrixXd packed(static_cast<Eigen::Index>(free_.size()), b.cols());
    for (Eigen::Index column = 0; column < b.cols(); ++column)
        for (std::size_t i = 0; i < free_.size(); ++i)
            packed(static_cast<Eigen::Index>(i), column) = b(free_[i], column);
    return unpacked(cholesky_.solve(packed));
}

Eigen::MatrixXd ConstrainedSolver::unpacked(const Eigen::MatrixXd& solution) const
{
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(prescribed_.size()), solution.cols());
    for (Eigen::Index column = 0; column < x.cols(); ++column)
        for (std::size_t i = 0; i < free_.size(); ++i)
            x(free_[i], column) = solution(static_cast<Eigen::Index>(i), column);
    return x;
}

SparseCholesky::HalfSolution ConstrainedSolver::half_solve(
    std::span<const SparseCholesky::Load> loads, Eigen::Index columns) const
{
    std::vector<SparseCholesky::Load> free;
    for (SparseCholesky::Load load : loads) {
        const auto at = std::lower_bound(free_.begin(), free_.end(), load.unknown);
        if (at == free_.end() || *at != load.unknown)
            continue;
        load.unknown = static_cast<std::int32_t>(at - free_.begin());
        free.push_back(load);
    }
    if (free.empty()) {
        SparseCholesky::HalfSolution none;
        none.values.resize(0, columns);
        return none;
    }
    return cholesky_.half_solve(free, columns);
}

Eigen::MatrixXd ConstrainedSolver::finish(const SparseCholesky::HalfSolution& half) const
{
    if (half.supernodes.empty())
        return Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(prescribed_.size()), half.values.cols());
    return unpacked(cholesky_.finish(half));
}

Eigen::VectorXd ConstrainedSolver::precondition(const Eigen::VectorXd& r)
{
    if (!cholesky_.rounded())
        return solve(r);
    Eigen::VectorXd packed(static_cast<Eigen::Index>(free_.size()));
    for (std::size_t i = 0; i < free_.size(); ++i)
        packed[static_cast<Eigen::Index>(i)] = r[free_[i]];
    return unpacked(cholesky_.solve_rounded(packed));
}

ConstrainedSolver::Iterated ConstrainedSolver::iterate(
    const BlockMatrix& K, const Eigen::VectorXd& b, double tolerance, int max_iterations)
{
    // From this size on the factor does not fit into the cache, and its reading takes most of the time.
    constexpr std::size_t kWorthRounding = 100'000;
    if (free_.size() >= kWorthRounding)
        cholesky_.round_to_single();
    Iterated result { Eigen::VectorXd::Zero(b.size()), false, false, 0 };
    Eigen::VectorXd r = b;
    mask(r);
    Eigen::VectorXd z = precondition(r), p = z;
    double rz = r.dot(z);
    const double target = tolerance * tolerance * rz;
    for (; result.iterations < max_iterations && rz > target; ++result.iterations) {
        Eigen::VectorXd Kp = K.multiply(p);
        mask(Kp);
        const double curvature = p.dot(Kp);
        if (!(curvature > 0.0)) {
            result.negative_curvature = std::isfinite(curvature);
            if (result.iterations == 0)
                result.solution = p;
            return result;
        }
        const double step = rz / curvature;
        result.solution += step * p;
        r -= step * Kp;
        z = precondition(r);
        const double rz_next = r.dot(z);
        p = z + (rz_next / rz) * p;
        rz = rz_next;
    }
    result.converged = std::isfinite(rz) && rz <= target;
    return result;
}

void ConstrainedSolver::mask(Eigen::VectorXd& vector) const
{
    RETRACTOR_ASSERT(vector.size() == static_cast<Eigen::Index>(prescribed_.size()));
    for (std::size_t i = 0; i < prescribed_.size(); ++i)
        if (prescribed_[i] != 0)
            vector[static_cast<Eigen::Index>(i)] = 0.0;
}

} // namespace retractor::fem
