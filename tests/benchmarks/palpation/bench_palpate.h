#pragma once
// What a palpation costs and how right it is.

#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>

namespace retractor::benchmarks {

struct PalpateBenchOptions {
    std::string out; ///< folder for bench_palpate.json and the plot; empty: none
    int ticks = 50000; ///< of each timing
    double seconds = 3.0; ///< of each run at 1 kHz
    bool largest = true; ///< 20,000 surface vertices too
};

ui::cli::Outcome bench_palpate(const PalpateBenchOptions& options, const Job& job);

/// A model's point in the plot: rows with "force_us_mean", "build_ms" and "rel_error_vs_reference" are drawn, one curve
/// per "model" and "element".
void write_palpation_plot(const std::filesystem::path& file, const ui::cli::Json& rows, const Job& job);

} // namespace retractor::benchmarks
