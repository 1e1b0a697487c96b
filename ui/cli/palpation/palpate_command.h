#pragma once

#include "ui/cli/framework/command.h"

namespace retractor::ui::cli {

void add_palpate_command(Commands& commands);
/// From a patient's case to a scene for it.
void add_palpable_command(Commands& commands);
/// The other computer's side of `palpate --device udp:...`.
void add_relay_command(Commands& commands);

} // namespace retractor::ui::cli
