#pragma once
// The statistics of elasticity trials: boxes, F-tests of spreads, t-tests of means.

#include <span>
#include <vector>

namespace retractor::haptics {

/// Tukey's five numbers; quartiles by linear interpolation.
struct BoxNumbers {
    double low = 0.0, lower_quartile = 0.0, median = 0.0, upper_quartile = 0.0, high = 0.0;
    std::size_t count = 0;
};
/// @throws InputError on no values or NaN.
BoxNumbers box_numbers(std::span<const double> values);

/// Whether two samples spread differently: F = s_a^2 / s_b^2, two-sided.
struct FTest {
    double F = 0.0, p = 1.0;
    int freedom_a = 0, freedom_b = 0;
};
/// @throws InputError on fewer than two values in a sample, or when one does not vary at all.
FTest f_test(std::span<const double> a, std::span<const double> b);

struct TTest {
    double t = 0.0, p = 1.0; ///< two-sided
    double freedom = 0.0;
    double difference = 0.0; ///< mean of a - b
};
/// The same people twice, in the same order. @throws InputError on different lengths, fewer than two
/// values, or differences that do not vary.
TTest paired_t_test(std::span<const double> a, std::span<const double> b);

} // namespace retractor::haptics
