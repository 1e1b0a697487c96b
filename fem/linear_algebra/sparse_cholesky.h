#pragma once
// Sparse Cholesky factorisation by CHOLMOD (supernodal) with METIS nested dissection and OpenBLAS, behind plain arrays.
// Large matrices are ordered and analysed by CHOLMOD, and factored on two cores by our multifrontal method (Duff, Reid
// 1983, doi 10.1145/356044.356047).
// "Order" means the order of elimination; A is the matrix, P its permutation, L its factor.

#include "fem/linear_algebra/symmetric_pattern.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace retractor::fem {

enum class Ordering {
    nested_dissection, ///< METIS, for large matrices
    minimum_degree, ///< AMD: computed faster than METIS, with as good a factor for some thousand unknowns
};

/// Splits a graph by a small set of vertices into two parts without edges between them (METIS).
/// @param graph both triangles, no diagonal, rows rising
/// @param weight one per vertex; the two parts have about the same sum
/// @return one per vertex: 0 or 1 for the parts, 2 for the separating set
/// @throws SolverError when METIS fails
std::vector<std::int32_t> bisect(const SymmetricPattern& graph, const std::vector<std::int32_t>& weight);

class SparseCholesky {
public:
    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Orders and analyses the pattern, once per pattern. @throws SolverError when out of memory
    void analyse(SymmetricPattern pattern, Ordering ordering = Ordering::nested_dissection);
    /// Analyses the pattern in the given order: `order[i]` is eliminated i-th. A caller puts the unknowns of interest
    /// last and reads their part of the factor.
    /// @throws InputError when `order` is not a permutation; SolverError when out of memory
    void analyse_in_order(SymmetricPattern pattern, std::vector<std::int32_t> order);
    /// The order that was computed or given. @pre analysed()
    std::vector<std::int32_t> elimination_order() const;

    /// Factors the matrix: a large one on two cores, with the same bits as on one.
    /// @param values one per row entry of the pattern
    /// @pre analysed()
    /// @throws SolverError when a value is not finite, or when the matrix is not positive definite. The message and
    /// failed_unknown() name the unknown of the matrix, counted from 0.
    void factorise(const std::vector<double>& values);
    std::int32_t failed_unknown() const; ///< unknown at which the last factorise() failed; -1: none

    /// Solves for all columns of `right_sides`. Large systems use two cores. @pre factorise() succeeded, !rounded()
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_sides) const;

    /// Rounds the factor to single precision, in place: half of the time of a solve, which is the time to read the
    /// factor. The rounded factor preconditions conjugate gradients as well as the factor does
    /// (Arioli, Duff 2009, Electron. Trans. Numer. Anal. 33, 31-44). Until the next factorise(), which takes the same
    /// memory, only solve_rounded() may be called.
    /// @pre factorise() succeeded
    void round_to_single();
    bool rounded() const;
    /// Solves with the rounded factor, in single precision. @pre rounded()
    Eigen::VectorXd solve_rounded(const Eigen::VectorXd& right_side) const;

    /// One entry of a right side that is mostly zero.
    struct Load {
        std::int32_t unknown = 0, column = 0;
        double value = 0.0;
    };
    /// The nonzero part of y = L^-1 P b, on the supernodes between the loads and the root of the elimination tree.
    struct HalfSolution {
        std::vector<std::int32_t> supernodes; ///< rising
        std::vector<Eigen::Index> start { 0 }; ///< first row of `values` per supernode, and the number of rows
        Eigen::MatrixXd values; ///< one column per right side
    };
    /// First half of a solve. The cost is that of the supernodes that the loads reach, and one test of every other
    /// supernode.
    /// @pre factorise() succeeded
    HalfSolution half_solve(std::span<const Load> loads, Eigen::Index columns) const;
    /// b_a^T A^-1 b_b for all columns of both: the entries of the inverse between two sets of loads.
    static Eigen::MatrixXd product(const HalfSolution& a, const HalfSolution& b);
    /// A^-1 b: the second half of the solve. @pre no factorise() since half_solve()
    Eigen::MatrixXd finish(const HalfSolution& half) const;

    /// Factors all but the last `count` unknowns of the order, by the multifrontal method on the supernodes of CHOLMOD;
    /// CHOLMOD itself would factor the last unknowns as well.
    /// Entries of the matrix among the last unknowns are not read. Afterwards fill_from_trailing(),
    /// reduce_to_trailing() and fill_from_trailing_loaded() may be called with this count.
    /// @return lower triangle, count x count: the term that the condensed unknowns add to the stiffness of the last
    /// unknowns (negative semidefinite)
    /// @pre analyse_in_order() was called
    /// @throws as factorise()
    Eigen::MatrixXd condense(const std::vector<double>& values, Eigen::Index count);

    /// The lower triangular factor of the last `count` unknowns of the order, count x count. The factor times its
    /// transpose is the Schur complement on these unknowns.
    /// @pre factorise() succeeded
    Eigen::MatrixXd trailing_factor(Eigen::Index count) const;
    /// Half a solve. Given the values of the last `count` unknowns of the order in `x`, computes the values of all
    /// other unknowns, without loads on these others. One column per case.
    /// @pre factorise() or condense() succeeded
    void fill_from_trailing(Eigen::Index count, Eigen::MatrixXd& x) const;

    /// First half of a solve, down to the last `count` unknowns. The last rows of `x` become the loads that the other
    /// unknowns transfer to the last; the other rows become the input of fill_from_trailing_loaded().
    /// @pre factorise() or condense() succeeded
    void reduce_to_trailing(Eigen::Index count, Eigen::MatrixXd& x) const;
    /// Computes as fill_from_trailing(), with loads on the other unknowns. Their rows of `x` come from
    /// reduce_to_trailing().
    void fill_from_trailing_loaded(Eigen::Index count, Eigen::MatrixXd& x) const;

    /// Frees the pattern and the work space and keeps the factor. Another factorise() needs another analysis.
    void keep_factor_only();

    bool analysed() const;
    bool factorised() const;
    double reciprocal_condition() const; ///< estimate from the diagonal of the factor
    std::size_t bytes() const; ///< memory in use

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
