#pragma once
// How fast a wound follows the knife and the hooks: a freehand step, a whole stroke, attaching and dragging hooks, each
// beside a full rebuild that runs in its own process on the same meshes.

#include "ui/cli/framework/command.h"

#include <string>
#include <vector>

namespace retractor::benchmarks {

struct OpenBenchOptions {
    std::vector<std::string> sizes { "67k", "96k", "175k", "thorax" };
    int repeats = 5; ///< strokes per box, each undone again
    std::string out; ///< folder for bench_open.json or bench_drag.json; empty: no file
    std::string
        baseline_to; ///< the child's part: rebuild for the only size, fields into this folder; empty: the parent
};

/// Freehand steps and whole strokes: `retractor-bench open`.
ui::cli::Outcome bench_open(const OpenBenchOptions& options, const Job& job);

/// Dragging with 4 and 8 hooks alone, and in the thorax as a window does: `retractor-bench drag`.
ui::cli::Outcome bench_drag(const OpenBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
