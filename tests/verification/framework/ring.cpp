#include "tests/verification/framework/ring.h"

#include <cmath>

namespace retractor::verification {

namespace {

    /// The radial stretch with this radial stress, by Newton's method from a stretch that keeps the volume.
    RingStretch ring_under(const PressedRing& ring, double hoop, double stress)
    {
        double radial = 1.0 / hoop;
        constexpr int kSteps = 30;
        for (int i = 0; i < kSteps; ++i) {
            constexpr double kShare = 1e-6; // relative to the stretch
            const double h = kShare * radial, f = ring.stress({ hoop, radial }).radial - stress;
            const double step
                = f * 2.0 * h / (ring.stress({ hoop, radial + h }).radial - ring.stress({ hoop, radial - h }).radial);
            radial -= step;
            constexpr double kRoundOff = 1e-14;
            if (std::abs(step) <= kRoundOff * radial)
                break;
        }
        return { hoop, radial };
    }

    /// Radial stress on the outer wall when the inner wall is stretched by `bore` under the pressure.
    double outer_stress(const PressedRing& ring, double bore, double pressure)
    {
        struct Radius {
            double r, stress;
        };
        const auto slope = [&](double R, const Radius& at) -> Radius {
            const RingStretch stretch = ring_under(ring, at.r / R, at.stress);
            return { stretch.radial, (ring.stress(stretch).hoop - at.stress) / R };
        };
        const auto step = [](const Radius& at, const Radius& k, double h) -> Radius {
            return { at.r + h * k.r, at.stress + h * k.stress };
        };
        constexpr int kSteps = 64;
        const double h = (ring.outer - ring.inner) / kSteps;
        Radius at { bore * ring.inner, -pressure * bore }; // the pressure acts on the stretched wall
        for (int i = 0; i < kSteps; ++i) {
            const double R = ring.inner + i * h;
            const Radius k1 = slope(R, at), k2 = slope(R + 0.5 * h, step(at, k1, 0.5 * h)),
                         k3 = slope(R + 0.5 * h, step(at, k2, 0.5 * h)), k4 = slope(R + h, step(at, k3, h));
            at.r += h / 6.0 * (k1.r + 2.0 * k2.r + 2.0 * k3.r + k4.r);
            at.stress += h / 6.0 * (k1.stress + 2.0 * k2.stress + 2.0 * k3.stress + k4.stress);
        }
        return at.stress;
    }

} // namespace

double bore_stretch(const PressedRing& ring, double pressure, double low, double high)
{
    constexpr int kHalvings = 40;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        // at too small a stretch the outer wall is pushed out
        (outer_stress(ring, middle, pressure) < 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace retractor::verification
