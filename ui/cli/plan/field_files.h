#pragma once
// Writes the results of `plan`, `render` and `demo`: meshes, numbers, pictures and the report page.

#include "planner/case/patient.h"
#include "planner/measures/provenance.h"
#include "planner/measures/report/report.h"
#include "planner/plan/planned_field.h"
#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct PictureRequest {
    std::vector<std::string> views; ///< "surgeon", "overview", "slices"
    int width = 1280, height = 960;
    bool names = true; ///< the surgeon's view names the structures in it
};

/// Writes the meshes of every measured field: <name>.vtu (cut wall with displacement, strain and material labels),
/// <name>-opened.vtp (its deformed surface) and target-<name>.vtp.
void write_field_meshes(
    const std::filesystem::path& folder, planner::Patient& patient, const std::vector<planner::PlannedField>& fields);

/// Renders the views of every measured field to <name>-<view>.png, slices only when the case has a CT. Counts the
/// pixels of the target in the surgeon's view (FieldMetrics::best_eye_pixels). Adds the time to each field's seconds
/// ("render").
std::vector<planner::ReportPicture> render_fields(const std::filesystem::path& folder, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const PictureRequest& request, const Job& job);

/// Renders <name>-slices.png of every approach of a case that has a CT, without planning the approaches.
std::vector<planner::ReportPicture> render_slices(
    const std::filesystem::path& folder, planner::Patient& patient, const PictureRequest& request, const Job& job);

/// Renders slices.png and overview.png of a case without its approaches, see case_picture().
std::vector<planner::ReportPicture> render_case_views(const std::filesystem::path& folder, planner::Patient& patient,
    const std::optional<planner::TargetSpec>& target, const PictureRequest& request, const Job& job);

/// The provenance of results that this program computes now.
planner::Provenance provenance_now(const planner::Case& planned_case);

/// Saves an earlier metrics.json of `folder` before it is replaced, as metrics-earlier.json in `staged`. The copy is
/// made when the file has approaches that are not among these fields, or approaches that were solved there and have no
/// answer now.
/// @return the names of these approaches; empty: no copy was needed
std::vector<std::string> keep_earlier_metrics(const std::filesystem::path& folder, const std::filesystem::path& staged,
    const std::vector<planner::PlannedField>& fields);

/// Writes metrics.json, and its numbers as metrics.csv. @return the document
Json write_metrics(const std::filesystem::path& folder, const planner::Provenance& computed, planner::Patient& patient,
    const std::vector<planner::PlannedField>& fields);

/// Writes report.html from the plans and pictures.
void write_field_report(const std::filesystem::path& folder, planner::Patient& patient,
    const planner::Provenance& computed, const std::vector<planner::PlannedField>& fields,
    const std::vector<planner::ReportPicture>& pictures);

/// A table for people, with the approaches that could not be planned and the reasons.
std::string field_table(const std::vector<planner::PlannedField>& fields);

/// The fields that could not be planned, with name, status and message.
Json refused_document(const std::vector<planner::PlannedField>& fields);

/// Whether a field has numbers to show.
bool is_measured(const planner::PlannedField& field);

/// Whether a field opened as asked, with numbers that can be believed (planner/measures/volume_failures.h).
bool is_answer(const planner::PlannedField& field);

/// Exit code: 0 when every field is an answer; 1 when a field is refused, did not converge or is not to be believed, or
/// a requested second opinion does not agree. Injury, of a rib or of skin, is an answer.
int exit_code_of(const std::vector<planner::PlannedField>& fields);

} // namespace retractor::ui::cli
