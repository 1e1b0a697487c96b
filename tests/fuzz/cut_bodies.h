#pragma once
// Bodies for the cut fuzzer: grids, meshes of the product's mesher, and tetrahedra from SOFA. Units mm.

#include "mesh/tetrahedra/tet_mesh.h"

#include <string>
#include <vector>

namespace retractor::fuzz {

struct Body {
    std::string name;
    mesh::TetMesh mesh; ///< empty when the body is not to be had
    std::string missing; ///< why
    double edge = 0.0; ///< mean edge (mm)
};

/// Names that make_body knows.
const std::vector<std::string>& body_names();
/// @throws InputError on another name.
Body make_body(const std::string& name);

} // namespace retractor::fuzz
