#pragma once
// Reads triangle surfaces of organs and hands from Wavefront OBJ files. Only positions and faces are read; polygons
// become triangle fans.

#include "mesh/base/geometry.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::haptics {

/// Joins vertices at one place (files with texture seams repeat vertices) and drops vertices that no face uses.
/// @param unit_mm length of the file's unit, mm
/// @param groups receives the vertices of every named group or object ("g", "o") with faces, in rising order; may be
/// null
/// @throws IoError when the file cannot be read; InputError naming the wrong line, or when there are no faces
TriMesh read_obj_surface(const std::filesystem::path& path, double unit_mm = 1.0,
    std::map<std::string, std::vector<VertexId>>* groups = nullptr);

} // namespace retractor::haptics
