#pragma once
// Writes results of plans into a folder: meshes, numbers, pictures and the report page.

#include "planner/case/patient.h"
#include "planner/decision/decisions.h"
#include "planner/measures/provenance.h"
#include "planner/measures/report/report.h"
#include "planner/plan/planned_field.h"
#include "ui/plan_scene/field_map.h"
#include "ui/scene/scene_language.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

/// Which pictures to draw of each field.
struct FieldViews {
    std::vector<std::string> views; ///< "surgeon", "overview", "slices"
    int width = 1280, height = 960;
    bool names = true; ///< the surgeon's view names the structures in it
    std::vector<FieldMapKind> maps {}; ///< drawn besides
    std::vector<planner::NamedView> kept {}; ///< views that the team keeps, drawn besides
    TextLanguage language {}; ///< of the texts in pictures of fields
};

/// Writes the meshes of every measured field: <name>.vtu (cut wall with displacement, strain and material labels),
/// <name>-opened.vtp (its deformed surface) and target-<name>.vtp.
void write_field_meshes(
    const std::filesystem::path& folder, planner::Patient& patient, const std::vector<planner::PlannedField>& fields);

/// Renders the views of every measured field to <name>-<view>.png (slices only when the case has a CT), its maps to
/// <name>-map-<kind>.png where it has their numbers, and its kept views to <name>-view-<n>.png. Counts the pixels of
/// the target in the surgeon's view (FieldMetrics::best_eye_pixels). Adds the time to each field's seconds ("render").
std::vector<planner::ReportPicture> render_fields(const std::filesystem::path& folder, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const FieldViews& request, const Job& job);

/// Renders <name>-slices.png of every approach of a case that has a CT, without planning the approaches.
std::vector<planner::ReportPicture> render_slices(
    const std::filesystem::path& folder, planner::Patient& patient, const FieldViews& request, const Job& job);

/// Renders slices.png and overview.png of a case without its approaches, see case_picture().
std::vector<planner::ReportPicture> render_case_views(const std::filesystem::path& folder, planner::Patient& patient,
    const std::optional<planner::TargetSpec>& target, const FieldViews& request, const Job& job);

/// The provenance of results that this program computes now.
planner::Provenance provenance_now(const planner::Case& planned_case);

/// Saves an earlier metrics.json of `folder` before it is replaced, as metrics-earlier.json in `staged`. The copy is
/// made when the file has approaches that are not among these fields, or approaches that were solved there and have no
/// answer now.
/// @return the names of these approaches; empty: no copy was needed
std::vector<std::string> keep_earlier_metrics(const std::filesystem::path& folder, const std::filesystem::path& staged,
    const std::vector<planner::PlannedField>& fields);

/// Writes metrics.json, and its numbers as metrics.csv. @return the document
nlohmann::ordered_json write_metrics(const std::filesystem::path& folder, const planner::Provenance& computed,
    planner::Patient& patient, const std::vector<planner::PlannedField>& fields);

/// Writes the report page from the plans and pictures. The page holds the pictures itself.
void write_field_report(const std::filesystem::path& file, planner::Patient& patient,
    const planner::Provenance& computed, const std::vector<planner::PlannedField>& fields,
    const std::vector<planner::ReportPicture>& pictures);

/// Draws the pictures and writes the report page alone. @return false: cancelled, and nothing is written
bool write_report_page(const std::filesystem::path& file, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const FieldViews& views, const Job& job);

/// The fields that could not be planned, with name, status and message.
nlohmann::ordered_json refused_document(const std::vector<planner::PlannedField>& fields);

/// What became of a plan, in words.
std::string_view status_word(planner::PlanStatus status);

/// Whether a field opened as asked, with numbers that can be believed (planner/measures/volume_failures.h).
bool is_answer(const planner::PlannedField& field);

} // namespace retractor::ui
