#pragma once
// Plans an approach on finer and finer meshes, until its error bars are as small as asked or a limit ends the search.
// The bars are those of the discretisation (planner/plan/error_bars.h). Units mm, N, s; forces as fractions.

#include "planner/case/solver_settings.h"
#include "planner/measures/field_metrics.h"
#include "planner/plan/planned_field.h"

#include <functional>
#include <optional>

namespace retractor::planner {

/// All edges of a mesh are this multiple of those of the mesh before, so that it has about twice the tetrahedra.
inline constexpr double kEdgeRefinement = 0.8;
/// Most meshes of a search: the last one has half the edges of the first.
inline constexpr int kMostAccuracyRounds = 4;

/// One plan, with all edges of the mesh times this factor, 1 or less.
using PlanRound = std::function<PlannedField(double edge_factor)>;

/// A search for an accuracy.
struct AccuracySearch {
    AccuracyGoal goal {};
    ElementKind element = ElementKind::p1; ///< of the plans
    std::optional<double> memory_bytes {}; ///< memory that a plan may take; not set: not known, and no limit
    std::function<double()> elapsed_s; ///< seconds since the search began
};

/// Half-widths of a plan's error bars, as far as the accuracy is judged by them.
struct ReachedAccuracy {
    std::optional<double> force {}; ///< over the force; not set: the force is prescribed, yielded or missing
    std::optional<double> opening_mm {}; ///< not set: the plan has no error bars, and `force` is not set either
};

/// The accuracy of a plan by its error bars.
ReachedAccuracy reached_accuracy(const FieldMetrics& field);

/// Whether both bars are as small as asked. Without bars the answer is no.
bool meets(const ReachedAccuracy& reached, const AccuracyGoal& goal);

/// Plans with the given edges first, and then with finer ones until the goal is met.
///
/// The next mesh is not tried when its forecast (plan_forecast.h), scaled by the time that the last mesh took, goes
/// beyond the goal's time, or beyond the memory. A mesh that is refused, or gives no equilibrium, ends the search too.
/// A plan whose first mesh gives no equilibrium is not tried again, because finer meshes hardly open farther.
///
/// @return the answer with the smallest relative bar of the force (of the opening, where the force is not judged), with
/// FieldMetrics::accuracy filled. A cancelled field as soon as one round is cancelled; the first field as it is when it
/// was not measured.
/// @throws whatever the first round throws; errors of later rounds other than InputError and SolverError
/// @pre search.elapsed_s and plan are set
PlannedField plan_to_accuracy(const AccuracySearch& search, const PlanRound& plan);

} // namespace retractor::planner
