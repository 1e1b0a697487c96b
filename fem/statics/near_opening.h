#pragma once
// Openings whose far field is linear (nonlinear_region.h), as plans want them: drawn from rest, brought to equilibrium,
// and with the linear far field judged. Where ribs swing it is wrong by much, and may even turn elements over; there
// the whole is solved nonlinearly from where it was still good. Units mm, N.

#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening_types.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <functional>
#include <span>

namespace retractor::fem {

/// Hooks drawn in steps, as a hand would: tissue that has more than one rest comes to the one on the way.
struct DragInSteps {
    double step_mm = 3.0; ///< the longest; of a hook that a force draws, as foretold at the beginning
    int least_steps = 1;
    double refresh_above = 0.05; ///< residual above which a new factor is made, at most three times a step
    std::function<bool(const NearFrame& frame, double share)> keep_going {}; ///< asked after each step
};

/// @param from where the hooks are. Ends where they stop short, where keep_going says no, and when cancelled.
/// @return the last frame.
NearFrame drag_in_steps(NonlinearRegion& field, std::span<const HookDrive> from, std::span<const HookDrive> to,
    const DragInSteps& how, const Job& job);

/// Opening::open() for OpeningOptions::near, without what is measured on the deformed elements.
/// @throws as NonlinearRegion's constructor.
OpeningResult open_near(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
    const Supports& supports, std::span<const HookPatch> hooks, const OpeningOptions& options, const Job& job);

} // namespace retractor::fem
