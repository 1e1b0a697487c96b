#pragma once
// What to say of a command line with a command or an option that does not exist.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace retractor::ui::cli {

/// The first command or option of the arguments that does not exist, with the most similar one that does:
/// "unknown command 'plna': did you mean 'plan'?", "plan: unknown option '--opning': did you mean '--opening'?".
/// Nothing is suggested where no name is similar. Hidden options are never suggested.
/// @param arguments without the program's name. @return empty where every command and option exists.
std::string misspelling(const CLI::App& app, const std::vector<std::string>& arguments);

} // namespace retractor::ui::cli
