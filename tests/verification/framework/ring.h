#pragma once
// Thick-walled tubes under inner pressure in plane strain at finite strain: the radial equation in one dimension.
// Units mm, MPa.

#include <functional>

namespace retractor::verification {

struct RingStretch {
    double hoop = 1.0, radial = 1.0;
};
/// First Piola stress, MPa.
struct RingStress {
    double hoop = 0.0, radial = 0.0;
};

struct PressedRing {
    double inner = 0.0, outer = 0.0; ///< radii at rest, mm
    /// Stress of the tube's law, whose principal directions are those of the tube. The radial stress must rise with
    /// the radial stretch.
    std::function<RingStress(const RingStretch&)> stress;
};

/// Hoop stretch of the inner wall under a pressure that follows the wall; the outer wall is free. The equation is
/// dP_r/dR = (P_hoop - P_r) / R, with P the first Piola stress and dr/dR the radial stretch, integrated by Runge's
/// and Kutta's method.
/// @param low, high bounds of the stretch.
double bore_stretch(const PressedRing& ring, double pressure, double low, double high);

} // namespace retractor::verification
