#pragma once
// Exact confidence interval of a share (Clopper, Pearson 1934, Biometrika 26:404).

#include <cstddef>

namespace retractor::planner {

struct ShareInterval {
    double low = 0.0, high = 1.0;
};

/// The interval of the share of successes in a number of trials. Without a trial it is 0 to 1.
/// @param confidence between 0 and 1
/// @pre successes <= trials
ShareInterval clopper_pearson_interval(std::size_t successes, std::size_t trials, double confidence = 0.95);

} // namespace retractor::planner
