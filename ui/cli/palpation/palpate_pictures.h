#pragma once
// Writes the results of a palpation: forces as CSV, a plot over time, and a view of the tissue at the deepest press.

#include "haptics/hand/hand_model.h"
#include "ui/cli/palpation/palpate_run.h"

#include <filesystem>

namespace retractor::ui::cli {

std::string palpation_csv(const std::vector<PressLog>& logs);

/// Plots pressure (where there is a pulse), forces and depths over time.
void write_palpation_chart(
    const std::filesystem::path& file, const std::vector<PressLog>& logs, double force_gain, const Job& job);

/// Draws one picture per press; for several organs also a second one without the outermost organ.
/// @param hands right and left hand on the fingertips, three fingers each; null: fingertips alone
void write_palpation_view(const std::filesystem::path& file, const std::vector<PressLog>& logs,
    const std::vector<Press>& presses, const datasets::PalpationScene& scene, const haptics::TissueResponse& tissue,
    const std::string& note, const std::array<haptics::HandModel, 2>* hands, const Job& job);

} // namespace retractor::ui::cli
