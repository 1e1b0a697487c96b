#pragma once
// Triangle surfaces from Wavefront OBJ files: organs, hands. Positions and faces only; polygons become fans.

#include "mesh/base/geometry.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::haptics {

/// Vertices at one place are joined (files that carry texture seams repeat them), those no face uses are left out.
/// @param unit_mm what one unit of the file is
/// @throws IoError when it cannot be read; InputError naming the line that is wrong, or that there are no faces.
/// @param groups where given: the vertices of every named group or object ("g", "o") that has faces, rising
TriMesh read_obj_surface(const std::filesystem::path& path, double unit_mm = 1.0,
    std::map<std::string, std::vector<VertexId>>* groups = nullptr);

} // namespace retractor::haptics
