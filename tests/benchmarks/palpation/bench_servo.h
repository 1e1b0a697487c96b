#pragma once
// Regularity of the servo: two simulated hands on tissue at 1 kHz while a wound is cut and a body's stiffness is
// edited, compared with an empty loop under the same load.

#include "ui/cli/framework/command.h"

#include <cstdint>
#include <string>

namespace retractor::benchmarks {

struct ServoBenchOptions {
    std::string model = "fem"; ///< "fem": the beating aorta, whose elasticity is edited; or "springs": the sheet
    double seconds = 30.0; ///< length of the run of the servo, and of the empty loop, s
    std::uint64_t soak = 0; ///< number of ticks to run without load instead; 0: a run of `seconds`
    bool load = true;
    std::string out; ///< folder for bench_servo.json and servo.png
};

/// Runs the benchmark. The exit code is 1 when a force was not finite, when a tick allocated memory without freeing
/// it, or when the servo latched a fault other than a late tick.
ui::cli::Outcome bench_servo(const ServoBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
