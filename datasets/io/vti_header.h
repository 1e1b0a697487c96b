#pragma once
// Reads headers of VTK's XML image data (.vti). Format: https://docs.vtk.org, "VTK XML formats". VTK's own reader is
// not used, because it trusts the sizes in damaged files and takes seconds and gigabytes for a few hundred bytes.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// Reads a header. A .vti file names no frame and no unit, so LPS in mm is assumed, and a note says so. The data are
/// text, base64 or appended, plain or compressed by zlib. The image is the array that PointData names as scalars, or
/// the only array.
/// @throws InputError, naming file and element, for several pieces, values in cells, several arrays without a named
/// one, several numbers per voxel, other compressors, and sizes that contradict each other; IoError when the file
/// cannot be opened.
ImageHeader read_vti_header(const std::filesystem::path& path);

} // namespace retractor::datasets
