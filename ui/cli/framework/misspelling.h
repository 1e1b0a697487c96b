#pragma once
// Writes the message for a command or an option that does not exist.

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace retractor::ui::cli {

/// Finds the first command or option that does not exist, and names the most similar existing one: "unknown command
/// 'plna': did you mean 'plan'?", "plan: unknown option '--opning': did you mean '--opening'?".
/// The message suggests nothing when no name is similar, and never a hidden option.
/// @param arguments without the program's name
/// @return empty when every command and option exists
std::string misspelling(const CLI::App& app, const std::vector<std::string>& arguments);

} // namespace retractor::ui::cli
