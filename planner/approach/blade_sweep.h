#pragma once
// How the blade passes the wall along the incision. Units mm; frame patient LPS.

#include "planner/case/approach.h"

#include <optional>
#include <string_view>

namespace retractor::planner {

/// Of the sentence in a rationale that says how deep the blade goes: "; the blade goes 38 mm deep."
inline constexpr std::string_view kBladeGoes = "; the blade goes ", kDeep = " mm deep";

/// The first place on the skin below which the blade folds over itself: its lower edge must run forwards everywhere.
std::optional<Vec3> fold_of(const Approach& approach);

/// @throws InputError naming the place where the blade folds over itself
void check_sweep(const Approach& approach);

} // namespace retractor::planner
