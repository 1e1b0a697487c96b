#pragma once
// Reads headers of NRRD files (.nrrd, .nhdr). Format: https://teem.sourceforge.net/nrrd/format.html.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// Reads a header with three dimensions, or with four dimensions whose first axis is not spatial. 3D Slicer writes
/// layered segmentations with four dimensions; `components` is then the size of the first axis. The spaces RAS and LAS
/// are converted to LPS. A header without a space is read as LPS, and a note says so.
/// @throws InputError, naming file and field, for other headers; IoError when the file cannot be opened.
ImageHeader read_nrrd_header(const std::filesystem::path& path);

} // namespace retractor::datasets
