#pragma once
// Solves the largest opening at which no bone reaches its capacity. bone_limits.h estimates this opening in proportion
// to the moment, but tissue and bones turn as they open, and moments do not grow in proportion. Here the opened wound
// is opened again, less far, from a start that is scaled from the solution at hand, until the most loaded bone is just
// below its capacity. Units mm, N; shares as fractions.

#include "planner/anatomy/anatomy.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/planned_field.h"

#include <functional>
#include <optional>
#include <string>

namespace retractor::planner {

/// The utilisation (moment over capacity) that the search accepts: just below the capacity.
inline constexpr double kLeastFullUse = 0.95, kMostFullUse = 1.0;

/// The state of the wound at a share of its opening.
struct UseAtShare {
    double share = 0.0; ///< of the opening, 0 to 1
    double use = 0.0; ///< largest utilisation of a bone
};

/// Finds the share of an opening at which the largest utilisation lies between kLeastFullUse and kMostFullUse, by the
/// secant between the nearest shares on both sides.
/// @param use_at the utilisation at a share; nothing where there is no answer, which ends the search
/// @param full the utilisation at the whole opening, above 1
/// @returns the largest share whose utilisation is at most 1; nothing when none was found
std::optional<UseAtShare> find_full_use(
    double full, int most_solves, const std::function<std::optional<double>(double share)>& use_at);

/// Solves the largest uninjured opening of a field that is attainable with injury, and sets
/// FieldMetrics::uninjured_opening and largest_uninjured_opening_mm.
/// @pre the field's bones are measured
void solve_uninjured_opening(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const mesh::LabelTable& table, const AnatomicalFrame& frame, const Job& job);

/// The approach with the most loaded bone divided: a ball of this bone, about as wide as the bone is high, is taken out
/// where its moment is nearest to its capacity. The name is that of the approach with " (rib_left_4 divided)".
/// @param field of this approach, attainable with injury; its mesh sizes are kept
/// @returns nothing for a field that is not attainable with injury
std::optional<Approach> with_divided_bone(const Approach& approach, const PlannedField& field);

} // namespace retractor::planner
