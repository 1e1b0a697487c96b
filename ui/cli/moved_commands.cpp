#include "ui/cli/commands.h"

#include "mesh/base/error.h"

#include <string>

namespace retractor::ui::cli {

namespace {

    /// The command takes all further arguments, also --help, and refuses to run.
    void add_moved_command(Commands& commands, const std::string& name, const std::string& program)
    {
        CLI::App* command = commands.app.add_subcommand(name)->group(""); // not shown in the list of commands
        command->set_help_flag();
        command->fallthrough(false);
        command->allow_extras();
        command->add_flag("--json", commands.options.json)->group("");
        command->callback([&commands, name, program] {
            commands.run = [name, program](const Job&) -> Outcome {
                throw InputError("`retractor " + name + "` is a program of its own now: " + program, "command line");
            };
        });
    }

} // namespace

void add_moved_commands(Commands& commands)
{
    add_moved_command(commands, "verify", "retractor-verify");
    add_moved_command(commands, "bench", "retractor-bench");
}

} // namespace retractor::ui::cli
