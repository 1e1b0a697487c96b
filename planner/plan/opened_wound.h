#pragma once
// The cut wall of a planned field, opened by its hooks, and what a plan's numbers are then taken from. Units mm, N;
// frame patient LPS.

#include "fem/statics/driven_opening.h"
#include "fem/statics/opening_types.h"
#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// The wall of a field, opened once.
struct OpenedWall {
    Eigen::VectorXd ten_node {}; ///< as solved, at all nodes; of four-node elements: empty
    std::vector<fem::HookPatch> hooks; ///< where they are
    std::vector<bool> yielded; ///< per hook, where some do not simply go where they are told
    std::size_t near_tets = 0; ///< nonlinear ones, where the rest was to be linear
    fem::OpeningResult opening; ///< displacements of the wall's vertices, without midpoints
};

/// What move_rigid_pieces() adds after the wound is solved: the pieces, and the answer without it.
struct RigidPieces {
    std::vector<std::vector<VertexId>> vertices;
    Points solved; ///< the displacement in which they are held; empty when there are none
};

/// How the opening of a field was found, for those that judge it.
struct OpenedWound {
    RigidPieces rigid;
    std::optional<fem::ContactOptions> contact; ///< it was solved with
    Eigen::VectorXd ten_node {}; ///< the answer of ten-node elements at all their nodes; of four-node ones: empty
};

/// What a plan's numbers are taken from.
struct WoundAnswer {
    Points displacement {}; ///< of the wall's vertices
    std::vector<Vec3> hook_forces_N {};
    std::vector<Vec3> hooks_mm {}; ///< how far the hooks moved; empty: as far as the field says
};

/// Opening and forces of an answer.
struct WoundMeasures {
    double width_mm = 0.0, area_mm2 = 0.0;
    std::array<double, 2> side_N {}; ///< sums over the hooks of sides +1 and -1

    double larger_side_N() const { return std::max(side_N[0], side_N[1]); }
};

/// Whether the wound is a state that tissue can be in: at rest, and with no more than a few slivers turned over.
bool is_usable(const fem::OpeningResult& opening);

bool has_linear_condensed_region(const PlannedField& field);

/// Near the lips, and whatever a hook holds: per element of field.problem.
std::vector<std::uint8_t> near_elements(const PlannedField& field, double near_mm);

/// Of the approach's hooks; empty where all of them simply go where they are told.
std::vector<fem::HookDrive> drives_of(const Approach& approach);

/// The job for one more opening of a wound: what it reports comes under that name, so that the stage of the plan's own
/// opening does not begin again. @pre `job` outlives it.
Job as_stage(const Job& job, std::string stage);

fem::OpeningOptions opening_options(const SolverSettings& choice);

/// @param near_mm nonlinear within this distance of the lips and linear beyond; 0: the same everywhere.
/// @param drives empty: the hooks go where field.problem says. @throws as fem::Opening does.
OpenedWall open_wall(const PlannedField& field, double near_mm, std::span<const fem::HookDrive> drives,
    fem::OpeningOptions options, const Job& job);

/// Opens the cut wall as the case's solution says, and fills in what of the field comes of it: problem, opening, where
/// the hooks came to rest, status (opening.message says why). @throws as open_wall().
OpenedWound open_wound(PlannedField& field, Patient& patient, const mesh::LabelVolume& labels,
    std::span<const Label> fixed_labels, CutWall cut, const Job& job);

/// Per hook, whether it pushes, to hold a lip that would go farther without it: its force is mostly against its
/// direction, and more than nothing beside the largest hook's. @pre one force per hook.
std::vector<bool> pushing_hooks(const Approach& approach, const std::vector<Vec3>& forces_N);

/// Sums of the sizes of forces, one per hook of the field, over sides +1 and -1. Hooks that push in the field's opening
/// pull nothing, in other answers of it neither: one that is near to that would change sides as a whole.
std::array<double, 2> side_forces(const PlannedField& field, const std::vector<Vec3>& forces_N);

/// @param displacement of the wall's vertices; rigid pieces are moved to where it takes them.
WoundMeasures measures_of(
    const PlannedField& field, const RigidPieces& rigid, Points& displacement, const std::vector<Vec3>& hook_forces_N);

/// Of the field as it was measured.
WoundMeasures measures_of(const PlannedField& field);

} // namespace retractor::planner
