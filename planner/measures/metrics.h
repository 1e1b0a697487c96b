#pragma once
// The numbers of a planned surgical field in words, and as the document metrics.json. The numbers: field_metrics.h.

#include "planner/measures/field_metrics.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace retractor::planner {

/// One line for people: what each ablation took, by label. Empty when nothing was taken.
std::string removed_text(const std::vector<RemovedTissue>& removed);

/// One line for people: that the hole left by removed skin is not part of the opening. Empty without such a hole.
std::string skin_hole_text(const FieldMetrics& field);

/// One line for people: the bars of opening and forces, or why there are none.
std::string error_text(const FieldMetrics& field);
/// All hooks pull with a force that was asked for, or have yielded: there is nothing to be off in it.
bool forces_are_known(const FieldMetrics& field);

/// One line for people: what hooks did that pull with a force, yield or grip softly. Empty where none does.
std::string hooks_text(const FieldMetrics& field);

/// One line for people: how the wound was solved, and what a linear far field changed where that was measured.
std::string solution_text(const FieldMetrics& field);

/// One line for people: the tissues' pre-strain, and how far the wound gapes by it. @pre field.tension.
std::string tension_text(const FieldMetrics& field);

/// One line for people: where surfaces hold each other off. @pre field.contact.
std::string contact_text(const FieldMetrics& field);

/// One line for people: whether another program agrees, by how much, and in what time.
std::string opinion_text(const SecondOpinion& opinion);

/// {"approaches": [...], "frame": "LPS", "units": ...}; numbers that are not finite are refused.
/// @throws InputError naming the approach and the number.
nlohmann::ordered_json metrics_document(const std::vector<FieldMetrics>& fields);

} // namespace retractor::planner
