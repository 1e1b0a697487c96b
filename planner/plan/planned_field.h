#pragma once
// The planned field: what plan_approach() (plan.h) makes of one approach, and what the steps of a plan pass on to one
// another. Plain data. Units mm, N; frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening_types.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/case/approach.h"
#include "planner/measures/exposure.h"
#include "planner/measures/field_metrics.h"
#include "planner/wall/field_geometry.h"
#include "planner/wall/wall_cut.h"

#include <string>
#include <vector>

namespace retractor::planner {

enum class PlanStatus {
    done,
    nothing_to_mesh, ///< no wall tissue near the incision
    cut_missed, ///< the blade does not meet the wall
    not_converged, ///< the wound could not be pulled open as asked; what was reached is measured
    inverted, ///< pulled open as asked, but with more than two elements of 1,000 inside out: measured, and wrong
    cancelled,
};

/// The planned field. With a status other than done, not_converged or inverted only `message` is
/// filled; with one of these it holds remarks, such as parts left out of the mesh.
struct [[nodiscard]] PlannedField {
    PlanStatus status = PlanStatus::done;
    std::string message;
    Approach approach;
    mesh::MeshStatistics mesh_statistics;

    mesh::TetMesh wall; ///< cut, at rest
    std::vector<mesh::LipFace> lips; ///< faces of `wall` on the two sides of the incision
    std::vector<WallPiece> pieces; ///< of `wall`, with what holds them
    std::vector<fem::HookPatch> hooks; ///< in the order of approach.hooks; nodes of `wall`; where they came to rest
    /// What the solver was given: `wall` with its materials, supports and hooks; of ten-node elements, midpoints last.
    fem::ElasticProblem problem;
    std::vector<bool> yielded; ///< per hook: held back by its limit; empty where all go where they are told
    fem::OpeningResult opening; ///< displacements of the vertices of `wall`
    OpeningGeometry geometry; ///< of the opened wound
    Exposure exposure;

    TriMesh remaining_wall; ///< beyond the meshed region, see unmeshed_wall_region(); may be empty
    FieldMetrics metrics;
};

} // namespace retractor::planner
