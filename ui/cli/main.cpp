#include "ui/cli/commands.h"
#include "ui/cli/framework/command.h"
#include "ui/cli/palpation/palpate_command.h"
#include "ui/cli/training/train_command.h"

namespace {

void add_commands(retractor::ui::cli::Commands& commands)
{
    using namespace retractor::cli;
    commands.app.require_subcommand(1);
    cli::add_demo_command(commands);
    cli::add_phantom_command(commands);
    cli::add_import_command(commands);
    cli::add_approach_commands(commands);
    cli::add_hooks_command(commands);
    cli::add_tension_command(commands);
    cli::add_mesh_command(commands);
    cli::add_cut_command(commands);
    cli::add_plan_command(commands);
    cli::add_render_command(commands);
    cli::add_palpable_command(commands);
    cli::add_palpate_command(commands);
    cli::add_relay_command(commands);
    cli::add_train_command(commands);
    cli::add_doctor_command(commands);
    cli::add_moved_commands(commands);
}

} // namespace

int main(int argc, char** argv)
{
    return retractor::ui::cli::run_command_line(
        { "retractor", "Retractor plans surgical incisions: cut, open, look, compare. Not a medical device.",
            add_commands },
        argc, argv);
}
