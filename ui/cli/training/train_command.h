#pragma once
// `retractor train`: elasticity trials and their statistics.

#include "ui/cli/framework/command.h"

namespace retractor::cli {

void add_train_command(Commands& commands);

} // namespace retractor::cli
