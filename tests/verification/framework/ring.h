#pragma once
// Thick-walled tubes under inner pressure in plane strain at finite strain: the radial equation in one dimension. Units
// mm, MPa.

#include <functional>

namespace retractor::verification {

struct RingStretch {
    double hoop = 1.0, radial = 1.0;
};
/// First Piola.
struct RingStress {
    double hoop = 0.0, radial = 0.0;
};

struct PressedRing {
    double inner = 0.0, outer = 0.0; ///< radii at rest, mm
    /// Of the tube's law, whose principal directions are those of the tube. The radial stress rises with the radial
    /// stretch.
    std::function<RingStress(const RingStretch&)> stress;
};

/// How far the inner wall is stretched under the pressure, which follows it: with P the first Piola stress,
/// dP_r/dR = (P_hoop - P_r) / R and dr/dR the radial stretch, by Runge and Kutta; the outer wall is free.
/// @param low, high stretches that it lies between.
double bore_stretch(const PressedRing& ring, double pressure, double low, double high);

} // namespace retractor::verification
