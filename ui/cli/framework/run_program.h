#pragma once
// Runs another program to its end or to a time limit.

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct ProgramRun {
    int exit_code = -1; ///< -1: the program crashed, was killed or could not be started
    bool timed_out = false; ///< the program was killed at the time limit
    double peak_bytes = 0.0; ///< largest memory of the program itself
    bool stopped = false; ///< the program was killed because `stop` returned true
    std::string out; ///< standard output of the program; standard error is discarded
};

/// Runs `words` (the program's path, then its arguments). The program and its children are killed after `limit`,
/// and the program when the calling thread ends.
/// @param folder working folder; empty: the current one
/// @param stop called several times a second; the program is killed when it returns true
ProgramRun run_program(const std::vector<std::string>& words, std::chrono::milliseconds limit,
    const std::filesystem::path& folder = {}, const std::function<bool()>& stop = {});

/// The first executable file of this name in the folders of PATH; empty when there is none.
std::filesystem::path program_on_path(const std::string& name);

} // namespace retractor::ui::cli
