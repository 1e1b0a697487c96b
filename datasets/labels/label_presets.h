#pragma once
// Names, materials and roles for label maps that other tools write: by id (TotalSegmentator's multilabel image), by
// segment name (3D Slicer's .seg.nrrd), or by file name (a folder of one mask per organ).

#include "datasets/io/label_table.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::datasets {

/// "totalsegmentator" (v2, task "total"), "totalsegmentator-v1", some of its subtasks ("totalsegmentator-TASK"), "cip"
/// (Chest Imaging Platform, the region in the low byte), "slicer" (names from the file). For --help and messages.
std::vector<std::string> label_preset_names();

/// The table of a preset whose ids are fixed. @throws InputError for an unknown preset, or one without fixed ids.
mesh::LabelTable preset_table(std::string_view preset);

/// Name, material and role for a structure as another tool spells it ("vertebrae_T5", "Left lung", "heart_myocardium",
/// "rib_left_5"): spelling, case, side and blanks are tolerated; names the planner knows come out as it spells them,
/// others keep their own in snake_case with role voxel and material "soft_tissue" (words such as "artery", "muscle" or
/// "bone" in a name give it their material and role). "soft_tissue" never comes with role wall, so that it needs no
/// entry in the material table. A name without a letter or digit becomes "label_ID".
mesh::LabelInfo describe_structure(std::string_view name, Label id);

/// What a segment is by the coded terms of its tags in a .seg.nrrd ("...
/// TerminologyEntry:...~SCT^56873002^Sternum~...", or the entry alone): meaning, side and region, to be given to
/// describe_structure(); empty when the tags only say "tissue".
std::string structure_from_terminology(std::string_view tags);

} // namespace retractor::datasets
