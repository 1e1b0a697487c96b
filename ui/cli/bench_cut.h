#pragma once
// How fast and how well the knife cuts: the boxes and the blade that every speed figure of the project shares.

#include "ui/cli/command.h"

namespace retractor::cli {

struct CutBenchOptions {
    int repeats = 7; ///< strokes per row, each undone again; times are medians over them
    bool largest = true; ///< with the box of a million elements
};

/// Boxes of Kuhn tetrahedra with 4 mm edges; a straight blade of 60 x 12 mm, heading 7.3 degrees off the grid, tilted
/// by 10 degrees, its middle off the box's middle. Once in one stroke, once freehand in steps of 5 mm.
Outcome bench_cut(const CutBenchOptions& options, const Job& job);

} // namespace retractor::cli
