#pragma once
// The tissue of a problem, linearised at one state of the body: its stiffness there, factored once for all motions and
// forces that are asked. Units mm, N.

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/contact.h"
#include "fem/model/elastic_body.h"
#include "fem/statics/elastic_problem.h"

#include <Eigen/Core>

#include <optional>

namespace retractor::fem {

/// Response of the tissue to its hooks: the linearisation at one state of the body.
struct HookResponse {
    Eigen::MatrixXd stiffness; ///< forces on the hooks per mm of hook displacement: 3 hooks x 3 hooks, N/mm, symmetric
    Eigen::MatrixXd displacement; ///< displacement of the body per mm of hook displacement: 3 nodes x 3 hooks
    /// The part of the hook forces that balances the loads of the body (tension that a cut released, pressure), N,
    /// three per hook. Tissue that is stiffer everywhere leaves this part unchanged. Empty without loads.
    Eigen::VectorXd of_loads {};
};

/// The tissue at one state, with its stiffness factored.
class TissueLinearisation {
public:
    /// Factors the stiffness at a state, with the nodes of supports and hooks held. Surfaces that touch at this
    /// state resist; surfaces that would touch later do not. Where the stiffness is not positive definite, the
    /// smallest sufficient lift of its negative eigenvalues is taken (ElasticBody::stiffness()).
    /// @param displacement n x 3, mm, a possible state of the body
    /// @throws InputError and SolverError as Opening does
    TissueLinearisation(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
        const std::optional<ContactOptions>& contact = {});
    TissueLinearisation(const TissueLinearisation&) = delete;
    TissueLinearisation& operator=(const TissueLinearisation&) = delete;

    /// The response to motions of the held nodes.
    /// @param motions one motion per column, three entries per node; zero at nodes that are not held
    HookResponse response(const Eigen::MatrixXd& motions);
    /// The displacement of the free nodes under forces, mm; zero at held nodes.
    /// @param forces N, three entries per node, one case per column
    Eigen::MatrixXd solve(const Eigen::MatrixXd& forces) { return solver_->solve_all(forces); }
    /// The forces that belong to a small displacement, N.
    Eigen::MatrixXd forces_of(const Eigen::MatrixXd& displacement) const;

    const Prescribed& held() const { return held_; }
    const Eigen::VectorXd& state() const { return state_; } ///< mm, three per node

private:
    Eigen::VectorXd state_;
    Prescribed held_;
    Eigen::VectorXd load_; ///< loads at the state, N; empty: none
    ElasticBody body_;
    std::optional<ConstrainedSolver> solver_;
};

} // namespace retractor::fem
