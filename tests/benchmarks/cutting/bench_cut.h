#pragma once
// Speed and quality of the knife: the boxes and the blade that all speed figures of the project share, and the
// subdivisions of elements beside the published comparison [Nakao and others 2006, doi 10.1007/s10916-006-9021-4,
// table 1].

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct CutBenchOptions {
    int repeats = 5; ///< strokes per row, each undone again; times are medians over the strokes
    bool largest = true; ///< includes the box of a million elements
    bool thorax = true; ///< includes the graded thorax
    std::string out; ///< folder for bench_cut.json and bench_cut.png; empty: no files
};

/// Cuts every body once in one stroke and once freehand in steps of 5 mm, with every subdivision.
ui::cli::Outcome bench_cut(const CutBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
