#pragma once
// Static equilibrium of an elastic body under prescribed displacements: Newton with the true tangent by truncated
// conjugate gradients [Steihaug 1983], whose preconditioner is the factor of an earlier projected tangent, Armijo line
// search on the energy, load steps that are halved where they fail. (Newton with the projected tangent alone
// crawls past saddles: 150 steps where this takes 17.) Each load step starts from a linearised solve, which spreads the
// new motion of the hooks over the body; otherwise it would all sit in, and invert, the first layer of elements.
// Units mm, N, MPa.

#include "fem/constrained_solver.h"
#include "fem/elastic_body.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace retractor {

struct EquilibriumOptions {
    int load_steps = 4;
    int max_newton_iterations = 30; ///< per load step
    double tolerance = 1e-5; ///< largest residual force of a free node over the largest internal force of any node
};

enum class EquilibriumStatus { converged, not_converged, cancelled };

struct [[nodiscard]] Equilibrium {
    EquilibriumStatus status = EquilibriumStatus::converged;
    Eigen::VectorXd displacement; ///< three per node; finite whatever the status
    Eigen::VectorXd forces; ///< internal forces there
    double load = 0.0; ///< share of the prescribed displacement that was reached
    double residual = 0.0; ///< as in EquilibriumOptions::tolerance
    int newton_iterations = 0, factorisations = 0, solver_iterations = 0;
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

/// Keeps the ordering and the factor from one call to the next; both are renewed only when they must be.
class EquilibriumSolver {
public:
    /// Moves the body from `start` until `prescribed` unknowns stand at `target`. A linear body takes one linear solve.
    /// @param prescribed one per unknown, 1 = prescribed.
    /// @throws SolverError when the stiffness is not positive definite.
    Equilibrium solve(ElasticBody& body, const std::vector<std::uint8_t>& prescribed, const Eigen::VectorXd& target,
        const Eigen::VectorXd& start, const EquilibriumOptions& options, const Job& job);

private:
    std::optional<ConstrainedSolver> solver_;
    bool assembled_ = false;
};

} // namespace retractor
