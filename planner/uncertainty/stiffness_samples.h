#pragma once
// Samples of the stiffness of tissues and springs over their published ranges, and what comes of them.

#include "planner/case/stiffness_factors.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace retractor::planner {

/// Samples by a Latin hypercube (McKay, Beckman, Conover 1979, Technometrics 21:239): each range is divided into as
/// many equal parts as there are samples, in the logarithm, and every part is drawn from once. The range of a tissue is
/// as wide as the published one (published_range()), about the value of the case.
/// @throws InputError when there are no samples
std::vector<StiffnessFactors> sample_stiffness(const Case& planned_case, int samples, unsigned seed);

/// Median and the interval that holds nine of ten values; each of them is one of the values.
struct Spread {
    double median = 0.0, low = 0.0, high = 0.0;
    std::size_t count = 0;
};
/// Nothing without values.
std::optional<Spread> spread_of(std::vector<double> values);

/// How often the order of approaches by their scores survives.
struct Survival {
    std::size_t samples = 0; ///< with a score of every approach
    std::size_t same_leader = 0; ///< the approach with the highest score is the same
    std::size_t same_order = 0;
};
/// @param reference score of each approach with the case's own values
/// @param samples scores of each approach in each sample; nothing: it could not be planned or must not be used
Survival survival_of(
    std::span<const std::optional<double>> reference, std::span<const std::vector<std::optional<double>>> samples);

} // namespace retractor::planner
