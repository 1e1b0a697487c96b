#pragma once
// What a palpation leaves behind: forces as CSV, a plot over time, a view of the tissue when it was deepest.

#include "haptics/hand/hand_model.h"
#include "ui/cli/palpation/palpate_run.h"

#include <filesystem>

namespace retractor::ui::cli {

std::string palpation_csv(const std::vector<PressLog>& logs);

/// Pressure (where there is a pulse), forces and depths over time.
void write_palpation_chart(
    const std::filesystem::path& file, const std::vector<PressLog>& logs, double force_gain, const Job& job);

/// One picture per press; of several organs a second one without the outermost. @param hands right and left, three
/// fingers each, shown on the fingertips; null: fingertips alone
void write_palpation_view(const std::filesystem::path& file, const std::vector<PressLog>& logs,
    const std::vector<Press>& presses, const datasets::PalpationScene& scene, const haptics::TissueResponse& tissue,
    const std::string& note, const std::array<haptics::HandModel, 2>* hands, const Job& job);

} // namespace retractor::ui::cli
