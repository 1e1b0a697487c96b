#pragma once
// Where new cases go unless the user says otherwise.

#include <filesystem>
#include <string>

namespace retractor::ui {

/// The folder "Retractor/NAME" in the user's home; with the first number ("-2") that gives a folder which is not there.
std::filesystem::path free_case_folder(const std::string& name);

} // namespace retractor::ui
