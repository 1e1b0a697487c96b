#pragma once
// Names, materials and roles for label maps of other tools. A structure is identified by its id (TotalSegmentator's
// multilabel image), by its segment name (3D Slicer's .seg.nrrd), or by its file name (a folder with one mask per
// organ).

#include "datasets/io/label_table.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::datasets {

/// The presets, for help texts and messages: "totalsegmentator" (v2, task "total"), "totalsegmentator-v1", some
/// subtasks ("totalsegmentator-TASK"), "cip" (Chest Imaging Platform, the region in the low byte), "slicer" (names from
/// the file).
std::vector<std::string> label_preset_names();

/// The table of a preset with fixed ids. @throws InputError for an unknown preset, and for a preset without fixed ids.
mesh::LabelTable preset_table(std::string_view preset);

/// Name, material and role of a structure that another tool names ("vertebrae_T5", "Left lung", "heart_myocardium",
/// "rib_left_5"). Spelling, case, the place of the side, and blanks may vary. A structure that the planner knows gets
/// the planner's name. Another structure keeps its name in snake_case, with role voxel and material "soft_tissue";
/// words such as "artery", "muscle" or "bone" in the name choose another material and role. "soft_tissue" never has the
/// role wall, so the material table needs no such entry. A name without letters and digits becomes "label_ID".
mesh::LabelInfo describe_structure(std::string_view name, Label id);

/// Reads the coded terms in the tags of a .seg.nrrd segment ("... TerminologyEntry:...~SCT^56873002^Sternum~...", or
/// the entry alone). Returns meaning, side and region in words for describe_structure(), or an empty string when the
/// tags say only "tissue".
std::string structure_from_terminology(std::string_view tags);

} // namespace retractor::datasets
