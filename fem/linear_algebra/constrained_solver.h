#pragma once
// Solves K du = b where some unknowns are prescribed. The prescribed unknowns are eliminated, so that CHOLMOD receives
// the free unknowns only. Vectors have three entries per node.
//
// The factor of an earlier K can precondition conjugate gradients with the present K. A solve costs a fiftieth of a
// factorisation, so an old factor that needs a dozen iterations is cheaper than a new factor.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

class ConstrainedSolver {
public:
    /// Orders and analyses the free part of the pattern.
    /// @param prescribed one flag per unknown, 1 = prescribed
    ConstrainedSolver(const BlockPattern& pattern, std::vector<std::uint8_t> prescribed);

    /// From here on K has another pattern, with the same nodes. The factor at hand still preconditions iterate(); the
    /// next factorise() orders and analyses anew.
    void change_pattern() { pattern_changed_ = true; }

    const std::vector<std::uint8_t>& prescribed() const { return prescribed_; }
    std::size_t free_count() const { return free_.size(); }

    /// Factors the free part of K.
    /// @throws SolverError naming the node and axis when K is not positive definite on the free unknowns
    void factorise(const BlockMatrix& K);
    bool factorised() const { return free_.empty() || cholesky_.factorised(); }
    std::size_t bytes() const { return cholesky_.bytes(); }
    double reciprocal_condition() const { return cholesky_.reciprocal_condition(); }

    /// Solves with the present factor. The solution is exact when the factor belongs to K. Prescribed entries of the
    /// result are zero.
    Eigen::VectorXd solve(const Eigen::VectorXd& b);
    /// Solves as solve() for all columns of `b` at once.
    Eigen::MatrixXd solve_all(const Eigen::MatrixXd& b);

    /// Halves of a solve for loads on few unknowns: see SparseCholesky::half_solve(), product() and finish(). Unknowns
    /// are numbered as in the mesh; a load on a prescribed unknown has no effect.
    /// @pre factorised()
    SparseCholesky::HalfSolution half_solve(std::span<const SparseCholesky::Load> loads, Eigen::Index columns) const;
    Eigen::MatrixXd finish(const SparseCholesky::HalfSolution& half) const;

    struct Iterated {
        Eigen::VectorXd solution;
        bool converged = false;
        bool negative_curvature = false; ///< K is not positive definite; `solution` is then a descent direction
        int iterations = 0;
    };
    /// Preconditioned conjugate gradients with K. Iteration ends when the residual has fallen to `tolerance` times the
    /// norm of b, both in the norm of the factor, or at a direction of negative curvature (Steihaug 1983). A large
    /// factor is rounded to single precision (SparseCholesky::round_to_single()); solve() then needs a factorise().
    Iterated iterate(const BlockMatrix& K, const Eigen::VectorXd& b, double tolerance, int max_iterations);

    /// Sets prescribed entries to zero.
    void mask(Eigen::VectorXd& vector) const;

private:
    void analyse(const BlockPattern& pattern);
    Eigen::VectorXd precondition(const Eigen::VectorXd& r); ///< with the present factor, in either precision
    Eigen::MatrixXd unpacked(const Eigen::MatrixXd& solution) const;

    std::vector<std::uint8_t> prescribed_;
    std::vector<std::int32_t> free_; ///< free unknowns of the mesh, rising
    std::vector<std::int32_t> value_source_; ///< index into BlockMatrix::values, per entry of the Cholesky pattern
    std::vector<double> values_;
    SparseCholesky cholesky_;
    bool pattern_changed_ = false; ///< since the last analysis
};

} // namespace retractor::fem
