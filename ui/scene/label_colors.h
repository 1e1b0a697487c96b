#pragma once
// Colours that tell labels apart on a slice: neighbours differ, and a name has the same colour in every picture.

#include "ui/scene/scene.h"

#include <map>
#include <string_view>

namespace retractor::ui {

/// By name alone: organs of the chest have their own colours; the ribs and vertebrae of one row step round the colour
/// wheel, so that neighbours differ; any other name gets a colour of its own from its letters.
Color label_color(std::string_view name);

/// One colour per entry of the table, for SliceItem::outline_of_label.
std::map<Label, Color> label_colors(const mesh::LabelTable& table);

/// The number or level that a rib or vertebra carries in its name ("rib_left_5": "5", "vertebrae_T7": "T7"), empty
/// for other names.
std::string_view level_of(std::string_view name);

} // namespace retractor::ui
