#include "haptics/condensed/sneddon.h"

#include <cmath>

namespace retractor::haptics {

double sneddon_depth(double sphere_radius, double a)
{
    return 0.5 * a * std::log((sphere_radius + a) / (sphere_radius - a));
}

double sneddon_force(double depth, double sphere_radius, double youngs_modulus, double poissons_ratio)
{
    const double R = sphere_radius;
    double low = 0.0, high = R * (1.0 - 1e-12);
    constexpr int kHalvings = 100;
    for (int i = 0; i < kHalvings; ++i) {
        const double a = 0.5 * (low + high);
        (sneddon_depth(R, a) < depth ? low : high) = a;
    }
    const double a = 0.5 * (low + high);
    return 0.5 * youngs_modulus / (1.0 - poissons_ratio * poissons_ratio)
        * ((R * R + a * a) * std::log((R + a) / (R - a)) - 2.0 * a * R);
}

} // namespace retractor::haptics
