#pragma once
// The commands of retractor-bench with their options: cut, open, drag, gape, springs, spheres, palpate, servo,
// segment.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

void add_benchmarks(ui::cli::Commands& commands);

} // namespace retractor::benchmarks
