#pragma once
// Sparse Cholesky factorisation: CHOLMOD (supernodal) with METIS nested dissection over OpenBLAS, behind plain arrays.

#include "fem/linear_algebra/symmetric_pattern.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace retractor::fem {

enum class Ordering {
    nested_dissection, ///< METIS: for large matrices
    minimum_degree, ///< AMD: found sooner, as good for some thousand unknowns
};

/// Splits a graph in two by a set of vertices (METIS): per vertex 0, 1, or 2 where it belongs to the set between.
/// @param graph both triangles, no diagonal, rows rising. @param weight per vertex: the sides have about the same sum,
/// the set a small one. @throws SolverError when METIS fails.
std::vector<std::int32_t> bisect(const SymmetricPattern& graph, const std::vector<std::int32_t>& weight);

class SparseCholesky {
public:
    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Orders and analyses; once per pattern. @throws SolverError when out of memory.
    void analyse(SymmetricPattern pattern, Ordering ordering = Ordering::nested_dissection);
    /// Analyses with the order given, unchanged: `order[i]` is eliminated i-th. So the unknowns of interest can come
    /// last, and their part of the factor be read.
    /// @throws InputError when `order` is not a permutation; SolverError when out of memory.
    void analyse_in_order(SymmetricPattern pattern, std::vector<std::int32_t> order);
    /// The order that was found or given. @pre analysed().
    std::vector<std::int32_t> elimination_order() const;

    /// @param values one per row entry of the pattern. @pre analyse() was called.
    /// @throws SolverError naming the unknown (of the matrix, from 0; also by failed_unknown()) at which the matrix is
    /// found not to be positive definite, and on values that are not finite.
    void factorise(const std::vector<double>& values);
    std::int32_t failed_unknown() const; ///< of the last factorise(); -1: none

    /// Solves for all columns of `right_sides`, large systems on two cores. @pre factorise() succeeded.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_sides) const;

    /// A right side with few entries.
    struct Load {
        std::int32_t unknown = 0, column = 0;
        double value = 0.0;
    };
    /// y = L^-1 P b, where it is not zero: on the supernodes between the loads and the root of the elimination tree.
    struct HalfSolution {
        std::vector<std::int32_t> supernodes; ///< rising
        std::vector<Eigen::Index> start { 0 }; ///< row of `values` where each begins, and the end
        Eigen::MatrixXd values; ///< one column per right side
    };
    /// The first half of a solve: what the loads reach, and a glance at each supernode. @pre factorise() succeeded.
    HalfSolution half_solve(std::span<const Load> loads, Eigen::Index columns) const;
    /// b_a^T A^-1 b_b for all columns of both: the entries of the inverse between two sets of loads need no more.
    static Eigen::MatrixXd product(const HalfSolution& a, const HalfSolution& b);
    /// A^-1 b: the other half. @pre no factorise() since half_solve().
    Eigen::MatrixXd finish(const HalfSolution& half) const;

    /// Factors all but the last `count` unknowns in the order of elimination. What the matrix has among these is not
    /// read. @return lower triangle, count x count: what the others, condensed, add to the stiffness there (nowhere
    /// positive definite). Then fill_from_trailing(), reduce_to_trailing() and fill_from_trailing_loaded() may be used,
    /// for this count. Multifrontal [Duff and Reid 1983] on the supernodes that CHOLMOD found: it would go on to factor
    /// the last as well. @pre analyse_in_order() was called. @throws as factorise().
    Eigen::MatrixXd condense(const std::vector<double>& values, Eigen::Index count);

    /// The lower triangular factor of the last `count` unknowns in the order of elimination: count x count. Times its
    /// transpose it is the Schur complement on them, everything before condensed. @pre factorise() succeeded.
    Eigen::MatrixXd trailing_factor(Eigen::Index count) const;
    /// With the values of the last `count` unknowns (in the order of elimination) given in `x`, fills in the others'
    /// where no load acts on them: half a solve. One column per case. @pre factorise() or condense() succeeded.
    void fill_from_trailing(Eigen::Index count, Eigen::MatrixXd& x) const;

    /// The first half of a solve, down to the last `count` unknowns: of these `x` then holds what the others' loads do
    /// to them; of the others what fill_from_trailing_loaded() needs. @pre factorise() or condense() succeeded.
    void reduce_to_trailing(Eigen::Index count, Eigen::MatrixXd& x) const;
    /// As fill_from_trailing() with loads on the others: their part of `x` as reduce_to_trailing() left it.
    void fill_from_trailing_loaded(Eigen::Index count, Eigen::MatrixXd& x) const;

    /// Frees the pattern and the work space; the factor stays. Another factorise() needs another analysis.
    void keep_factor_only();

    bool analysed() const;
    bool factorised() const;
    double reciprocal_condition() const; ///< cheap estimate from the factor's diagonal
    double factor_entries() const; ///< nonzeros of L
    std::size_t bytes() const; ///< memory held now

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
