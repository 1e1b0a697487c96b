#pragma once
// The wall of a hollow organ: one layer of tetrahedra beneath its closed outer surface. Labels of vessels are filled
// (blood and wall alike), and a wall of 2 mm is thinner than the voxels of most CTs; so the wall is given its thickness
// instead of being meshed from voxels. Units mm.

#include "mesh/tetrahedra/tet_mesh.h"

namespace retractor::mesh {

/// A mesh's boundary as closed surfaces, oriented outwards. Where it touches itself at a vertex or along an edge, these
/// are doubled: every edge has one triangle on each side.
TriMesh closed_surfaces(const TetMesh& mesh);
/// The largest of them: without cavities and without other pieces.
TriMesh largest_closed_surface(const TetMesh& mesh);

struct WallShell {
    TetMesh mesh; ///< the n vertices of the surface first, then vertex n + v beneath vertex v
    std::size_t thinned = 0; ///< vertices under which the wall had to be thinner than asked for
    double thinnest_mm = 0.0; ///< of those, else the thickness asked for
};

/// The surface is smoothed a little (Taubin: its volume stays), then three tetrahedra lie beneath each triangle, split
/// alike on both sides of every edge. The wall is thinned where the organ is no wider than a few walls, and where its
/// surface bends too sharply inwards for elements of good volume.
/// @pre the surface is closed and oriented outwards, as largest_closed_surface() makes it
/// @throws InputError on a thickness that is not positive; SolverError naming the place where no wall fits.
WallShell make_wall_shell(const TriMesh& closed, double thickness_mm, Label label = 1);

} // namespace retractor::mesh
