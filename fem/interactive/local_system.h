#pragma once
// The small dense system that remains of a body after static condensation: retained vertices, the change by cuts, added
// vertices, and hooks. The solution is exact. The cheaper of two routes is taken. Few changed unknowns: a correction of
// the known compliance by a system of their number (Woodbury formula, LU). Many changed unknowns: a Cholesky factor of
// the changed stiffness of all retained vertices. Units mm, N; three rows per vertex, one column per case.

#include "fem/interactive/cut_change.h"
#include "fem/interactive/online_hook.h"
#include "fem/linear_algebra/dense_algebra.h"

#include <optional>

namespace retractor::fem {

/// Compliance C of the retained vertices that hooks hold (index h), computed anew when the hooks or the state change.
struct HookCompliance {
    std::vector<std::int32_t> rows; ///< rows of the held retained vertices among the retained
    Eigen::MatrixXd factor; ///< L L^T = C_hh, lower triangle
    Eigen::MatrixXd columns; ///< C_kh L^-T; C - columns columns^T is the compliance while the hooks do not move
};
/// @param held held vertices; vertices that the state does not retain are ignored
/// @throws SolverError when the compliance of the held vertices is singular
HookCompliance make_hook_compliance(const CondensedState& state, const std::vector<HeldVertex>& held);

enum class LocalRoute { low_rank, dense };

/// Approximate number of multiplications of each route.
double low_rank_work(std::size_t changed_vertices, std::size_t held_vertices);
double dense_work(std::size_t kept_vertices, std::size_t held_vertices);

class LocalSystem {
public:
    // All arguments are referred to for the lifetime of this object.
    /// Low-rank route. @pre `change` has its matrix `stiffness`
    LocalSystem(const OnlineStiffness& K, const CondensedState& state, const CutChange& change,
        const HookCompliance& hooks, const std::vector<HeldVertex>& held);
    /// Dense route. @param stiffness of the retained vertices in the given state
    LocalSystem(const OnlineStiffness& K, const CondensedState& state, const CutChange& change,
        const Eigen::MatrixXd& stiffness, const std::vector<HeldVertex>& held);

    LocalRoute route() const { return stiffness_ == nullptr ? LocalRoute::low_rank : LocalRoute::dense; }
    /// Estimate for the part that was solved anew: tiny when a piece has come off, 0 when not positive definite.
    double reciprocal_condition() const { return rcond_; }
    std::size_t bytes() const;

    /// Dense route: also holds vertices that were appended to `held` since construction, by one solve per unknown with
    /// the present factor.
    /// @pre the vertices are retained
    void hold_appended();

    struct Solution {
        Eigen::MatrixXd kept; ///< displacement of the retained vertices
        /// Low-rank route: forces that give `kept` in the given state, without `elsewhere`.
        Eigen::MatrixXd kept_forces;
        Eigen::MatrixXd added; ///< displacement of CutChange::added
        Eigen::MatrixXd held_forces; ///< force of the hook on each held retained vertex, three rows per vertex
    };
    /// @param load_kept forces on the retained vertices
    /// @param load_added forces on the added vertices
    /// @param hook_displacement three rows per hook
    /// @param elsewhere displacements of the retained vertices by loads on dropped vertices (LoadOnDropped::response);
    /// empty: none
    Solution solve(const Eigen::MatrixXd& load_kept, const Eigen::MatrixXd& load_added,
        const Eigen::MatrixXd& hook_displacement, const Eigen::MatrixXd& elsewhere = {}) const;

private:
    Eigen::MatrixXd low_rank_kept(const Eigen::MatrixXd& load, const Eigen::MatrixXd& given,
        const Eigen::MatrixXd& elsewhere, Eigen::MatrixXd& forces, Eigen::MatrixXd& kept_forces) const;
    Eigen::MatrixXd dense_kept(
        const Eigen::MatrixXd& load, const Eigen::MatrixXd& given, Eigen::MatrixXd& forces) const;
    void prepare_low_rank();
    void prepare_dense();

    const OnlineStiffness* K_;
    const CondensedState* state_;
    const Eigen::MatrixXd* stiffness_;
    const CutChange* change_;
    const HookCompliance* hooks_; ///< null with the dense route
    std::vector<std::int32_t> hook_rows_; ///< rows of the held retained vertices among the retained
    const std::vector<HeldVertex>* held_;
    double rcond_ = 1.0;
    std::optional<DenseLu> capacitance_; ///< I + C dK on the changed unknowns
    std::vector<std::int32_t> free_rows_; ///< dense route: rows of retained vertices that no hook holds
    Eigen::MatrixXd factor_; ///< dense route: Cholesky factor on free_rows_
    std::size_t held_in_factor_ = 0; ///< number of held vertices that the factor includes
    std::vector<std::int32_t> late_; ///< dense route: rows, among the free, of vertices held since the factorisation
    Eigen::MatrixXd late_columns_; ///< displacements of the free rows by unit forces on late_
    Eigen::MatrixXd late_factor_; ///< Cholesky factor of the rows late_ of late_columns_
    Eigen::MatrixXd held_stiffness_; ///< dense route: rows of the changed stiffness of the held vertices, all columns
};

} // namespace retractor::fem
