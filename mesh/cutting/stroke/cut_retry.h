#pragma once
// How carefully a stroke is made. The first attempt goes by CutOptions alone; when it breaks a promise (an element
// without volume, lips that hang together, a wound that stays short of the blade), it is taken back and made again with
// less freedom, and refused only when that does not help either. Units mm.

#include "mesh/base/error.h"
#include "mesh/cutting/stroke/cut_marks.h"

#include <string>

namespace retractor::mesh {

/// What makes a stroke more conservative than its options.
struct StrokeSettings {
    int attempt = 1;
    double snap = 1.0; ///< share of CutOptions::snap
    double crease_deg = 180.0; ///< CutOptions::crease_deg at most
    /// Crossed elements are halved where chords between the points at which the blade crosses their edges lie further
    /// off it than this share of the local edge; 0: never.
    double chord = 0.0;
    bool past_ends = false; ///< rays at the ends of the blade are followed where the bend to its extension asks for it
    double border = 1.0; ///< share of the tolerance within which a vertex is taken to be on a border
    double on_blade = kOnBlade; ///< share of the blade's size within which a vertex is taken to be on it
};

/// A stroke that cannot be made as it is: why, for the next attempt to know.
class CutQualityError : public SolverError {
public:
    enum class Kind { shape, extent, growth };
    CutQualityError(Kind kind, const std::string& what, std::string where);
    Kind kind() const { return kind_; }

private:
    Kind kind_;
};

/// Attempts at one stroke in all.
inline constexpr int kMostAttempts = 6;

/// The setting of the next attempt, after one that failed for this reason: elements without volume, or lips that hang
/// together, come from what was snapped, or from slivers at vertices that the blade grazes; a wound that stays short
/// of the blade comes from bends that are spanned by chords, and from borders that were only nearly reached. More bends
/// are followed at first; then elements are halved where the blade bends or twists within them; the last attempt
/// follows every bend, if what failed before it was the extent.
/// @pre not `growth` (too many elements): more care makes more of them, so such a stroke is refused at once.
StrokeSettings settings_of_retry(const StrokeSettings& care, CutQualityError::Kind kind);

/// A wound keeps to the blade by this share of the local edge (the mean edge of the element of the first mesh).
inline constexpr double kLargestBladeDeviation = 0.1;

/// By less than is promised, as what is looked at are samples; the last attempt is given a little more.
double largest_blade_deviation(const StrokeSettings& care);

/// What a wound that is off the blade is refused with: "the wound would lie more than 0.09 local edges off the blade".
std::string quality_message(const std::string& would, double most, const std::string& how);

/// The refusal of a stroke that was given up after so many attempts: it says so, and what may help. One for its growth
/// is as it is: it says already what to change, and no further attempt was made.
CutQualityError given_up(const CutQualityError& broken, int attempts);

} // namespace retractor::mesh
