#pragma once
// How far a planned wound gapes by the tension of its tissue alone, before any hook pulls. Units mm.

#include "planner/plan/opened_wound.h"

#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The materials of the problem's mesh that are stretched before the cut, each once, with the pre-strain.
std::vector<std::pair<std::string, fem::PreStrain>> tissues_under_tension(const fem::ElasticProblem& problem);

/// Solves the wound once more as it was, without hooks; where it has none, its own answer is taken. Says why there is
/// no gape (a piece that only hooks hold) rather than throw.
/// @param wound of the field, which was opened and measured. A cancelled job is the field's status.
TensionMetrics measure_gape(
    PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
