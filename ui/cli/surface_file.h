#pragma once
// Triangle surfaces from Wavefront OBJ files: organs, hands. Positions and faces only; polygons become fans.

#include "mesh/geometry.h"

#include <filesystem>

namespace retractor::cli {

/// Vertices at one place are joined (files that carry texture seams repeat them), those no face uses are left out.
/// @param unit_mm what one unit of the file is
/// @throws IoError when it cannot be read; InputError naming the line that is wrong, or that there are no faces.
TriMesh read_obj_surface(const std::filesystem::path& path, double unit_mm = 1.0);

} // namespace retractor::cli
