#pragma once
// What `plan`, `render` and `demo` write: meshes, numbers, pictures, the report page.

#include "planner/case/patient.h"
#include "planner/measures/provenance.h"
#include "planner/measures/report.h"
#include "planner/plan/planned_field.h"
#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct PictureRequest {
    std::vector<std::string> views; ///< "surgeon", "overview", "slices"
    int width = 1280, height = 960;
};

/// <name>.vtu (cut wall with displacement, strain, material labels), <name>-opened.vtp (its deformed surface) and
/// target-<name>.vtp, for every field that was measured.
void write_field_meshes(
    const std::filesystem::path& folder, planner::Patient& patient, const std::vector<planner::PlannedField>& fields);

/// Renders the views of every measured field to <name>-<view>.png; slices only when the case has a CT.
/// Adds the time to each field's seconds ("render").
std::vector<planner::ReportPicture> render_fields(const std::filesystem::path& folder, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const PictureRequest& request, const Job& job);

/// <name>-slices.png of every approach of a case that has a CT, without planning them.
std::vector<planner::ReportPicture> render_slices(
    const std::filesystem::path& folder, planner::Patient& patient, const PictureRequest& request, const Job& job);

/// slices.png and overview.png of a case without looking at its approaches, see case_picture().
std::vector<planner::ReportPicture> render_case_views(const std::filesystem::path& folder, planner::Patient& patient,
    const std::optional<planner::TargetSpec>& target, const PictureRequest& request, const Job& job);

/// The case as this program computes it now.
planner::Provenance provenance_now(const planner::Case& planned_case);

/// A metrics.json in the folder with approaches that are not among these, or that were solved there and are not now, is
/// copied to metrics-earlier.json before it is replaced. @return a line that says so; empty where nothing would be
/// lost.
std::string keep_earlier_metrics(const std::filesystem::path& folder, const std::vector<planner::PlannedField>& fields);

/// metrics.json; returns the document.
Json write_metrics(const std::filesystem::path& folder, const planner::Provenance& computed,
    const std::vector<planner::PlannedField>& fields);

/// report.html from what was planned and drawn.
void write_field_report(const std::filesystem::path& folder, planner::Patient& patient,
    const planner::Provenance& computed, const std::vector<planner::PlannedField>& fields,
    const std::vector<planner::ReportPicture>& pictures);

/// A table for people; says which approaches could not be planned, and why.
std::string field_table(const std::vector<planner::PlannedField>& fields);

/// The fields that could not be planned: name, status, message.
Json refused_document(const std::vector<planner::PlannedField>& fields);

/// Whether a field has numbers to show.
bool is_measured(const planner::PlannedField& field);

/// 0 when every field is done, 1 when one is refused, did not converge, or a second opinion that was asked for does not
/// agree.
int exit_code_of(const std::vector<planner::PlannedField>& fields);

} // namespace retractor::ui::cli
