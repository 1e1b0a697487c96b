#pragma once
// Numbers of a planned field as colours on its pictures, with a legend. Bright is where to look. Units mm; frame
// patient LPS.

#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"
#include "ui/scene/scene.h"
#include "ui/scene/scene_map.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

enum class FieldMapKind {
    strain, ///< of the opened wall: elongation over length
    pressure, ///< of a retractor's blades: the force of each third over a third of the area that touches
    risk, ///< distance of the opened wall and the steel from the nearest structure at risk
    sight, ///< of the target: share of the eyes of the cone that see each part
    eyes, ///< share of the target that each eye of the cone sees
    reach, ///< of the target: what a finger touches, and what two instruments reach
};

struct FieldMapName {
    FieldMapKind kind;
    const char* name; ///< in options and names of files
    const char* words; ///< in menus and captions
};
inline constexpr std::array<FieldMapName, 6> kFieldMaps { {
    { FieldMapKind::strain, "strain", "Strain" },
    { FieldMapKind::pressure, "pressure", "Pressure of the blades" },
    { FieldMapKind::risk, "risk", "Distance to structures at risk" },
    { FieldMapKind::sight, "sight", "How much of the view shows each part of the target" },
    { FieldMapKind::eyes, "eyes", "Where the eye sees how much" },
    { FieldMapKind::reach, "reach", "What a finger and two instruments reach" },
} };

/// Reads a name of kFieldMaps. @throws InputError naming the kinds that there are
FieldMapKind field_map_from_string(std::string_view text);

/// The map of a measured field; nothing where the field has no such numbers (no blade in contact, no structure at
/// risk), or where its numbers are not to be used (planner::is_solved()).
std::optional<SceneMap> field_map(planner::Patient& patient, const planner::PlannedField& field, FieldMapKind kind);

/// The map from the surgeon's eye and from outside, side by side. A map of eyes has the view from outside only.
Picture map_picture(planner::Patient& patient, const planner::PlannedField& field, const SceneMap& map,
    const std::string& title, int width, int height);

} // namespace retractor::ui
