#pragma once
// Cost and accuracy of a palpation.

#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>

namespace retractor::benchmarks {

struct PalpateBenchOptions {
    std::string out; ///< folder for bench_palpate.json and the plot; empty: none
    int ticks = 50000; ///< ticks of each timing
    double seconds = 3.0; ///< length of each run at 1 kHz, s
    bool largest = true; ///< includes the scene of 20,000 surface vertices
};

ui::cli::Outcome bench_palpate(const PalpateBenchOptions& options, const Job& job);

/// Plots error against time. Rows with "force_us_mean", "build_ms" and "rel_error_vs_reference" are drawn, with one
/// curve for each "model" and "element".
void write_palpation_plot(const std::filesystem::path& file, const ui::cli::Json& rows, const Job& job);

} // namespace retractor::benchmarks
