#pragma once
// The small dense system that is left of a body after everything but the kept vertices is condensed: kept vertices,
// what cuts changed, what they added, and hooks. Exact. Two routes, whichever costs less: few changed unknowns correct
// the known compliance (a capacitance system of their size, LU); many, and the changed stiffness of all kept vertices
// is factored (Cholesky). Units mm, N; three rows per vertex, one column per case.

#include "fem/interactive/cut_change.h"
#include "fem/interactive/online_hook.h"
#include "fem/linear_algebra/dense_algebra.h"

#include <optional>

namespace retractor::fem {

/// Compliance of the kept vertices that hooks hold; made when hooks or the view change.
struct HookCompliance {
    std::vector<std::int32_t> rows; ///< of the held vertices that are kept: their rows among the kept
    Eigen::MatrixXd factor; ///< L L^T = C_hh, lower triangle
    Eigen::MatrixXd columns; ///< C_kh L^-T; C - columns columns^T is the compliance with the hooks held still
};
/// @param held only those that the view keeps count. @throws SolverError when two held vertices cannot be told apart.
HookCompliance make_hook_compliance(const CondensedState& view, const std::vector<HeldVertex>& held);

enum class LocalRoute { low_rank, dense };

/// Multiplications that each route takes, roughly.
double low_rank_work(std::size_t changed_vertices, std::size_t held_vertices);
double dense_work(std::size_t kept_vertices, std::size_t held_vertices);

class LocalSystem {
public:
    // All are referred to as long as this lives.
    /// By the low-rank route. @param change with its matrix.
    LocalSystem(const OnlineStiffness& K, const CondensedState& view, const CutChange& change,
        const HookCompliance& hooks, const std::vector<HeldVertex>& held);
    /// By the dense route. @param stiffness of the kept vertices in the view's state.
    LocalSystem(const OnlineStiffness& K, const CondensedState& view, const CutChange& change,
        const Eigen::MatrixXd& stiffness, const std::vector<HeldVertex>& held);

    LocalRoute route() const { return stiffness_ == nullptr ? LocalRoute::low_rank : LocalRoute::dense; }
    /// Estimate for the part that was solved anew: tiny when a piece has come off. 0: not positive definite.
    double reciprocal_condition() const { return rcond_; }
    std::size_t bytes() const;

    /// Dense route: vertices that have been appended to `held` since this was made are held as well, by one solve per
    /// unknown with the factor as it is. @pre they are kept.
    void hold_appended();

    struct Solution {
        Eigen::MatrixXd kept; ///< displacement of the view's vertices
        Eigen::MatrixXd kept_forces; ///< low-rank route: that give it in the view's state, less `elsewhere`
        Eigen::MatrixXd added; ///< of CutChange::newborn
        Eigen::MatrixXd held_forces; ///< three rows per held vertex that is kept: the force that the hook applies there
    };
    /// @param load_kept, load_newborn forces; @param hook_displacement three rows per hook. @param elsewhere what loads
    /// on vertices that have left the view do to those it keeps (LoadOnDropped::response); empty: none.
    Solution solve(const Eigen::MatrixXd& load_kept, const Eigen::MatrixXd& load_newborn,
        const Eigen::MatrixXd& hook_displacement, const Eigen::MatrixXd& elsewhere = {}) const;

private:
    Eigen::MatrixXd low_rank_kept(const Eigen::MatrixXd& load, const Eigen::MatrixXd& given,
        const Eigen::MatrixXd& elsewhere, Eigen::MatrixXd& forces, Eigen::MatrixXd& kept_forces) const;
    Eigen::MatrixXd dense_kept(
        const Eigen::MatrixXd& load, const Eigen::MatrixXd& given, Eigen::MatrixXd& forces) const;
    void prepare_low_rank();
    void prepare_dense();

    const OnlineStiffness* K_;
    const CondensedState* view_;
    const Eigen::MatrixXd* stiffness_;
    const CutChange* change_;
    const HookCompliance* hooks_; ///< null by the dense route
    std::vector<std::int32_t> hook_rows_; ///< of the held vertices that are kept: their rows among the kept
    const std::vector<HeldVertex>* held_;
    double rcond_ = 1.0;
    std::optional<DenseLu> capacitance_; ///< I + C dK on the changed unknowns
    std::vector<std::int32_t> free_rows_; ///< dense: rows of the kept that no hook holds
    Eigen::MatrixXd factor_; ///< dense: Cholesky factor on them
    std::size_t held_in_factor_ = 0; ///< how many of the held vertices the factor knows of
    std::vector<std::int32_t> late_; ///< dense: rows, among the free, of those held since
    Eigen::MatrixXd late_columns_; ///< displacements of the free by unit forces on them
    Eigen::MatrixXd late_factor_; ///< Cholesky factor of their rows
    Eigen::MatrixXd held_stiffness_; ///< dense: rows of the changed stiffness of the held vertices, all columns
};

} // namespace retractor::fem
