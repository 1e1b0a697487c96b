#pragma once
// Opens the cut wall of a planned field with its hooks, and measures opening and forces of a solution. Units mm, N;
// frame patient LPS.

#include "fem/statics/driven_opening.h"
#include "fem/statics/opening_types.h"
#include "planner/case/patient.h"
#include "planner/plan/contact_where_needed.h"
#include "planner/plan/opened_wall.h"
#include "planner/plan/planned_field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// The loose pieces that move_rigid_pieces() moves as rigid bodies after the wound is solved.
struct RigidPieces {
    std::vector<std::vector<VertexId>> vertices; ///< vertices of each piece
    /// Displacement of the wall's vertices before the pieces were moved, n x 3, mm; empty without pieces.
    Points solved;
};

/// Data of a field's opening that the error estimates need.
struct OpenedWound {
    RigidPieces rigid;
    std::optional<fem::ContactOptions> contact; ///< contact of the solution; empty: without contact
    std::optional<std::vector<std::string>> touchable {}; ///< as OpenedWall::touchable
    Eigen::VectorXd ten_node {}; ///< as OpenedWall::ten_node
    std::optional<fem::OpeningResult> coarse {}; ///< as OpenedWall::coarse
    Mat3 coarse_turn = Mat3::Identity(); ///< as OpenedWall::coarse_turn
};

/// A solution of the wound from which opening and forces are measured.
struct WoundSolution {
    Points displacement {}; ///< displacement of the wall's vertices, n x 3, mm
    std::vector<Vec3> hook_forces_N {}; ///< one per hook
    std::vector<Vec3> hooks_mm {}; ///< displacement of each hook; empty: as in the field
};

/// Opening and forces of a solution.
struct WoundMeasures {
    double width_mm = 0.0, area_mm2 = 0.0;
    std::array<double, 2> side_N {}; ///< sums of the force magnitudes over the hooks of sides +1 and -1

    double larger_side_N() const { return std::max(side_N[0], side_N[1]); }
};

/// Whether the field was solved with a linear condensed region.
bool has_condensed_region(const PlannedField& field);

/// Marks the elements of the nonlinear region: elements within near_mm of the lips, at a hook, or under a load.
/// @return 1 or 0 per element of field.problem
std::vector<std::uint8_t> near_elements(const PlannedField& field, double near_mm);

/// The drives of the approach's hooks; empty when all hooks prescribe their displacement, and with a retractor.
std::vector<fem::HookDrive> drives_of(const Approach& approach);

/// A job that reports its progress under the name `stage`. A further opening of the wound uses such a job, so that the
/// progress of the plan's own opening does not start again.
/// @pre `job` outlives the result
Job as_stage(const Job& job, std::string stage);

/// The options of an opening with these settings, without contact and without a condensed region.
fem::OpeningOptions opening_options(const SolverSettings& choice);

/// Opens the wall of field.problem once, with the approach's retractor where it has one and the problem has hooks.
/// @param near_mm tissue within this distance of the lips is nonlinear, and linear beyond; 0: the same law everywhere
/// @param drives empty: the hooks have the displacements of field.problem
/// @param start a solution of the same wall, without contact or with tissue of other stiffness, or one by four-node
/// elements that a test ended, from which the opening begins; nullptr: it begins at rest. Not used with drives, with
/// near_mm, and with contact where a hook holds nodes: these may collide on their way
/// @param goes_on asked between four-node and ten-node elements, where the opening begins with four-node elements;
/// empty: the opening goes on
/// @throws as fem::Opening
OpenedWall open_wall(const PlannedField& field, double near_mm, std::span<const fem::HookDrive> drives,
    fem::OpeningOptions options, const Job& job, const OpenedWall* start = nullptr, const StageTest& goes_on = {});

/// The solution at all nodes of field.problem, before loose pieces were moved, three per node.
Eigen::VectorXd displacement_at_nodes(const PlannedField& field, const OpenedWound& wound);
Eigen::VectorXd displacement_at_nodes(const OpenedWall& opened);

/// Opens the wound of an opened field again, to a share of its opening. The search begins at the same share of the
/// field's displacement. Hooks that were driven by forces, and yielded hooks, move the same share of their way.
/// @param share 0 to 1
/// @throws as open_wall(); @pre the whole wall has the same law (SolverSettings::near_mm is 0)
OpenedWall reopen_wall(
    const PlannedField& field, const OpenedWound& wound, double share, const SolverSettings& choice, const Job& job);

/// Solves the wound of field.problem. Where blades in contact find no equilibrium, they hold the tissue and the wound
/// is solved once more; the field's problem, its approach and PlannedField::contact_was_lost then say so. Where blades
/// that hold would bear far more than kImpossibleForceN (verdict.h), no such answer could be used, and none is made.
/// @param solve of field.problem as it is when called
/// @throws as `solve`
ContactOpening solve_or_hold(PlannedField& field, const std::function<ContactOpening()>& solve);

/// Opens the cut wall with the case's solver settings, and with contact where it is asked for or needed
/// (contact_where_needed.h). Fills in the field's problem, opening, final hook places,
/// yielded hooks, status (opening.message gives the reason) and the metrics of pressure, solution and contact.
/// @throws as open_wall()
/// @param start an opening of the same wall with tissue of other stiffness, from which the search begins where it can;
/// nullptr: it begins at rest
OpenedWound open_wound(PlannedField& field, Patient& patient, const mesh::LabelVolume& labels, CutWall cut,
    const Job& job, const OpenedWall* start = nullptr);

/// The same for another case of the same patient, with other solver settings.
OpenedWound open_wound(PlannedField& field, Patient& patient, const Case& planned_case, const mesh::LabelVolume& labels,
    CutWall cut, const Job& job, const OpenedWall* start = nullptr);

/// Ends a field whose opening was cancelled because its time was up. The state that the search had reached stays, of a
/// retractor the one nearest to balance, marked as not in equilibrium (PlanStatus::not_converged).
/// @param wound of the field; its rigid pieces are moved
/// @param why begins the field's mechanics message
/// @pre open_wound() gave this wound, and the field's status is PlanStatus::cancelled
void end_unfinished(PlannedField& field, OpenedWound& wound, const std::string& why);

/// The opening of a field, as another opening begins with it.
OpenedWall opened_wall_of(const PlannedField& field, const OpenedWound& wound);

/// Per hook, whether the hook pushes: the hook holds back a lip that would move farther without it. The force of such a
/// hook points mostly against the hook's direction and exceeds 0.1 % of the largest hook force.
/// @pre one force per hook
std::vector<bool> pushing_hooks(const Approach& approach, const std::vector<Vec3>& forces_N);

/// Sums of the force magnitudes over the hooks of sides +1 and -1, N. Hooks that push in the field's own opening are
/// left out, also in other solutions: otherwise a hook that only just pushes would enter or leave the sum as a whole.
/// @param forces_N one per hook of the field
std::array<double, 2> side_forces(const PlannedField& field, const std::vector<Vec3>& forces_N);

/// The field's problem with all hooks fixed (HookHold) at their final places, without the nodes of blades: for programs
/// without contact.
fem::ElasticProblem problem_with_fixed_hooks(const PlannedField& field);

/// Measures a solution of the field.
/// @param displacement of the wall's vertices, n x 3, mm; the function moves the rigid pieces in it
/// @param hook_forces_N one per hook of the field
WoundMeasures measures_of(
    const PlannedField& field, const RigidPieces& rigid, Points& displacement, const std::vector<Vec3>& hook_forces_N);

/// The measures of the field's own solution.
WoundMeasures measures_of(const PlannedField& field);

} // namespace retractor::planner
