#pragma once
// Results of `retractor-verify` as text, JSON, CSV and charts.

#include "tests/verification/framework/problem.h"
#include "tests/verification/framework/stability.h"
#include "ui/cli/framework/command.h"
#include "ui/scene/vtk/chart.h"

#include <string>
#include <vector>

namespace retractor::verification {

/// Verdict of a row. "ok"; "series": a coarser mesh, whose series is judged in its finest row; "shown": not judged,
/// the note gives the reason; "inside", "outside" or "undecided": a comparison with measurements; "skipped"; or
/// "FAILED", also for a row that is not judged and gives no reason.
std::string verdict(const VerificationRow& row);
/// Verdict of a row: "ok" or "FAILED".
std::string verdict(const StabilityRow& row);

ui::cli::Json row_document(const VerificationRow& row);
ui::cli::Json row_document(const StabilityRow& row);

std::string csv(const std::vector<VerificationRow>& rows);
std::string csv(const std::vector<StabilityRow>& rows);

std::string table(const std::vector<VerificationRow>& rows);
std::string table(const std::vector<StabilityRow>& rows);

/// Charts of error against run time: one panel for each problem with a series of meshes.
ui::ChartPicture charts(const std::vector<VerificationRow>& rows);

} // namespace retractor::verification
