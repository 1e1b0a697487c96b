#pragma once
// The options of retractor-verify, and what it does with them.

#include "ui/cli/framework/command.h"

namespace retractor::verification {

void add_verification(ui::cli::Commands& commands);

} // namespace retractor::verification
