#pragma once
// Reads the names that an image of labels carries in its own header.

#include "mesh/base/geometry.h"

#include <filesystem>
#include <map>
#include <string>

namespace retractor::datasets {

/// Returns the table that TotalSegmentator writes as an extension of the NIfTI-1 header (XML, <Label
/// Key="5">liver</Label>), without id 0. The result is empty for a file without such a table and for other formats.
/// @throws InputError for a damaged extension, and for an id that occurs twice.
std::map<Label, std::string> label_names_in_file(const std::filesystem::path& image);

/// Returns the same table from the text of the extension. @throws InputError as label_names_in_file() does.
std::map<Label, std::string> label_names_from_xml(const std::string& xml, const std::string& where);

} // namespace retractor::datasets
