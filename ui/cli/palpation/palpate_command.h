#pragma once
// The commands `retractor palpate`, `retractor palpable` and `retractor relay`.

#include "ui/cli/framework/command.h"

namespace retractor::ui::cli {

void add_palpate_command(Commands& commands);
/// Makes a scene for `palpate` from a patient's case.
void add_palpable_command(Commands& commands);
/// Serves a device on another computer to `palpate --device udp:...`.
void add_relay_command(Commands& commands);

} // namespace retractor::ui::cli
