#pragma once
// Vertex normals that make a triangle surface look smooth.

#include "mesh/base/geometry.h"

namespace retractor::mesh {

/// Outward unit normals of the vertices, n x 3: the area-weighted mean over the triangles round a vertex. Zero for a
/// vertex without triangles, or when the normals cancel.
Points vertex_normals(const TriMesh& surface);

} // namespace retractor::mesh
