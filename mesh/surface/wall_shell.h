#pragma once
// Makes the wall of a hollow organ: one layer of tetrahedra beneath the closed outer surface. Labels of vessels are
// filled (blood and wall alike), and a wall of 2 mm is thinner than the voxels of most CTs. The wall therefore gets its
// thickness from the caller instead of being meshed from voxels. Units mm.

#include "mesh/tetrahedra/tet_mesh.h"

namespace retractor::mesh {

/// The boundary of a mesh as closed surfaces, oriented outwards. Vertices and edges at which the boundary touches
/// itself are doubled, so that every edge has exactly two triangles.
TriMesh closed_surfaces(const TetMesh& mesh);
/// The largest closed surface of a mesh, without cavities and without other pieces.
TriMesh largest_closed_surface(const TetMesh& mesh);

struct WallShell {
    TetMesh mesh; ///< the n vertices of the surface first, then vertex n + v beneath vertex v
    std::size_t thinned = 0; ///< number of vertices with a wall thinner than requested
    double thinnest_mm = 0.0; ///< smallest thickness; the requested thickness when thinned == 0
};

/// Smooths the surface a little (Taubin's method, which keeps the volume), then puts three tetrahedra beneath each
/// triangle. Neighbouring triangles divide their common side alike. The wall is thinned where the organ is only a few
/// walls wide, and where the surface bends too sharply inwards for elements of good volume.
/// @pre the surface is closed and oriented outwards, as largest_closed_surface() makes it
/// @throws InputError on a thickness that is not positive; SolverError naming the place where no wall fits
WallShell make_wall_shell(const TriMesh& closed, double thickness_mm, Label label = 1);

} // namespace retractor::mesh
