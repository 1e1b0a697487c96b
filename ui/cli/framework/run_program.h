#pragma once
// Another program, run to its end or to a limit of time.

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct ProgramRun {
    int exit_code = -1; ///< -1: it died, was killed or could not be started
    bool timed_out = false; ///< it was killed at the limit
    bool stopped = false; ///< it was killed because `stop` said so
    std::string out; ///< its standard output; standard error goes nowhere
};

/// Runs `words` (the program's path, then its arguments) and kills it, with what it started, after `limit`.
/// @param folder where it runs; empty: here. @param stop asked several times a second; true kills it too.
ProgramRun run_program(const std::vector<std::string>& words, std::chrono::milliseconds limit,
    const std::filesystem::path& folder = {}, const std::function<bool()>& stop = {});

/// The first executable file of this name in the folders of PATH; empty: there is none.
std::filesystem::path program_on_path(const std::string& name);

} // namespace retractor::ui::cli
