#pragma once
// Colours that tell labels apart on a slice. Neighbours differ, and a name has the same colour in every picture.

#include "ui/scene/scene.h"

#include <map>
#include <string_view>

namespace retractor::ui {

/// The colour depends on the name alone. Organs of the chest have their own colours. The ribs and vertebrae of one row
/// step round the colour wheel, so that neighbours differ. Any other name gets a colour from its letters.
Color label_color(std::string_view name);

/// One colour per entry of the table, for SliceItem::outline_of_label.
std::map<Label, Color> label_colors(const mesh::LabelTable& table);

/// The number or level in the name of a rib or vertebra ("rib_left_5": "5", "vertebrae_T7": "T7"); empty for other
/// names.
std::string_view level_of(std::string_view name);

} // namespace retractor::ui
