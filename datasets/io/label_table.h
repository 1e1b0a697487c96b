#pragma once
// The table that names labels, as JSON: {"frame": "LPS", "labels": [{"id", "name", "material", "role"}]}.

#include "mesh/image/volume.h"

#include <filesystem>
#include <string>

namespace retractor::datasets {

/// @throws InputError with file and JSON pointer in where(): missing or mistyped fields, a frame other than LPS, an
/// id outside 1..65535, an unknown role, an id or name given twice; IoError when there is no such file.
mesh::LabelTable read_label_table(const std::filesystem::path& path);

/// The same from the text of such a file. @param where the place its JSON pointers are appended to.
mesh::LabelTable label_table_from_json(const std::string& text, const std::string& where);

/// @throws InputError when a name is not valid UTF-8.
std::string label_table_to_json(const mesh::LabelTable& table);
void write_label_table(const std::filesystem::path& path, const mesh::LabelTable& table);

/// @throws InputError naming the ids when a voxel has a value other than 0 that the table does not name.
void check_labels_named(const mesh::LabelVolume& labels, const std::string& where);

} // namespace retractor::datasets
