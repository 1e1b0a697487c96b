#pragma once
// Order statistics of a range of numbers. None of the functions interpolates: the result is one of the numbers.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <ranges>
#include <utility>

namespace retractor {

/// The number that stands at `rank` when the range is sorted by `before`; rank 0 is the first.
/// Reorders the range (std::nth_element); takes time linear in its length. @pre rank < size of the range
template <std::ranges::random_access_range Range, class Before = std::less<>>
auto value_of_rank(Range&& values, std::size_t rank, Before before = {})
{
    const auto at = std::ranges::begin(values) + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(std::ranges::begin(values), at, std::ranges::end(values), before);
    return *at;
}

/// The median; of an even count the larger of the two numbers in the middle.
/// Reorders the range. @pre the range is not empty
template <std::ranges::random_access_range Range> auto upper_median(Range&& values)
{
    return value_of_rank(values, static_cast<std::size_t>(std::ranges::size(values)) / 2);
}

/// The first item of a sorted range at which the weights up to it, itself included, reach `share` of `total`; the
/// range's end where they do not.
template <std::ranges::forward_range Range, class Weight>
auto weighted_percentile(const Range& sorted, double share, double total, Weight&& weight_of)
{
    double sum = 0.0;
    return std::ranges::find_if(sorted, [&](const auto& item) { return (sum += weight_of(item)) >= share * total; });
}

} // namespace retractor
