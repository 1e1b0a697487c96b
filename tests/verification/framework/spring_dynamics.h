#pragma once
// Motion of a spring network in time, by symplectic Euler steps with implicit damping:
// v' = (v + dt f(u) / m) / (1 + c dt), u' = u + dt v'. Units mm, N, tonne, s.
//
// Explicit, so conditionally stable: with damping c >= 0 the linear oscillator of frequency w stays bounded for
// dt^2 w^2 <= 4 + 2 c dt, hence for dt <= 2 / w whatever c is. The limit is computed from the network: the largest
// eigenvalue of M^-1/2 K M^-1/2 by Lanczos' method with its residual added, which is an estimate (an eigenvalue lies
// within the residual, but a higher one may be missed, where the first vector hardly has a share in its motion), or
// Gershgorin's discs, which are certain, where these are lower. K is the tangent where the network stands, without the
// weakening of compressed springs, which only lowers frequencies. A wound opens within a few periods of its slowest
// motion, while the stiffest spring sets the step: fem::relax() (fem/springs/spring_relaxation.h) is the way to the
// equilibrium.

#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::verification {

struct StabilityBound {
    double largest_frequency
        = 0.0; ///< rad/s: Lanczos' value and its residual, an estimate; or the bound below, if less
    double gershgorin_frequency = 0.0; ///< rad/s: a certain upper bound, not sharp
    double stable_step = 0.0; ///< s: 2 / largest_frequency; 2 / gershgorin_frequency is certain
};

class SpringDynamics {
public:
    /// Starts from rest, where the network stands. The network is not changed until store().
    /// @param damping per second, of the velocity.
    /// @throws InputError on a density that is not positive, damping that is negative or not finite.
    SpringDynamics(const fem::SpringNetwork& network, std::span<const fem::Material> material_of_label, double damping);

    /// At the present positions; step() recomputes it when the network has stretched by more than kRecheck since.
    const StabilityBound& bound() const { return bound_; }

    /// @throws InputError when dt is not positive or beyond the bound, naming both; nothing has moved then.
    void step(double dt);

    double kinetic_energy() const; ///< N mm
    double potential_energy() const; ///< N mm
    const Eigen::VectorXd& displacement() const { return u_; } ///< of patch().active()
    const fem::SpringPatch& patch() const { return patch_; }
    /// Moves and pushes: for tests and for taking up a motion. @throws InputError on a wrong size or NaN.
    void set_state(Eigen::VectorXd displacement, Eigen::VectorXd velocity);
    void store(fem::SpringNetwork& network) const { patch_.store(u_, network); }

    /// Share of the shortest edge by which a vertex may move before the bound is computed anew.
    static constexpr double kRecheck = 0.1;

private:
    void compute_bound();

    fem::SpringPatch patch_;
    std::vector<double> mass_; ///< per active vertex, tonne
    double damping_ = 0.0, shortest_ = 0.0;
    Eigen::VectorXd u_, v_, bound_at_;
    StabilityBound bound_;
};

} // namespace retractor::verification
