#include "ui/cli/bench_cut.h"
#include "ui/cli/command.h"

#include <memory>

namespace retractor::cli {

void add_bench_command(Commands& commands)
{
    CLI::App* command = commands.app.add_subcommand("bench", "Measure speed and quality; times are medians");
    command->require_subcommand(1);
    auto options = std::make_shared<CutBenchOptions>();
    CLI::App* cut = command->add_subcommand("cut", "The knife: elements made, their angles, time per stroke and step");
    cut->footer("Example: retractor bench cut --json");
    cut->add_option("--repeats", options->repeats, "Strokes per row")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    cut->add_flag("!--small", options->largest, "Without the box of a million elements");
    cut->add_flag("!--no-thorax", options->thorax, "Without the graded chest wall, whose meshing takes some seconds");
    cut->add_option("--out", options->out, "Folder for bench_cut.json");
    cut->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return bench_cut(*options, job); }; });
}

} // namespace retractor::cli
