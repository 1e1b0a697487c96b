#pragma once
// Endurance of the knife: many short cuts in one body, then undo of all cuts, then redo of all cuts.

#include "ui/cli/framework/command.h"

#include <cstdint>

namespace retractor::benchmarks {

struct SoakOptions {
    int cuts = 1000;
    std::string body = "thorax"; ///< "thorax", or a box: "12k", "96k", "1M"
    std::uint64_t seed = 1; ///< seed of the random places
};

/// Cuts all over the skin. A cut is about two edges long and more than one edge deep; later cuts cross earlier ones
/// where no room is left. Time and memory are reported every tenth of the run. The exit code is 1 when undo or redo
/// is not exact, or when a value grows: the time of the same cut, resident memory per living element, or the journal
/// per cut or per crossed element.
ui::cli::Outcome soak_cut(const SoakOptions& options, const Job& job);

} // namespace retractor::benchmarks
