#pragma once
// Gape of a cut under tension: springs and linear finite elements compared with the closed form, and pictures of a
// wound on a patient.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

struct GapeBenchOptions {
    bool quick = false; ///< one resolution and no freehand stroke, in a second or two
    std::string out; ///< folder for bench_gape.json and the pictures; empty: none
};

/// Measures a cut of 80 mm through a large sheet (closed form 5) under 2, 4 and 6 % uniaxial stress on three meshes.
/// Springs are also measured with a limited reach, and while the blade moves in steps of 5 mm.
ui::cli::Outcome bench_gape(const GapeBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
