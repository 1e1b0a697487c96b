#pragma once
// How fast and how well the knife cuts: the boxes and the blade that every speed figure of the project shares, and the
// source's comparison of subdivisions beside ours.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct CutBenchOptions {
    int repeats = 5; ///< strokes per row, each undone again; times are medians over them
    bool largest = true; ///< with the box of a million elements
    bool thorax = true; ///< with the graded thorax
    std::string out; ///< folder for bench_cut.json and bench_cut.png; empty: no files
};

/// Every body once in one stroke and once freehand in steps of 5 mm; every subdivision.
ui::cli::Outcome bench_cut(const CutBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
