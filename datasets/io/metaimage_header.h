#pragma once
// Headers of MetaImage files (.mha, .mhd). Format: https://itk.org/Wiki/ITK/MetaIO/Documentation.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// The frame of a MetaImage is LPS, as ITK writes it.
/// @throws InputError naming file and field; IoError when it cannot be opened.
ImageHeader read_metaimage_header(const std::filesystem::path& path);

} // namespace retractor::datasets
