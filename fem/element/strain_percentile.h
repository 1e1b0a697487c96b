#pragma once

namespace retractor::fem {

/// The strain that stands for a whole mesh is this percentile by volume. The largest strain of all elements has no
/// limit under refinement, at the rims of hooks and at the ends of a cut.
inline constexpr double kStrainPercentile = 0.99;

} // namespace retractor::fem
