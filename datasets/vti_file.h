#pragma once
// VTK's XML image data (.vti), read by VTK and checked by us.

#include "datasets/image_header.h"

#include <functional>
#include <span>

namespace retractor {

/// Calls `take` once with geometry, type and all voxels. A .vti names no frame: LPS mm is assumed, and a note says so.
/// @throws InputError for what VTK cannot read or only warns of, more than one piece of data that could be the image,
/// values in cells, several numbers per voxel, a size that the file cannot hold.
ImageHeader read_vti(
    const std::filesystem::path& path, const std::function<void(const ImageHeader&, std::span<const char>)>& take);

} // namespace retractor
