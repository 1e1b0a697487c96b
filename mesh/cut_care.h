#pragma once
// How carefully a stroke is made. The first attempt goes by CutOptions alone; when it breaks a promise (an element
// without volume, lips that hang together, a wound that stays short of the blade), it is taken back and made again with
// less freedom, and refused only when that does not help either. Units mm.

#include "mesh/base/error.h"
#include "mesh/cut_moves.h"

#include <array>
#include <functional>
#include <span>
#include <string>

namespace retractor {

/// A stroke that cannot be made as it is: why, for the next attempt to know.
class BrokenPromise : public SolverError {
public:
    enum class Kind { shape, extent, growth };
    BrokenPromise(Kind kind, const std::string& what, std::string where);
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
StrokeCare more_careful(const StrokeCare& care, BrokenPromise::Kind kind);

/// A wound keeps to the blade by this share of the local edge (the mean edge of the element of the first mesh).
inline constexpr double kPromisedOffBlade = 0.1;

/// By less than is promised, as what is looked at are samples; the last attempt is given a little more.
double most_off_blade(const StrokeCare& care);

/// What a wound that is off the blade is refused with: "the wound would lie more than 0.09 local edges off the blade".
std::string promise_broken(const std::string& would, double most, const std::string& how);

/// The refusal of a stroke that was given up after so many attempts: it says so, and what may help. One for its growth
/// is as it is: it says already what to change, and no further attempt was made.
BrokenPromise given_up(const BrokenPromise& broken, int attempts);

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
/// @throws BrokenPromise (extent) with the place.
void check_extent(const StrokeState& stroke, std::span<const CrossedStill> left, const StrokeCare& care, double from,
    double to, const std::function<void()>& poll);

} // namespace retractor
