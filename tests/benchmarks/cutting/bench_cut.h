#pragma once
// Speed and quality of the knife: the boxes and the blade that all speed figures of the project share, and the
// increase of elements beside the published one [Nakao and others 2006, doi 10.1007/s10916-006-9021-4, table 1].

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct CutBenchOptions {
    int repeats = 5; ///< strokes per row, each undone again; times are medians over the strokes
    bool largest = true; ///< includes the box of a million elements
    bool thorax = true; ///< includes the graded thorax
    std::string out; ///< folder for bench_cut.json; empty: no file
};

/// Cuts every body once in one stroke and once freehand in steps of 5 mm.
ui::cli::Outcome bench_cut(const CutBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
