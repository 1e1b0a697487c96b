#pragma once
// Another program, run to its end or to a limit of time.

#include <chrono>
#include <string>
#include <vector>

namespace retractor::cli {

struct ProgramRun {
    int exit_code = -1; ///< -1: it died, was killed or could not be started
    bool timed_out = false; ///< it was killed at the limit
    std::string out; ///< its standard output; standard error goes nowhere
};

/// Runs `words` (the program's path, then its arguments) and kills it, with what it started, after `limit`.
ProgramRun run_program(const std::vector<std::string>& words, std::chrono::milliseconds limit);

} // namespace retractor::cli
