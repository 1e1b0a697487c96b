#pragma once
// How regular the servo is: two simulated hands on tissue at 1 kHz while a wound is cut and a body's stiffness edited,
// beside an empty loop under the same load.

#include "ui/cli/framework/command.h"

#include <cstdint>
#include <string>

namespace retractor::benchmarks {

struct ServoBenchOptions {
    std::string model = "fem"; ///< the beating aorta, whose elasticity is edited; or "springs", the sheet
    double seconds = 30.0; ///< of the servo, and of the empty loop
    std::uint64_t soak = 0; ///< instead: so many ticks, without load
    bool load = true;
    std::string out; ///< folder for bench_servo.json and servo.png
};

/// Exit code 1 when a force was not finite, a tick asked for memory it did not give back, or the fault latch let go for
/// another reason than a late tick.
ui::cli::Outcome bench_servo(const ServoBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
