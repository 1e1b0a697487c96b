#pragma once
// The commands of retractor-bench, with their options: cut, open, drag, gape, springs, spheres, palpate, servo.

#include "ui/cli/framework/command.h"

namespace retractor::cli {

void add_benchmarks(Commands& commands);

} // namespace retractor::cli
