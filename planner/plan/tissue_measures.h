#pragma once
// The strain of the tissues of a planned field, and whether skin would tear. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/planned_field.h"

#include <string>

namespace retractor::planner {

/// A place beside the incision, in words: "38 mm along the incision, 4 mm beside it and 12 mm deep".
std::string place_beside_incision(const Approach& approach, const Vec3& place);

/// Fills field.metrics.tissue_strain and remarks on skin that would tear. A field without an equilibrium has no strain.
/// @pre the field's wound is opened
void measure_tissue_strain(PlannedField& field, const OpenedWound& wound, const mesh::LabelTable& table);

} // namespace retractor::planner
