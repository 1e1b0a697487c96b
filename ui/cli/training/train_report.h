#pragma once
// Reports elasticity trials: boxes by instruction and by session, tests of spreads and of learning, the questionnaire.

#include "ui/cli/framework/command.h"

#include <filesystem>

namespace retractor::ui::cli {

/// @param out folder for trials.csv, trials.json and the charts; empty: no files
/// @throws InputError when there is no trial
Outcome train_report(const std::filesystem::path& store, const std::filesystem::path& out, const Job& job);

} // namespace retractor::ui::cli
