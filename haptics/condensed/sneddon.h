#pragma once
// The force of a rigid sphere on an elastic half-space, in closed form [Sneddon 1965]. Units mm, N, MPa.

namespace retractor::haptics {

/// How far a frictionless sphere of this radius is pressed in, mm, where the sphere touches within a circle of radius
/// a.
double sneddon_depth(double sphere_radius, double a);
/// The force at a depth, N.
double sneddon_force(double depth, double sphere_radius, double youngs_modulus, double poissons_ratio);

} // namespace retractor::haptics
