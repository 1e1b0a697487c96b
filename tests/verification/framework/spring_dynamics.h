#pragma once
// Motion of a spring network in time, by symplectic Euler steps with implicit damping: v' = (v + dt f(u) / m) / (1 +
// c dt), u' = u + dt v'. Units mm, N, tonne, s.
//
// The steps are explicit and so conditionally stable: with damping c >= 0 the linear oscillator of frequency w stays
// bounded for dt^2 w^2 <= 4 + 2 c dt, hence for dt <= 2 / w with any c. The limit is computed from the largest
// eigenvalue of M^-1/2 K M^-1/2, where K is the tangent at the network's positions. K omits the weakening of
// compressed springs, which only lowers frequencies. Lanczos' method with its residual added gives an estimate: an
// eigenvalue lies within the residual, but a higher one may be missed when the start vector has hardly any part in
// its motion.
//
// A wound opens within a few periods of its slowest motion, while the stiffest spring limits the step. relax()
// (spring_relaxation.h) is therefore the way to the equilibrium.

#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::verification {

struct StabilityBound {
    double largest_frequency = 0.0; ///< Lanczos' value plus its residual, an estimate, rad/s
    double stable_step = 0.0; ///< 2 / largest_frequency, s
};

class SpringDynamics {
public:
    /// Starts at rest at the network's present positions. The network does not change until store().
    /// @param damping of the velocity, 1/s.
    /// @throws InputError on a density that is not positive, or damping that is negative or not finite.
    SpringDynamics(const fem::SpringNetwork& network, std::span<const fem::Material> material_of_label, double damping);

    /// The bound at the present positions. step() computes the bound again when a vertex has moved by more than
    /// kRecheck since the last computation.
    const StabilityBound& bound() const { return bound_; }

    /// Makes one step of dt seconds.
    /// @throws InputError naming dt and the bound when dt is not positive or beyond the bound; nothing has moved
    /// then.
    void step(double dt);

    double kinetic_energy() const; ///< N mm
    double potential_energy() const; ///< N mm
    const Eigen::VectorXd& displacement() const { return u_; } ///< displacement of the vertices patch().active(), mm
    const fem::SpringPatch& patch() const { return patch_; }
    /// Sets displacement (mm) and velocity (mm/s), for tests and to continue a motion.
    /// @throws InputError on a wrong size or NaN.
    void set_state(Eigen::VectorXd displacement, Eigen::VectorXd velocity);
    void store(fem::SpringNetwork& network) const { patch_.store(u_, network); }

    /// Share of the shortest edge by which a vertex may move before the bound is computed again.
    static constexpr double kRecheck = 0.1;

private:
    void compute_bound();

    fem::SpringPatch patch_;
    std::vector<double> mass_; ///< mass per active vertex, tonne
    double damping_ = 0.0, shortest_ = 0.0;
    Eigen::VectorXd u_, v_, bound_at_;
    StabilityBound bound_;
};

} // namespace retractor::verification
