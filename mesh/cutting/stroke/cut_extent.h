#pragma once
// Whether a wound reaches as far as the blade that made it: the blade is sampled after the lips are parted, and where
// it lies in tissue a wound must be near. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <array>
#include <functional>
#include <span>

namespace retractor::mesh {

/// An element that the blade is seen to cross though the stroke is done.
struct CrossedStill {
    std::array<Vec3, 4> corners;
    double local_edge = 0.0;
};

/// Mean local edge (mm) of the elements the wound is in: of each face the smallest round one of its corners, as the
/// order of a star depends on what was tried and taken back before. 0 where nothing is cut.
double wound_edge(const StrokeState& stroke);

/// Looks at the blade from `from` to `to` (mm along its line) after the lips are parted: is there a wound wherever it
/// is in tissue? Left out is tissue thinner than what the wound or the surface may be off: a blade that reaches less
/// than 0.1 local edges into it, and what is within 0.05 local edges of the surface, which may be carried so far.
/// @param left what the blade still crosses: on a flat blade only that is looked at, and its borders, to which corners
/// may
///   have been taken from nearby; a bent one may dip into elements with all corners on one side
/// @param care says how many local edges the next wound may be away, and how closely to look
/// @param poll called before each column of samples; may throw
/// @throws CutQualityError (extent) with the place.
void check_extent(const StrokeState& stroke, std::span<const CrossedStill> left, const StrokeSettings& care,
    double from, double to, const std::function<void()>& poll);

} // namespace retractor::mesh
