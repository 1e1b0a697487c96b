#pragma once
// Settings of repeated attempts at a stroke. The first attempt follows CutOptions alone. When an attempt breaks a
// guarantee (an element without volume, lips that stay connected, a wound that ends short of the blade), the attempt is
// taken back and repeated with less freedom. When no attempt succeeds, the stroke is refused. Units mm.

#include "mesh/base/error.h"
#include "mesh/cutting/stroke/cut_marks.h"

#include <string>

namespace retractor::mesh {

/// Settings that make a stroke more conservative than its options.
struct StrokeSettings {
    int attempt = 1; ///< number of the attempt, from 1
    double snap = 1.0; ///< factor on CutOptions::snap
    double crease_deg = 180.0; ///< upper limit on CutOptions::crease_deg
    /// Limit for halving crossed elements, as a share of the local edge. An element is halved when chords between the
    /// points at which the blade crosses its edges lie farther from the blade than this limit. 0: never.
    double chord = 0.0;
    /// True: rays at the ends of the blade become edges where the bend to the blade's extension is large enough.
    bool past_ends = false;
    double border = 1.0; ///< factor on the tolerance within which a vertex counts as on a border
    double on_blade = kOnBlade; ///< share of the blade's size within which a vertex counts as on the blade
};

/// A stroke that breaks a guarantee. The kind tells the next attempt which settings to change.
class CutQualityError : public SolverError {
public:
    /// Element or lip without proper shape; wound short of or off the blade; too many elements.
    enum class Kind { shape, extent, growth };
    CutQualityError(Kind kind, const std::string& what, std::string where);
    Kind kind() const { return kind_; }

private:
    Kind kind_;
};

/// Largest number of attempts at a stroke.
inline constexpr int kMostAttempts = 6;

/// The settings of the next attempt after an attempt that failed for this reason. Elements without volume and lips that
/// stay connected come from moved vertices, or from slivers at vertices that the blade grazes. A wound that ends short
/// of the blade comes from bends that chords span, and from borders that were only nearly reached. The first retries
/// follow more bends; later retries halve elements where the blade bends or twists within them; the last attempt
/// follows every bend when the failure before was the extent.
/// @pre kind != growth (too many elements): other settings make more elements, so that such a stroke is refused at once
StrokeSettings settings_of_retry(const StrokeSettings& settings, CutQualityError::Kind kind);

/// Guaranteed largest distance of a wound from the blade, as a share of the local edge (mean edge of the element of the
/// first mesh).
inline constexpr double kLargestBladeDeviation = 0.1;

/// Limit that an attempt is tested with, as a share of the local edge. The limit is below kLargestBladeDeviation,
/// because the test looks at samples only; the last attempt has a slightly larger limit.
double largest_blade_deviation(const StrokeSettings& settings);

/// Message for a wound off the blade, such as "the wound would lie more than 0.09 local edges off the blade".
std::string quality_message(const std::string& would, double most, const std::string& how);

/// The error of a stroke that is refused after `attempts` attempts, with a hint for the user. An error of kind growth
/// is returned unchanged, because it already contains the hint and no further attempt was made.
CutQualityError final_error(const CutQualityError& broken, int attempts);

} // namespace retractor::mesh
