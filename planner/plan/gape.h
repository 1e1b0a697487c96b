#pragma once
// Computes the gape of a planned wound: its opening by the tension of the tissue alone, before any hook pulls. Units
// mm.

#include "planner/plan/opened_wound.h"

#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The materials of the problem's mesh that are under tension before the cut, each once, with the pre-strain.
std::vector<std::pair<std::string, fem::PreStrain>> tissues_under_tension(const fem::ElasticProblem& problem);

/// Solves the wound again in the same way, without hooks. A wound that has no hooks gives its own solution. When there
/// is no gape (a piece held only by hooks, a cancelled job), the result holds the reason instead of an exception.
/// @param wound the opened and measured wound of the field
TensionMetrics measure_gape(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
