#pragma once
// Speed of a wound that follows the knife and the hooks: a freehand step, a whole stroke, attaching and dragging
// hooks. Each is compared with a full rebuild that runs in a process of its own on the same meshes.

#include "ui/cli/framework/command.h"

#include <string>
#include <vector>

namespace retractor::benchmarks {

struct OpenBenchOptions {
    std::vector<std::string> sizes { "67k", "96k", "175k", "thorax" };
    int repeats = 5; ///< strokes per box, each undone again
    std::string out; ///< folder for bench_open.json or bench_drag.json; empty: no file
    /// for the child process: folder for the fields of a full rebuild of the only size; empty: parent process
    std::string baseline_to;
};

/// Measures freehand steps and whole strokes: `retractor-bench open`.
ui::cli::Outcome bench_open(const OpenBenchOptions& options, const Job& job);

/// Measures dragging with 4 and 8 hooks alone, and in the thorax as in the window: `retractor-bench drag`.
ui::cli::Outcome bench_drag(const OpenBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
