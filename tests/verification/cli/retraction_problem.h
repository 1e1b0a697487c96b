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

/// Sternotomy spread to 100 mm, 18 bodies. The range begins one standard deviation below the mean of the first
/// spreading and ends one standard deviation above the largest mean.
inline constexpr MeasuredForces kSternotomyForces { 225.0 - 61.0, 225.0, 349.0 + 78.0,
    "Aigner 2013, doi 10.1016/j.jtcvs.2013.07.075" };
/// Thoracotomy of pigs, spread to 50 to 112 mm: the largest force of each animal.
inline constexpr MeasuredForces kThoracotomyForces { 118.0, std::numeric_limits<double>::quiet_NaN(), 470.0,
    "Chanoit 2019, doi 10.1186/s12938-019-0664-z" };

/// Factor between a force and the nearer end of the range, minus one; 0 within the range, NaN for a force that is not
/// positive.
double outside(double force_N, const MeasuredForces& measured);

/// Largest value of outside() that passes: a factor of two, because bodies differ by this factor among themselves.
inline constexpr double kMostOutside = 1.0;
/// The position of a force relative to the range, and the limit: "560 N, 1.19 times the largest measured, ...".
std::string beside(double force_N, const MeasuredForces& measured);

/// @throws IoError when the phantom's files cannot be written.
VerificationProblem retraction_problem();

} // namespace retractor::verification
