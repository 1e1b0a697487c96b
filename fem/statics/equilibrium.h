#pragma once
// Static equilibrium of an elastic body under prescribed displacements, by bounded load steps and Newton's method.
//
// Each load step starts from a linearised solve with a fresh factor of the projected stiffness, which spreads the new
// motion over the body; where the energy grows much more than that foretold (stiff bone that turns comes out
// stretched), half the motion is made, and so on. Then Newton by truncated conjugate gradients with the true stiffness,
// the step's factor as preconditioner and Armijo line search on the energy. Where a direction of negative curvature is
// met [Steihaug 1983], negative eigenvalues of the element stiffness are lifted by a growing share until there is none:
// the true stiffness alone ends in tiny steps (nearly incompressible tissue under tension is full of negative
// curvature), the projected one alone is too stiff and crawls.
// Hyperelastic bodies: the true stiffness is factorised at each step where the whole is positive definite, else the
// least lifted one.
// A body with loads (ElasticBody::set_loads) is given them in the same steps. There each state on the way is brought to
// rest, for the loads may have no equilibrium: then the step is halved, down to 1/64, and the result says above which
// share of the loads none was found, and whether it is for the loads or for what is prescribed. The part of follower
// loads that has no energy is renewed at each Newton step. Contact (ElasticBody::set_contact): surfaces are paired
// before each step and after each equilibrium, until the pairs stay as they are; after six rounds points that have a
// face keep it, for on rough surfaces two sets of pairs can lead to each other's equilibrium without end. Linear bodies
// take steps then too. What is prescribed is not held apart by forces: where it meets itself or a fixed surface the
// motion ends, not converged, and the message says at which share. Without loads, states on the way need four
// iterations at most, the last one max_newton_iterations at most: the work is bounded. Units mm, N, MPa.

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/elastic_body.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace retractor::fem {

struct EquilibriumOptions {
    int load_steps = 4; ///< at least as many
    double load_step_mm = 3.0; ///< and none that moves a node farther
    int max_newton_iterations = 40; ///< at full load; the states on the way take a few each
    double tolerance = 1e-5; ///< largest residual force of a free node over the largest force or load of any node
    double load_at_start = 0.0; ///< share of the body's loads that acts on the start state
};

enum class EquilibriumStatus { converged, not_converged, cancelled };

struct [[nodiscard]] Equilibrium {
    EquilibriumStatus status = EquilibriumStatus::converged;
    Eigen::VectorXd displacement; ///< three per node; finite whatever the status
    Eigen::VectorXd forces; ///< internal forces there less the loads: on prescribed unknowns, what holds them
    double load = 0.0; ///< share of the prescribed displacement and of the loads that was reached
    bool none_found = false; ///< not converged: under loads, for want of an equilibrium (what is held has met nothing)
    /// Under loads, not converged: from the last state at rest, the loads of the step that failed came to rest while
    /// what is prescribed stood still. It is its motion, then, that finds none.
    bool loads_rest_alone = false;
    std::string message {}; ///< why it is not converged, where there is more to say than the residual
    double residual = 0.0; ///< as in EquilibriumOptions::tolerance
    int newton_iterations = 0, factorisations = 0, solver_iterations = 0;
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

/// Keeps the ordering from one call to the next, while the same unknowns are prescribed.
class EquilibriumSolver {
public:
    /// Moves the body from `start` until `prescribed` unknowns stand at `target`. A linear body takes one linear solve.
    /// @param prescribed one per unknown, 1 = prescribed.
    /// @throws SolverError when the stiffness is not positive definite, InputError when the energy of `start` is not
    /// finite.
    Equilibrium solve(ElasticBody& body, const std::vector<std::uint8_t>& prescribed, const Eigen::VectorXd& target,
        const Eigen::VectorXd& start, const EquilibriumOptions& options, const Job& job);

private:
    std::optional<ConstrainedSolver> solver_;
    bool assembled_ = false;
};

} // namespace retractor::fem
