#pragma once
// The frame of all command line programs: the three global options, the output, and the handling of errors.
// Exit codes: 0 done, 1 failed or refused, 2 wrong usage or bad input.

#include "mesh/base/job.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>

// CLI11 defines its checks in every source that includes it, which takes 5 s each: only what adds options includes it.
namespace CLI {
class App;
}

namespace retractor::ui::cli {

/// Keeps the order of keys, because people read the documents too.
using Json = nlohmann::ordered_json;

/// The result of a command. --json prints `document`; `text` is for people.
struct Outcome {
    Json document = Json::object();
    std::string text;
    int exit_code = 0;
};

/// Options that may stand before or after the options of a command.
struct GlobalOptions {
    bool json = false;
    bool profile = false;
    int threads = 0; ///< 0: as many as the machine has
};

/// A command registers its subcommand and options on `app`. The callback of the chosen subcommand stores its action in
/// `run`.
struct Commands {
    CLI::App& app;
    GlobalOptions& options;
    char** argv;
    std::function<Outcome(const Job&)> run; ///< action of the chosen subcommand

    /// Makes this the action when the user chooses `command`.
    void on(CLI::App* command, const std::function<Outcome(const Job&)>& action);
    /// The user must choose a command.
    void require_one();
};

/// One program of the command line.
struct Program {
    std::string name; ///< for example "retractor"
    std::string about; ///< first sentence of --help
    /// Registers the commands of the program, or its options when the program has no commands.
    std::function<void(Commands&)> add_commands;
};

/// The whole program: parses the arguments, runs the command, prints the result. @return the exit code
int run_command_line(const Program& program, int argc, char** argv);

} // namespace retractor::ui::cli
