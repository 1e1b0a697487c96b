#pragma once
// Opening with a nonlinear region near the wound and linear tissue beyond (nonlinear_region.h), for plans. The hooks
// are drawn from rest, the body comes to equilibrium, and the error of the linear region is estimated. Where ribs
// swing, the linear region has a large error and elements may turn over. The whole body is then solved nonlinearly,
// from the last good state. Units mm, N.

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

/// Draws hooks in steps, as a hand would. Tissue with more than one equilibrium then reaches the equilibrium on this
/// path.
struct DragInSteps {
    /// Longest step; for a hook that pulls with a force, measured on the displacement predicted at the start.
    double step_mm = 3.0;
    int least_steps = 1;
    double refresh_above = 0.05; ///< residual above which the factor is renewed, at most three times per step
    /// Called after each step; false ends the drag.
    std::function<bool(const NearFrame& frame, double share)> keep_going {};
};

/// Draws the hooks in steps. The drag ends early where the hooks stop short, where keep_going returns false, and when
/// the job is cancelled.
/// @param from present drives of the hooks
/// @return the last frame
NearFrame drag_in_steps(NonlinearRegion& field, std::span<const HookDrive> from, std::span<const HookDrive> to,
    const DragInSteps& how, const Job& job);

/// Implements Opening::open() for OpeningOptions::near, without the measures on deformed elements.
/// @throws InputError on a hook that turns, and as the constructor of NonlinearRegion
OpeningResult open_near(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
    const Supports& supports, std::span<const HookPatch> hooks, const OpeningOptions& options, const Job& job);

} // namespace retractor::fem
