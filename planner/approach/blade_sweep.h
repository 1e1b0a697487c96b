#pragma once
// How the blade passes the wall along the incision. Units mm; frame patient LPS.

#include "planner/case/approach.h"

#include <optional>

namespace retractor::planner {

/// The first place on the skin below which the blade folds over itself: its lower edge must run forwards everywhere.
std::optional<Vec3> fold_of(const Approach& approach);

/// @throws InputError naming the place where the blade folds over itself
void check_sweep(const Approach& approach);

} // namespace retractor::planner
