#pragma once
// Reads headers of MetaImage files (.mha, .mhd). Format: https://itk.org/Wiki/ITK/MetaIO/Documentation.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// Reads a header. The frame of a MetaImage is LPS, as ITK writes the format.
/// @throws InputError naming file and field; IoError when the file cannot be opened.
ImageHeader read_metaimage_header(const std::filesystem::path& path);

} // namespace retractor::datasets
