#pragma once
// What `retractor-verify` found, as text, JSON, CSV and charts.

#include "tests/verification/framework/problem.h"
#include "tests/verification/framework/stability.h"
#include "ui/cli/framework/command.h"
#include "ui/scene/vtk/chart.h"

#include <string>
#include <vector>

namespace retractor::verification {

/// "ok"; "series": a coarser mesh, the finest row of its series is judged; "shown": nothing judges it, and the note
/// says why; "skipped"; or "FAILED", also where nothing judges it and no reason is given.
std::string verdict(const VerificationRow& row);
/// "ok" or "FAILED".
std::string verdict(const StabilityRow& row);

ui::cli::Json row_document(const VerificationRow& row);
ui::cli::Json row_document(const StabilityRow& row);

std::string csv(const std::vector<VerificationRow>& rows);
std::string csv(const std::vector<StabilityRow>& rows);

std::string table(const std::vector<VerificationRow>& rows);
std::string table(const std::vector<StabilityRow>& rows);

/// Error against run time: problems with a series of meshes, one panel each.
ui::ChartPicture charts(const std::vector<VerificationRow>& rows);

} // namespace retractor::verification
