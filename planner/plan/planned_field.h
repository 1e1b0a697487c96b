#pragma once
// The planned field: the result of plan_approach() (plan.h) for one approach, and the data that the steps of a plan
// pass on. Plain data. Units mm, N; frame patient LPS.

#include "fem/statics/blade_frame.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening_types.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/case/approach.h"
#include "planner/measures/field_metrics.h"
#include "planner/measures/sight/exposure.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/wall/field_geometry.h"
#include "planner/wall/wall_cut.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

enum class PlanStatus {
    done,
    nothing_to_mesh, ///< no wall tissue near the incision
    cut_missed, ///< the blade does not meet the wall
    not_converged, ///< the wound did not open as far as requested; the numbers describe what was reached
    /// The wound opened as requested, but more than two elements in 1,000 are inverted; the numbers are wrong.
    inverted,
    cancelled,
};

/// The retractor that opened the field, in balance.
struct PlacedRetractor {
    fem::BladeFrame frame;
    fem::FrameState state;
    std::array<fem::BladeLoad, 2> loads; ///< that the retractor applies to the tissue, in the order of the hooks
    fem::FrameMatrix stiffness = fem::FrameMatrix::Zero(); ///< of the frame in this tissue, N/mm
    double residual_force_N = 0.0; ///< magnitude of the resultant of the blade forces
    double residual_moment_Nmm = 0.0; ///< magnitude of the resultant moment about the frame's centre
    /// A hand or an arm at the table holds the frame's direction and bears the resultant moment, because the free frame
    /// found no balance.
    bool direction_is_held = false;
    double rack_force_N = 0.0; ///< along the rack at each blade
    int openings = 0; ///< number of openings that the search took
};

/// The planned field. With the status done, not_converged or inverted, `message` holds remarks, such as parts left out
/// of the mesh. With any other status only `message` is filled.
struct [[nodiscard]] PlannedField {
    PlanStatus status = PlanStatus::done;
    std::string message;
    Approach approach;
    mesh::MeshStatistics mesh_statistics;

    bool ended_by_time = false; ///< the opening's search was ended (PlanChecks::opening_time_s)
    bool contact_was_lost = false; ///< the blades hold the tissue, because their contact had no equilibrium
    mesh::TetMesh wall; ///< after the cut, at rest
    std::vector<mesh::LipFace> lips; ///< faces of `wall` on the two sides of the incision
    std::vector<Vec3> rim; ///< places at rest where the wall was cut off from the rest of the body (rim_motion.h)
    std::vector<WallPiece> pieces; ///< pieces of `wall`, with their supports
    std::vector<fem::HookPatch> hooks; ///< in the order of approach.hooks, with nodes of `wall`, at their final places
    /// The problem that the solver was given: `wall` with its materials, supports and hooks. Midpoints of ten-node
    /// elements come last.
    fem::ElasticProblem problem;
    /// Whether each hook is held back by its force limit; empty where all hooks reach their places.
    std::vector<bool> yielded;
    std::optional<PlacedRetractor> retractor {}; ///< where approach.retractor is set; its blades are the hooks
    fem::OpeningResult opening; ///< with displacements of the vertices of `wall`
    OpeningGeometry geometry; ///< shape of the opened wound
    SurgeonEye best_eye;
    Exposure exposure; ///< of all eyes of the cone

    TriMesh remaining_wall; ///< the wall outside the meshed region, see unmeshed_wall_region(); may be empty
    FieldMetrics metrics;
};

/// Whether the field has a wound and numbers to show.
inline bool is_measured(const PlannedField& field)
{
    return field.status == PlanStatus::done || field.status == PlanStatus::not_converged
        || field.status == PlanStatus::inverted;
}

} // namespace retractor::planner
