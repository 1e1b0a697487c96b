#pragma once
// The options that stand for the fields of a request. Libraries name fields; only the command line names options.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace retractor::ui::cli {

/// " (option --depth)" or " (options --near, --contact)": what the user can change to mend an error of these fields.
/// @param app after parsing: options that the given command does not have are left out.
/// @param fields see Error::fields(). @return empty where no option stands for any of the fields.
std::string option_hint(const CLI::App& app, const std::vector<std::string>& fields);

} // namespace retractor::ui::cli
