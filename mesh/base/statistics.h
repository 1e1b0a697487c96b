#pragma once
// Order statistics of a range of numbers. No function interpolates: each result is one of the numbers.

#include "mesh/base/assert.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <ranges>
#include <utility>

namespace retractor {

/// The number at position `rank` (from 0) of the range sorted by `before`. Reorders the range (std::nth_element) in
/// linear time. @pre rank < size of the range
template <std::ranges::random_access_range Range, class Before = std::less<>>
auto value_of_rank(Range&& values, std::size_t rank, Before before = {})
{
    RETRACTOR_ASSERT(rank < static_cast<std::size_t>(std::ranges::size(values)));
    const auto at = std::ranges::begin(values) + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(std::ranges::begin(values), at, std::ranges::end(values), before);
    return *at;
}

/// The median; for an even count, the larger of the two middle numbers. Reorders the range. @pre the range is not empty
template <std::ranges::random_access_range Range> auto upper_median(Range&& values)
{
    return value_of_rank(values, static_cast<std::size_t>(std::ranges::size(values)) / 2);
}

/// The first item of a sorted range at which the sum of weights, the item's own included, reaches `share` of `total`.
/// Returns the end of the range when the sum stays below.
template <std::ranges::forward_range Range, class Weight>
auto weighted_percentile(const Range& sorted, double share, double total, Weight&& weight_of)
{
    double sum = 0.0;
    return std::ranges::find_if(sorted, [&](const auto& item) { return (sum += weight_of(item)) >= share * total; });
}

} // namespace retractor
