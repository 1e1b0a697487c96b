#pragma once
// Sphere-filled organs under fingers: frames per second by spheres, layers and fingers, change of volume, and error
// of the force against finite elements.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct SphereBenchOptions {
    std::string surface; ///< OBJ file of a liver in units of `unit_mm`; empty: the phantom's liver
    double unit_mm = 1.0;
    std::string out; ///< folder for bench_spheres.json and the pictures; empty: none
};

ui::cli::Outcome bench_spheres(const SphereBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
