#pragma once
// The looks of tissues in an operating theatre.

#include "ui/scene/scene.h"

#include <map>
#include <string_view>

namespace retractor::ui {

/// The look by material name (skin, fat, muscle, intercostal, bone, cartilage, vessel, heart, lung, liver). An unknown
/// material gets a neutral tissue colour.
Look tissue_look(std::string_view material);

/// The look by an organ's name, as labels spell it (aorta, lung_left, stomach, rib_left_4, ...); other names look like
/// their material, or as tissue_look() has it for the name.
Look organ_look(std::string_view organ, std::string_view material = {});

/// One look per entry of the table, for SurfaceItem::look_of_label.
std::map<Label, Look> tissue_looks(const mesh::LabelTable& table);

/// The look of retractors.
Look steel_look();

/// The colour of the surgeon's target, which no tissue has.
Color target_color();
/// The colour of incision lines: the surgeon's skin marker.
Color incision_color();

} // namespace retractor::ui
