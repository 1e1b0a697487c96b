#pragma once
// The options of retractor-verify, and what it does with them.

#include "ui/cli/framework/command.h"

namespace retractor::cli {

void add_verification(Commands& commands);

} // namespace retractor::cli
