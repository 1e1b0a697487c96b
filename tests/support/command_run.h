#pragma once
// Runs the built executable as a script does, and keeps its exit code and output. RETRACTOR_PROGRAM is its path.

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <string>

#include <sys/wait.h>

namespace retractor::test_support {

struct CommandRun {
    int exit_code = -1; ///< -1 when the program was killed
    std::string out; ///< standard output, with standard error when the line redirects it
    nlohmann::json json() const { return nlohmann::json::parse(out); }
    std::string error() const { return json().at("error").get<std::string>(); }
};

/// Runs a command line. @param line in the syntax of the shell
inline CommandRun run_line(const std::string& line)
{
    CommandRun result;
    std::FILE* pipe = ::popen(line.c_str(), "r");
    std::array<char, 4096> buffer {};
    for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
        result.out.append(buffer.data(), n);
    const int status = ::pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

} // namespace retractor::test_support
