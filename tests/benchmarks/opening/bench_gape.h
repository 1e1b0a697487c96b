#pragma once
// How far a cut gapes under tension: springs and linear finite elements beside the closed form, and what it looks like
// on a patient.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct GapeBenchOptions {
    bool quick = false; ///< one resolution, no freehand stroke: a second or two
    std::string out; ///< folder for bench_gape.json and the pictures; empty: none
};

/// A cut of 80 mm through a large sheet (closed form 5), under 2, 4 and 6 % uniaxial stress, on three meshes; the
/// springs also locally and while the blade moves in steps of 5 mm.
ui::cli::Outcome bench_gape(const GapeBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
