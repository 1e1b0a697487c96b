#pragma once
// Sphere-filled organs under fingers: spheres, layers and fingers against frames per second, volume kept, error of the
// force against finite elements.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct SphereBenchOptions {
    std::string surface; ///< a liver as an OBJ file instead of the phantom's; its unit is `unit_mm`
    double unit_mm = 1.0;
    std::string out; ///< folder for bench_spheres.json and the pictures; empty: none
};

ui::cli::Outcome bench_spheres(const SphereBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
