#pragma once
// The interactive view of a planned field inside report.html: the scene as JSON, and the script that shows it.
//
// The script is npm's vtk.js with viewer/field_view.js, bundled; the bundle is kept in the repository, so that a build
// needs no npm. viewer/README.md tells how it is made.

#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"

#include <string>
#include <string_view>

namespace retractor::ui {

/// Surfaces that the report's view draws besides the meshed wall have at most about this many triangles together.
inline constexpr std::size_t kReportTriangles = 80'000;

/// The opened field with wall, remaining anatomy, retractor and target in layers, at rest and opened, and two cameras.
/// The target carries how many eyes of the field's cone see each place, and the eyes what they see.
/// Positions are 16-bit steps over the scene's box: exact to about 0.01 mm. Surfaces beyond the wall are simplified.
/// @pre the field is measured
std::string field_view(planner::Patient& patient, const planner::PlannedField& field);

/// The script that shows every <div class="field-view" data-scene="ID"> of a page; no reference to another file.
std::string_view field_viewer();

} // namespace retractor::ui
