#pragma once
// What every command of our programs shares: the three global options, one way to report, one way to fail.
// Exit codes: 0 done, 1 it failed or the answer is a refusal, 2 usage or bad input.

#include "mesh/base/job.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <functional>
#include <string>

namespace retractor::ui::cli {

/// Ordered: documents are read by people too.
using Json = nlohmann::ordered_json;

/// What a command hands back. `document` is what --json prints; `text` is for people.
struct Outcome {
    Json document = Json::object();
    std::string text;
    int exit_code = 0;
};

/// Options before or after any command's own.
struct GlobalOptions {
    bool json = false;
    bool profile = false;
    int threads = 0; ///< 0: as many as the machine has
};

/// A command registers its subcommand and options on `app` and returns nothing; the action to run is kept in `run`.
struct Commands {
    CLI::App& app;
    GlobalOptions& options;
    char** argv; ///< as given to the program
    std::function<Outcome(const Job&)> run; ///< set by the chosen subcommand's callback
};

/// A program of the command line.
struct Program {
    std::string name; ///< as it is called: "retractor"
    std::string about; ///< what --help says first
    std::function<void(Commands&)> add_commands; ///< registers its commands, or its options where it has no commands
};

/// Parses, runs and prints; the whole program. @return its exit code.
int run_command_line(const Program& program, int argc, char** argv);

} // namespace retractor::ui::cli
