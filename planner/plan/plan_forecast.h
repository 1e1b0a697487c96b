#pragma once
// Forecasts time and memory of a plan from the expected number of its tetrahedra (mesh/generation/mesh_forecast.h), and
// the largest mesh that a given memory can hold. Bytes and seconds; both are rough.

#include "mesh/base/error.h"
#include "planner/case/solver_settings.h"

#include <optional>
#include <string>

namespace retractor::planner {

struct PlanForecast {
    double tetrahedra = 0.0;
    double seconds = 0.0; ///< from the labels to the error bars
    double bytes = 0.0; ///< most memory at one time
};

/// Time and memory of one plan with error bars.
/// Locking-free elements count as ten-node elements, since their matrix has many more entries than that of other
/// four-node elements. This is not measured.
/// @pre tetrahedra >= 0 and finite
PlanForecast forecast_plan(double tetrahedra, ElementKind element);

/// The most tetrahedra whose plan fits into this memory: the inverse of forecast_plan(). 0 when even a plan without
/// tetrahedra does not fit.
double most_tetrahedra(double bytes, ElementKind element);

/// The limit for MeshSizing::most_tetrahedra: most_tetrahedra(), but at least 1, since 0 means no limit there.
/// @param bytes not set: the memory is not known, and there is no limit
double tetrahedra_limit(std::optional<double> bytes, ElementKind element);

/// "about 57,000 tetrahedra, about 70 s, 1.7 GiB".
std::string forecast_text(const PlanForecast& forecast);

/// A plan needs more memory than there is.
class MemoryRefusal : public InputError {
public:
    using InputError::InputError;
};

/// Refuses a plan that does not fit into the memory.
/// @param bytes memory that the plan may take; not set: not known, and nothing is refused
/// @throws MemoryRefusal naming what the plan needs, what there is, and the field corridor_edge_mm
void check_memory(const PlanForecast& forecast, std::optional<double> bytes);

} // namespace retractor::planner
