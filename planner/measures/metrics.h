#pragma once
// Writes the numbers of a planned surgical field in words and as the document metrics.json. The numbers:
// field_metrics.h.

#include "planner/measures/field_metrics.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace retractor::planner {

/// One line for people: the tissue that each ablation removed, by label. Empty when nothing was removed.
std::string removed_text(const std::vector<RemovedTissue>& removed);

/// One line for people: how far the intercostal space is divided beyond the skin. Empty without a division.
std::string division_text(const FieldMetrics& field);
/// The same for a cell of a table: "47 mm backwards, 62 mm forwards", or "skin only".
std::string division_cell(const FieldMetrics& field);

/// One line for people: the hole left by removed skin is not part of the opening. Empty without such a hole.
std::string skin_hole_text(const FieldMetrics& field);

/// One line for people: the error bars of opening, forces and visible share, or the reason why there are none.
std::string error_text(const FieldMetrics& field);
/// Whether all hooks pull with a prescribed force or have yielded, so that the forces have no error.
bool forces_are_known(const FieldMetrics& field);

/// One line for people about hooks that pull with a force, yield or grip softly. Empty without such hooks.
std::string hooks_text(const FieldMetrics& field);

/// Text for people: force, moment and turn of a blade, and how far its lip follows.
std::string blade_text(const BladeMetrics& blade);
/// One line for people about the retractor and its blades. Empty without a retractor.
std::string retractor_text(const FieldMetrics& field);

/// A lip for people: "left lip", and with a retractor "lip at the upper blade".
std::string lip_name(const FieldMetrics& field, int side);

/// One line for people: how far each lip hangs behind its hooks or blade. Empty without hooks.
std::string lips_text(const FieldMetrics& field);

/// One line for people: the solver settings, and the measured effect of linear tissue far from the lips.
std::string solution_text(const FieldMetrics& field);

/// One line for people: the tissues' pre-strain, and the gape of the wound by this tension. @pre field.tension
std::string tension_text(const FieldMetrics& field);

/// One line for people: number, force and penetration of the points in contact, or where surfaces pass through each
/// other. @pre field.contact
std::string contact_text(const FieldMetrics& field);
/// Whether the wall sinks visibly into an organ that gives way.
bool sinks_in(const ContactMetrics& contact);
/// Whether surfaces pass through each other and contact was not computed: the numbers near them are wrong.
bool passes_through(const FieldMetrics& field);

/// One line for people: whether another program agrees, the difference, and the time.
std::string opinion_text(const SecondOpinion& opinion);

/// {"approaches": [...], "frame": "LPS", "units": ...}
/// @throws InputError naming the approach and a number that is not finite
nlohmann::ordered_json metrics_document(const std::vector<FieldMetrics>& fields);

/// "left rib 4", "soft tissue only".
std::string bearing_text(const HookForce& hook);

/// The bones in the line of sight in words: "left rib 4".
std::vector<std::string> bones_in_sight(const FieldMetrics& field);

/// "aorta 12.3 mm", or "aorta: the blade passes through it".
std::string risk_text(const RiskDistance& risk);

/// "estimated, not seen in the image: aorta"; empty without any.
std::string estimated_text(const FieldMetrics& field);

/// "with the organs 10 mm nearer to the head the best eye sees 12 %, 20 mm 9 %; past a lung of 20 % of its volume 14 %,
/// ..."; empty where it was not measured.
std::string shifted_sight_text(const FieldMetrics& field);
/// "from the blade to structures at risk: heart 8.1 mm, aorta 12.3 mm".
std::string risks_text(const FieldMetrics& field);

} // namespace retractor::planner
