#pragma once
// `retractor train`: elasticity trials and their statistics.

#include "ui/cli/framework/command.h"

namespace retractor::ui::cli {

void add_train_command(Commands& commands);

} // namespace retractor::ui::cli
