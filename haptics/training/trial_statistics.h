#pragma once
// Statistics of elasticity trials: numbers of box plots, F-tests of spreads, t-tests of means.

#include <span>

namespace retractor::haptics {

/// Tukey's five numbers. Quartiles are interpolated linearly.
struct BoxNumbers {
    double low = 0.0, lower_quartile = 0.0, median = 0.0, upper_quartile = 0.0, high = 0.0;
    std::size_t count = 0;
};
/// @throws InputError on no values or NaN
BoxNumbers box_numbers(std::span<const double> values);

/// Two-sided test of whether two samples spread differently: F = s_a^2 / s_b^2.
struct FTest {
    double F = 0.0, p = 1.0;
    int freedom_a = 0, freedom_b = 0;
};
/// @throws InputError on fewer than two values in a sample, or a sample without variation
FTest f_test(std::span<const double> a, std::span<const double> b);

struct TTest {
    double t = 0.0, p = 1.0; ///< p is two-sided
    double freedom = 0.0;
    double difference = 0.0; ///< mean of a minus mean of b
};
/// Paired t-test: both samples list the same people in the same order.
/// @throws InputError on different lengths, fewer than two values, or differences without variation
TTest paired_t_test(std::span<const double> a, std::span<const double> b);

} // namespace retractor::haptics
