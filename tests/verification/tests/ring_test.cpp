#include "tests/verification/framework/ring.h"

#include "fem/material/hyperelasticity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::verification {
namespace ring_test {

    constexpr double kInner = 10.0, kOuter = 12.0; // mm
    constexpr double kMu = 0.03; // MPa
    constexpr double kFirm = 1e4 * kMu; // bulk modulus, MPa

    /// Principal first Piola stresses by the law of the elements, with fibres in the wall.
    RingStress stress_of(const fem::Hyperelastic& law, double angle_deg, const RingStretch& ring)
    {
        const double angle = angle_deg * std::numbers::pi / 180.0;
        const fem::FibreDirections fibres { Vec3(0.0, std::cos(angle), std::sin(angle)),
            Vec3(0.0, std::cos(angle), -std::sin(angle)) };
        const Mat3 F = Vec3(ring.radial, ring.hoop, 1.0).asDiagonal(),
                   P = fem::evaluate_point(law, fibres, F, false).stress;
        return { P(1, 1), P(0, 0) };
    }

    /// Derivative by l of the energy at constant volume: mu/2 (l^2 + l^-2 - 2) + k1/k2 (exp(k2 e^2) - 1), two
    /// families.
    double slope(const fem::HolzapfelGasserOgden& law, double angle_deg, double l)
    {
        const double round = std::pow(std::cos(angle_deg * std::numbers::pi / 180.0), 2);
        const double along = 1.0 - 3.0 * law.dispersion;
        const double dI1 = 2.0 * l - 2.0 / (l * l * l), dI4 = 2.0 * l * round;
        const double e = law.dispersion * (l * l + 1.0 / (l * l) - 2.0) + along * round * (l * l - 1.0);
        return 0.5 * law.mu * dI1 + 2.0 * law.k1 * e * std::exp(law.k2 * e * e) * (law.dispersion * dI1 + along * dI4);
    }

    /// Pressure of an incompressible tube: the integral of slope / (l^2 - 1) over the stretches from the outer wall
    /// to the bore [Holzapfel, Gasser, Ogden 2000, doi 10.1023/A:1010835316564], by Simpson's rule.
    double pressure(const fem::HolzapfelGasserOgden& law, double angle_deg, double bore)
    {
        const double outer = std::sqrt(1.0 + (bore * bore - 1.0) * std::pow(kInner / kOuter, 2));
        constexpr int kSteps = 200;
        const double h = (bore - outer) / kSteps;
        double sum = 0.0;
        for (int i = 0; i <= kSteps; ++i) {
            const double l = outer + i * h, weight = i == 0 || i == kSteps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
            sum += weight * slope(law, angle_deg, l) / (l * l - 1.0);
        }
        return sum * h / 3.0;
    }

    TEST(Ring, IsStretchedAsATubeThatKeepsItsVolume)
    {
        constexpr double kTol = 4e-4; // relative to the bore's displacement: the effect of this bulk modulus
        for (const double k1 : { 0.0, 0.06 })
            for (const double angle_deg : { 0.0, 40.0 })
                for (const double bore : { 1.05, 1.2 }) {
                    const fem::HolzapfelGasserOgden law {
                        .mu = kMu, .k1 = k1, .k2 = 4.0, .dispersion = 0.1, .bulk = kFirm
                    };
                    const double found = bore_stretch(
                        { kInner, kOuter, [&](const RingStretch& ring) { return stress_of(law, angle_deg, ring); } },
                        pressure(law, angle_deg, bore), 1.0, 1.3);
                    EXPECT_NEAR(found, bore, kTol * (bore - 1.0)) << k1 << " " << angle_deg << " " << bore;
                }
    }

} // namespace ring_test
} // namespace retractor::verification
