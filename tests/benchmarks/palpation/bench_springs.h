#pragma once
// Mass-spring tissue under a finger: time per tick, frames drawn per second, its error against finite elements, and the
// curves a rheometer would draw of it.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct SpringBenchOptions {
    bool curves = false; ///< frames per second over `seconds` of 20 x 20, 25 x 25 and 30 x 30 particles
    double seconds = 80.0; ///< of each
    std::string out; ///< folder for bench_springs.json, curves and pictures; empty: none
};

ui::cli::Outcome bench_springs(const SpringBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
