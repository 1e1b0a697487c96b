#pragma once
// A block with an incision that two hooks hold open: what the extreme cases and the ladder of solvers share. Units mm.

#include "fem/interactive/online_hook.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/store/blade.h"

#include <vector>

namespace retractor::verification {

/// The cut runs along x through the middle of the top, straight down, everywhere on the planes of the grid as long as
/// the sizes are multiples of the cell: a finer grid has the same body.
struct IncisedBlock {
    Vec3 size { 60.0, 40.0, 20.0 };
    double cell = 5.0;
    double length = 30.0, depth = 10.0; ///< of the cut
    double hook_width = 10.0, hook_height = 5.0; ///< one in the middle of each lip, from the skin down
};

mesh::TetMesh uncut_block(const IncisedBlock& block);
mesh::Blade incision_blade(const IncisedBlock& block);

struct Incision {
    mesh::TetMesh mesh; ///< four-node
    std::vector<mesh::LipFace> lips; ///< ids of `mesh`
    mesh::CutReport report;
};
/// @throws SolverError when the cut is not made.
Incision incise(const mesh::TetMesh& mesh, const mesh::Blade& blade, const mesh::CutOptions& options = {});

/// Held at the bottom; the hooks of side +1 and -1 each draw their lip by `pull`, mirrored for side -1.
/// @param nodes_per_tet 4, or 10: midpoints are added, on hooks and supports too.
fem::ElasticProblem hooked_open(const IncisedBlock& block, const Incision& incision, const fem::Material& tissue,
    const Vec3& pull, int nodes_per_tet = 4);

/// A session's mesh as it is now, with what holds it, vertices numbered anew. Hooks keep those of theirs that live; one
/// that is drawn by a force holds nothing still, and is left out.
fem::ElasticProblem problem_now(const mesh::CutSession& session, const std::vector<fem::Material>& material_of_label,
    const fem::Supports& supports, const std::vector<fem::OnlineHook>& hooks);

/// Which side of the cut's plane a vertex belongs to, +1 or -1; 0 where it is not on the plane or tissue of both sides
/// meets.
std::vector<int> sides_of_cut(const IncisedBlock& block, const mesh::TetMesh& mesh);

} // namespace retractor::verification
