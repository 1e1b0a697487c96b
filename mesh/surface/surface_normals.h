#pragma once
// Normals of triangle surfaces as smooth ones have them.

#include "mesh/base/geometry.h"

namespace retractor::mesh {

/// Unit normals of the vertices, outward: means of the triangles round them by area. Zero where no triangle is, or
/// where they cancel.
Points vertex_normals(const TriMesh& surface);

} // namespace retractor::mesh
