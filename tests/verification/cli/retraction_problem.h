#pragma once
// What a chest needs to be held open, beside what was measured on bodies: the phantom's thorax under a rib spreader.
// A comparison with a range: bodies differ by a factor of two among themselves, and the phantom is none of them.
// Units mm, N, MPa.

#include "tests/verification/framework/problem.h"

#include <limits>
#include <string>

namespace retractor::verification {

/// A range that forces were measured in, N.
struct MeasuredForces {
    double least = 0.0, mean = 0.0, most = 0.0; ///< NaN: no mean was published
    const char* source = "";
};

/// Sternotomy spread to 100 mm, 18 bodies; from one deviation below the mean of the first spreading to one above the
/// largest.
inline constexpr MeasuredForces kSternotomyForces { 225.0 - 61.0, 225.0, 349.0 + 78.0,
    "Aigner 2013, doi 10.1016/j.jtcvs.2013.07.075" };
/// Thoracotomy of pigs, spread to 50 to 112 mm: the largest force of each.
inline constexpr MeasuredForces kThoracotomyForces { 118.0, std::numeric_limits<double>::quiet_NaN(), 470.0,
    "Chanoit 2019, doi 10.1186/s12938-019-0664-z" };

/// The factor between a force and the nearer end of the range, less one; 0 within it. NaN for what is no force.
double outside(double force_N, const MeasuredForces& measured);

/// A force passes that is no farther outside than this: a factor of two, as bodies differ among themselves.
inline constexpr double kMostOutside = 1.0;
/// Where a force lies beside the range, and how far it may: "560 N, 1.19 times the largest measured, ...".
std::string beside(double force_N, const MeasuredForces& measured);

/// @throws IoError when there is no room for the phantom's files.
VerificationProblem retraction_problem();

} // namespace retractor::verification
