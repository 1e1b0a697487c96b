#pragma once
// The force of a rigid sphere on an elastic half-space, in closed form (Sneddon 1965). Units mm, N, MPa.

namespace retractor::haptics {

/// Depth of a rigid frictionless sphere that touches within radius a, mm; exact (Sneddon 1965).
double sneddon_depth(double sphere_radius, double a);
/// Force of the sphere at a depth, N.
double sneddon_force(double depth, double sphere_radius, double youngs_modulus, double poissons_ratio);

} // namespace retractor::haptics
