#pragma once
// Headers of VTK's XML image data (.vti). Format: https://docs.vtk.org, "VTK XML formats". VTK's own reader believes
// sizes in damaged files (seconds and gigabytes for a few hundred bytes), so that it is not used.

#include "datasets/io/image_header.h"

namespace retractor::datasets {

/// A .vti names no frame and no unit: LPS in mm is assumed, and a note says so. Data in text, base64 or appended,
/// plain or packed by zlib. The image is the array that PointData names as scalars, or the only one.
/// @throws InputError naming file and element: several pieces, values in cells, several arrays of which none is marked,
/// several numbers per voxel, other compressors, sizes that contradict one another; IoError when it cannot be opened.
ImageHeader read_vti_header(const std::filesystem::path& path);

} // namespace retractor::datasets
