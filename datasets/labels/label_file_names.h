#pragma once
// Names that an image of labels carries in its own header.

#include "mesh/base/geometry.h"

#include <filesystem>
#include <map>
#include <string>

namespace retractor::datasets {

/// The table that TotalSegmentator writes as an extension of the NIfTI-1 header (XML, <Label Key="5">liver</Label>),
/// without id 0. Empty when there is none, also for files of other formats.
/// @throws InputError for an extension that is damaged, or that names an id twice.
std::map<Label, std::string> label_names_in_file(const std::filesystem::path& image);

/// The same from the extension's text.
std::map<Label, std::string> label_names_from_xml(const std::string& xml, const std::string& where);

} // namespace retractor::datasets
