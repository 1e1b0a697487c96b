#pragma once
// How far each lip of an opened wound follows its hooks or blade. Units mm; frame patient LPS.
//
// The line of a lip's hooks joins the places where the hooks stand on the skin's edge, moved as the hooks have moved,
// and goes on straight across the pull beyond the first and the last hook; the line of a blade is straight as a whole.
// The deviation at a place along the incision is the distance of the lip's skin edge from this line, in the direction
// of the pull. The numbers are taken over the middle part of the incision in which the templates place hooks, so that
// two, four and eight hooks and blades compare.

#include "planner/measures/field_metrics.h"
#include "planner/plan/planned_field.h"

#include <span>
#include <vector>

namespace retractor::planner {

/// Where a hook stands on the edge of its lip.
struct LipHook {
    double along_mm = 0.0; ///< place along the incision
    Vec3 place = Vec3::Zero(); ///< the same place of the incision, moved with the hook, mm
    Vec3 outward = Vec3::UnitX(); ///< unit vector of the pull
};

/// @param lip the opened edge of the lip
/// @param hooks of this lip, in any order; at least one
/// @param from_mm, to_mm ends of the part over which the numbers are taken
/// @throws InputError on fewer than two points, on points and parameters of different numbers, a parameter that
/// decreases, coordinates that are not finite, and ends that enclose nothing of the lip
LipDeviation lip_deviation(const LipLine& lip, std::span<const LipHook> hooks, int side, double from_mm, double to_mm);

/// The deviations of the field's lips, side +1 first. A lip without a hook has none, nor has a lip of which nothing is
/// left in the middle part of the incision. @pre the field's wound is opened
std::vector<LipDeviation> lip_deviations(const PlannedField& field);

} // namespace retractor::planner
