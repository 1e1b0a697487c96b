#pragma once
// Solves K du = b where some unknowns are prescribed: these are eliminated, and only the free ones reach CHOLMOD. A
// factor of an earlier K serves as the preconditioner of conjugate gradients with the present K: a solve costs a
// fiftieth of a factorisation, so a stale factor that needs a dozen iterations is cheaper than a fresh one. Vectors
// have three entries per node; those of prescribed unknowns are left alone.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

class ConstrainedSolver {
public:
    /// Orders and analyses the free part of the pattern. @param prescribed one per unknown, 1 = prescribed.
    ConstrainedSolver(const BlockPattern& pattern, std::vector<std::uint8_t> prescribed);

    const std::vector<std::uint8_t>& prescribed() const { return prescribed_; }
    std::size_t free_count() const { return free_.size(); }

    /// @throws SolverError naming the node and axis when K is not positive definite on the free unknowns.
    void factorise(const BlockMatrix& K);
    bool factorised() const { return free_.empty() || cholesky_.factorised(); }
    std::size_t bytes() const { return cholesky_.bytes(); }
    double reciprocal_condition() const { return cholesky_.reciprocal_condition(); }

    /// Solves with the factor as it is: exact when it is K's own. Prescribed entries of the result are zero.
    Eigen::VectorXd solve(const Eigen::VectorXd& b);
    /// The same for all columns of `b` at once.
    Eigen::MatrixXd solve_all(const Eigen::MatrixXd& b);

    /// Halves of a solve for loads on few unknowns (of the mesh; on prescribed ones they do nothing): see
    /// SparseCholesky::half_solve(), product() and finish(). @pre factorised().
    SparseCholesky::HalfSolution half_solve(std::span<const SparseCholesky::Load> loads, Eigen::Index columns) const;
    Eigen::MatrixXd finish(const SparseCholesky::HalfSolution& half) const;

    struct Iterated {
        Eigen::VectorXd solution;
        bool converged = false;
        bool negative_curvature = false; ///< K is not positive definite: `solution` is as far as it went, a descent
        int iterations = 0;
    };
    /// Conjugate gradients with K, preconditioned by the factor, until the residual is `tolerance` of b's in the
    /// factor's norm; stopped where a direction of negative curvature is met [Steihaug 1983].
    Iterated iterate(const BlockMatrix& K, const Eigen::VectorXd& b, double tolerance, int max_iterations);

    /// Sets prescribed entries to zero.
    void mask(Eigen::VectorXd& vector) const;

private:
    Eigen::MatrixXd unpacked(const Eigen::MatrixXd& solution) const;

    std::vector<std::uint8_t> prescribed_;
    std::vector<std::int32_t> free_; ///< unknowns of the mesh that are free, rising
    std::vector<std::int32_t>
        value_source_; ///< per entry of the Cholesky pattern: where in BlockMatrix::values it lies
    std::vector<double> values_;
    SparseCholesky cholesky_;
};

} // namespace retractor::fem
