#pragma once
// The force that holds a chest open, compared with forces measured on bodies: the phantom's thorax under a rib
// spreader. The comparison is with a range, because bodies differ by a factor of two among themselves and the phantom
// is none of the measured bodies. Units mm, N, MPa.

#include "tests/verification/framework/problem.h"

#include <limits>
#include <string>

namespace retractor::verification {

/// Range of measured forces, N.
struct MeasuredForces {
    double least = 0.0, mean = 0.0, most = 0.0; ///< mean is NaN where no mean was published
    const char* source = "";
};

/// Sternotomy spread to 100 mm, 18 bodies: the largest force at full retraction, mean and one standard deviation.
inline constexpr MeasuredForces kSternotomyForces { 349.4 - 77.9, 349.4, 349.4 + 77.9,
    "largest force at full retraction, Aigner 2013, doi 10.1016/j.jtcvs.2013.07.075" };
/// Thoracotomy of pigs, spread to 50 to 112 mm: the largest force of each animal.
inline constexpr MeasuredForces kThoracotomyForces { 118.0, std::numeric_limits<double>::quiet_NaN(), 470.0,
    "largest force of each spreading, Chanoit 2019, doi 10.1186/s12938-019-0664-z" };

/// The computed force with its bar beside the range: "560 +- 329 N; measured 118 to 470 N (...)".
std::string beside(double force_N, double bar_N, const MeasuredForces& measured);

/// @throws IoError when the phantom's files cannot be written.
VerificationProblem retraction_problem();

} // namespace retractor::verification
