#pragma once
// Headers of NRRD files (.nrrd, .nhdr). Format: https://teem.sourceforge.net/nrrd/format.html.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// Three-dimensional, or four-dimensional with a first axis that is not spatial (`components`), as 3D Slicer writes
/// layered segmentations. Spaces RAS and LAS become LPS; a header that names no space is taken as LPS, and a note says
/// so.
/// @throws InputError naming file and field for everything else; IoError when it cannot be opened.
ImageHeader read_nrrd_header(const std::filesystem::path& path);

} // namespace retractor::datasets
