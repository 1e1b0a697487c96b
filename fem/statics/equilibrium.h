#pragma once
// Static equilibrium of an elastic body under prescribed displacements, by bounded load steps and Newton's method.
// Units mm, N, MPa.
//
// Load steps. A step starts from a linearised solve with a fresh factor of the projected stiffness, which spreads the
// new motion over the body. Where the energy grows much more than this solve predicts (turning bone comes out
// stretched), half of the motion is made, and so on.
//
// Newton's method. Directions come from truncated conjugate gradients with the true stiffness; the factor of the step
// is the preconditioner, and an Armijo line search on the energy shortens the direction. At a direction of negative
// curvature (Steihaug 1983), the negative eigenvalues of the element stiffness are raised by a growing share until no
// such direction is left. The true stiffness alone ends in tiny steps, since nearly incompressible tissue under tension
// is full of negative curvature; the projected stiffness alone is too stiff and converges slowly. Hyperelastic bodies
// factor the true stiffness at each Newton step where the whole matrix is positive definite, else the stiffness with
// the smallest sufficient share. In a large body without loads, where only a few nodes have large residual forces,
// these nodes are brought to rest before each step (local_relaxation.h).
//
// A single step (EquilibriumOptions::load_steps is 1) of less than half a millimetre from near an equilibrium takes the
// factor at hand as a preconditioner, and a fresh one only where this converges slowly.
//
// Work. Without loads, an intermediate state takes at most four Newton iterations and the last state at most
// max_newton_iterations.
//
// Loads (ElasticBody::set_loads) rise in the same steps. Each intermediate state is then brought to rest, since the
// loads may have no equilibrium. Without an equilibrium the step is halved, down to 1/64. The result then says above
// which share of the loads no equilibrium was found, and whether the loads or the prescribed motion are the cause. The
// part of follower loads that has no energy is renewed at each Newton step.
//
// Contact (ElasticBody::set_contact). Surfaces are paired before each step and after each equilibrium, until the pairs
// no longer change. After six rounds, points that have a face keep this face: on rough surfaces two sets of pairs can
// lead to each other's equilibrium without end. Linear bodies with contact take load steps too. Contact forces do not
// separate prescribed nodes. Where these meet each other or a fixed surface, the motion ends without convergence, and
// the message names the share of the motion.
//
// Blades (ElasticBody::set_blades) move before the tissue follows. A step is therefore linearised with the places that
// the blades will touch. Friction of the blades is renewed between iterations that ended (settle_blades()); fading is
// that of the tissue at rest.

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/elastic_body.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace retractor::fem {

struct EquilibriumOptions {
    int load_steps = 4; ///< least number of load steps; no node moves more than 3 mm in one step
    int max_newton_iterations = 40; ///< at full load; intermediate states take a few iterations
    double tolerance = 1e-5; ///< largest residual force of a free node over the largest force or load of any node
    /// With blades: an iteration also ends where its last step lowers the energy by at most this share, and changes the
    /// energy between blades and tissue by at most the square root of it, at a residual of at most 0.05 or fifty
    /// tolerances. So does the search for the pairs of a contact, where other pairs change no more. 0: only the
    /// residual counts. Forces of prescribed nodes are then known to about the square root: an error of the state with
    /// the energy e changes them by at most sqrt(e / energy) in a linear body (Cauchy's and Schwarz's inequality).
    /// Slivers at the tip of a cut, and tissue that a blade crushes, keep a residual over many steps that change no
    /// force of a blade.
    double energy_tolerance = 0.0;
    double load_at_start = 0.0; ///< share of the body's loads that acts on the start state
    /// Least number of nodes of a body without loads in which nodes with large residual forces are brought to rest
    /// first: in a smaller body a step of Newton's method costs no more.
    std::size_t relax_locally_from = 20'000;
};

enum class EquilibriumStatus { converged, not_converged, cancelled };

struct [[nodiscard]] Equilibrium {
    EquilibriumStatus status = EquilibriumStatus::converged;
    Eigen::VectorXd displacement; ///< three per node; finite for every status
    /// Internal forces less the loads at this state; on prescribed unknowns, the forces of their supports.
    Eigen::VectorXd forces;
    double load = 0.0; ///< share of the prescribed displacement and of the loads that was reached
    /// Not converged because no equilibrium was found under loads; prescribed nodes have met nothing.
    bool none_found = false;
    /// Set when the solve under loads did not converge: starting from the last state at rest, the loads of the failed
    /// step found an equilibrium while the prescribed nodes stood still. The motion of these nodes is then the cause.
    bool loads_rest_alone = false;
    std::string message {}; ///< why the solution did not converge, where more is known than the residual
    double residual = 0.0; ///< as EquilibriumOptions::tolerance
    int newton_iterations = 0, factorisations = 0, solver_iterations = 0;
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

/// Finds equilibria. The ordering is kept from call to call while the same unknowns are prescribed.
class EquilibriumSolver {
public:
    /// Moves the body from `start` until the prescribed unknowns have their `target`. A linear body without contact
    /// and blades takes one linear solve.
    /// @param prescribed one flag per unknown, 1 = prescribed
    /// @throws SolverError when the stiffness is not positive definite, InputError when the energy of `start` is not
    /// finite
    Equilibrium solve(ElasticBody& body, const std::vector<std::uint8_t>& prescribed, const Eigen::VectorXd& target,
        const Eigen::VectorXd& start, const EquilibriumOptions& options, const Job& job);

    /// The stiffness of the body against small motions of its prescribed unknowns, linearised at a state that solve()
    /// found: the free unknowns follow. Takes the pattern and the ordering of that solve, and leaves the factor of the
    /// stiffness at this state, from which the next solve begins.
    /// @param motions one motion per column, three entries per node; zero at free unknowns
    /// @return force of each motion (virtual work) per unit of each motion, symmetric
    /// @pre solve() was called, and its contact has not been renewed since
    /// @throws SolverError when the stiffness is not positive definite with all negative eigenvalues raised
    Eigen::MatrixXd response(ElasticBody& body, const Eigen::VectorXd& displacement, const Eigen::MatrixXd& motions);

private:
    std::optional<ConstrainedSolver> solver_;
    std::size_t pattern_ = 0; ///< ElasticBody::patterns_made() of the pattern that solver_ has analysed
    bool assembled_ = false;
};

} // namespace retractor::fem
