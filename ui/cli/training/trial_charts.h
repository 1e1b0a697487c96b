#pragma once
// Draws box plots of elasticity trials.

#include "haptics/training/trial_statistics.h"
#include "mesh/base/job.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Boxes side by side, with the correct value as a line.
struct BoxSeries {
    std::string title;
    double target = 0.0; ///< correct value, MPa
    std::vector<haptics::BoxNumbers> boxes;
    std::vector<std::string> labels; ///< one per box
};

/// Draws one panel per series. @throws IoError when the picture cannot be written
void write_box_chart(const std::filesystem::path& file, const std::vector<BoxSeries>& series,
    const std::string& x_title, const Job& job);

} // namespace retractor::ui::cli
