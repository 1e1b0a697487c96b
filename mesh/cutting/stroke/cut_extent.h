#pragma once
// Tests whether a wound reaches as far as its blade: the blade is sampled after the lips are separated, and where a
// sample lies in tissue a wound must be near. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <array>
#include <functional>
#include <span>

namespace retractor::mesh {

/// An element that the blade crosses although the stroke is done.
struct UncutElement {
    std::array<Vec3, 4> corners;
    double local_edge = 0.0; ///< mm
};

/// Mean local edge (mm) of the elements round the wound; 0 without a cut. Each face counts with the smallest local edge
/// round one of its corners, because the order of a star depends on attempts that were taken back.
double wound_edge(const StrokeState& stroke);

/// Tests the blade from `from` to `to` (mm along its line) after the lips are separated: where the blade is in tissue,
/// a wound must be near. The test leaves out tissue thinner than the permitted errors of the wound and the surface:
/// places where the blade reaches less than 0.1 local edges into the tissue, and places within 0.05 local edges of the
/// surface, which moves may carry that far.
/// @param left elements that the blade still crosses. On a flat blade the test looks only at these elements and at the
/// borders, to which corners may have been moved from nearby. A bent blade may dip into elements with all corners on
/// one side.
/// @param settings gives the permitted distance (in local edges) of the nearest wound, and the density of samples
/// @param poll called before each column of samples; may throw
/// @throws CutQualityError (extent) with the place
void check_extent(const StrokeState& stroke, std::span<const UncutElement> left, const StrokeSettings& settings,
    double from, double to, const std::function<void()>& poll);

} // namespace retractor::mesh
