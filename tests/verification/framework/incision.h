#pragma once
// A block with an incision that two hooks hold open, for the extreme cases and the ladder of solvers. Units mm.

#include "fem/interactive/online_hook.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/store/blade.h"

#include <vector>

namespace retractor::verification {

/// A block whose cut runs straight down along x through the middle of the top. The cut and the hooks lie on planes of
/// the grid when all sizes are multiples of the cell, so a finer grid has the same body.
struct IncisedBlock {
    Vec3 size { 60.0, 40.0, 20.0 };
    double cell = 5.0;
    double length = 30.0, depth = 10.0; ///< length and depth of the cut
    double hook_width = 10.0, hook_height = 5.0; ///< size of the hook in the middle of each lip, from the skin down
};

mesh::TetMesh uncut_block(const IncisedBlock& block);
mesh::Blade incision_blade(const IncisedBlock& block);

struct Incision {
    mesh::TetMesh mesh; ///< four-node
    std::vector<mesh::LipFace> lips; ///< faces of the lips, with ids of `mesh`
    mesh::CutReport report;
};
/// @throws SolverError when the cut fails.
Incision incise(const mesh::TetMesh& mesh, const mesh::Blade& blade, const mesh::CutOptions& options = {});

/// The opened incision: held at the bottom, with a hook on each lip. The hook of side +1 moves by `pull`, the hook of
/// side -1 by the mirror image of `pull`.
/// @param nodes_per_tet 4, or 10 with midpoints also on hooks and supports.
fem::ElasticProblem hooked_open(const IncisedBlock& block, const Incision& incision, const fem::Material& tissue,
    const Vec3& pull, int nodes_per_tet = 4);

/// The present mesh of a session with supports and hooks, vertices renumbered. Hooks keep their living vertices. A
/// hook that pulls with a force is left out, because it prescribes no displacement.
fem::ElasticProblem problem_now(const mesh::CutSession& session, const std::vector<fem::Material>& material_of_label,
    const fem::Supports& supports, const std::vector<fem::OnlineHook>& hooks);

/// The side (+1 or -1) of the cut's plane to which a vertex belongs; 0 for a vertex off the plane, or where tissue of
/// both sides meets.
std::vector<int> sides_of_cut(const IncisedBlock& block, const mesh::TetMesh& mesh);

} // namespace retractor::verification
