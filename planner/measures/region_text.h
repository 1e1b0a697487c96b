#pragma once
// The meshed region in words: how it was chosen, how far its rim moves, and which bones come out through the skin.

#include "planner/measures/field_metrics.h"

#include <string>
#include <string_view>

namespace retractor::planner {

/// A rim that moves less is taken to be at rest, mm (ours).
inline constexpr double kStillRimMm = 1.0;

/// Names in files: "not_searched", "given", "still", "whole", "memory", "failure".
std::string_view to_string(RegionEnd end);

/// "The model holds the wall within 120 mm of the incision. Beyond it tissue moves by at most 0.8 mm (muscle, 118 mm
/// from the incision); leaving it out changes the force by about 2 %."
std::string region_text(const FieldMetrics& field);

/// Whether the rim moves farther than kStillRimMm, or a bone comes out through the skin.
bool is_region_too_small(const FieldMetrics& field);

/// "not usable: these numbers are not to be believed: rib 6 on the left comes 33 mm out through the skin ..."; empty
/// where no bone does.
std::string piercing_text(const FieldMetrics& field);

} // namespace retractor::planner
