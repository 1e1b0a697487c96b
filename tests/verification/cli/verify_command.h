#pragma once
// The command retractor-verify with its options.

#include "ui/cli/framework/command.h"

namespace retractor::verification {

void add_verification(ui::cli::Commands& commands);

} // namespace retractor::verification
