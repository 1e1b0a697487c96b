#pragma once
// An aorta as the common vessel of several problems: a thick tube under inner pressure in plane strain. Units mm,
// MPa.

namespace retractor::verification {

constexpr double kVesselInner = 12.5, kVesselOuter = 14.5; // mm, radii
constexpr double kPulse = 16.0 / 3.0 * 1e-3; // MPa: 40 mmHg

/// Radial displacement of the vessel's inner wall at small strain, mm [Lame].
constexpr double vessel_displacement(double youngs_modulus, double poissons_ratio, double pressure)
{
    constexpr double inner = kVesselInner * kVesselInner, outer = kVesselOuter * kVesselOuter;
    return (1.0 + poissons_ratio) / youngs_modulus * pressure * inner / (outer - inner)
        * ((1.0 - 2.0 * poissons_ratio) * kVesselInner + outer / kVesselInner);
}

} // namespace retractor::verification
