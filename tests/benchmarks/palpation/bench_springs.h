#pragma once
// Mass-spring tissue under a finger: time per tick, frames drawn per second, error against finite elements, and the
// curves that a rheometer would measure.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct SpringBenchOptions {
    bool curves = false; ///< measures frames per second over `seconds` for 20 x 20, 25 x 25 and 30 x 30 particles
    double seconds = 80.0; ///< length of each run, s
    std::string out; ///< folder for bench_springs.json, curves and pictures; empty: none
};

ui::cli::Outcome bench_springs(const SpringBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
