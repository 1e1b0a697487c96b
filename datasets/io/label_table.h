#pragma once
// Reads and writes the table of label names, as JSON: {"frame": "LPS", "labels": [{"id", "name", "material", "role"}]}.

#include "mesh/image/volume.h"

#include <filesystem>
#include <string>

namespace retractor::datasets {

/// Reads a table from a file.
/// @throws InputError, with file and JSON pointer in where(), for missing or mistyped fields, a frame other than LPS,
/// an id outside 1..65535, an unknown role, and an id or name that occurs twice; IoError when there is no such file.
mesh::LabelTable read_label_table(const std::filesystem::path& path);

/// Reads a table from the text of such a file.
/// @param where the place that comes before JSON pointers in messages
/// @throws InputError as read_label_table() does.
mesh::LabelTable label_table_from_json(const std::string& text, const std::string& where);

/// The table as the text of a file. @throws InputError when a name is not valid UTF-8.
std::string label_table_to_json(const mesh::LabelTable& table);
/// Writes the table to a file. @throws InputError as label_table_to_json() does; IoError when writing fails.
void write_label_table(const std::filesystem::path& path, const mesh::LabelTable& table);

/// Checks that the table names the value of every voxel, except 0. @throws InputError naming the missing ids.
void check_labels_named(const mesh::LabelVolume& labels, const std::string& where);

} // namespace retractor::datasets
