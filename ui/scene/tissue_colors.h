#pragma once
// What tissues look like in an operating theatre.

#include "ui/scene/scene.h"

#include <map>
#include <string_view>

namespace retractor::ui {

/// By material name (skin, fat, muscle, intercostal, bone, cartilage, vessel, heart, lung, liver); a material that
/// is not known gets a neutral tissue colour.
Look tissue_look(std::string_view material);

/// By an organ's name, as labels spell them (aorta, lung_left, stomach, rib_left_4, ...); others as tissue_look().
Look organ_look(std::string_view organ);

/// One look per entry of the table, for SurfaceItem::look_of_label.
std::map<Label, Look> tissue_looks(const mesh::LabelTable& table);

/// The colour of what the surgeon wants to see: no tissue has it.
Color target_color();
/// Incision lines: the surgeon's skin marker.
Color incision_color();

} // namespace retractor::ui
