#pragma once
// Finds the options of the command line that set the fields of a request. Libraries name fields; only the command line
// names options.

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace retractor::ui::cli {

/// The options with which the user can correct an error in these fields: " (option --depth)" or " (options --near,
/// --contact)".
/// @param app after parsing; options that the given command does not have are left out
/// @param fields see Error::fields()
/// @return empty when no option sets any of the fields
std::string option_hint(const CLI::App& app, const std::vector<std::string>& fields);

} // namespace retractor::ui::cli
