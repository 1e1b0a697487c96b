#pragma once
// The commands of `retractor`. Every command registers itself in its own source file.

#include "ui/cli/framework/command.h"

namespace retractor::ui::cli {

void add_phantom_command(Commands& commands);
void add_import_command(Commands& commands);
void add_approach_commands(Commands& commands);
void add_hooks_command(Commands& commands);
void add_tension_command(Commands& commands);
void add_mesh_command(Commands& commands);
void add_cut_command(Commands& commands);
void add_plan_command(Commands& commands);
void add_render_command(Commands& commands);
void add_demo_command(Commands& commands);
void add_doctor_command(Commands& commands);

} // namespace retractor::ui::cli
