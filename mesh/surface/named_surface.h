#pragma once
// A surface and its name. Plain data. Units mm.

#include "mesh/base/geometry.h"

#include <string>

namespace retractor::mesh {

/// A surface with the name that people know it by.
struct NamedSurface {
    std::string name;
    TriMesh surface;
};

} // namespace retractor::mesh
