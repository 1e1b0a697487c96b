#pragma once
// Statistics of measured numbers, and a measured time.

#include "mesh/base/job.h"

#include <Eigen/Core>

#include <vector>

namespace retractor::benchmarks {

/// The value of nearest rank at a share (0 to 1) of all values; 0 without values.
double percentile(std::vector<double> values, double share);
double median(std::vector<double> values);

/// Largest difference of two fields, relative to the largest value of the reference. Where one field is longer, for
/// ids that only this field has, its additional values must be zero.
/// @throws SolverError when an additional value is not zero.
double relative_difference(const Eigen::VectorXd& field, const Eigen::VectorXd& reference);

/// Run time of some work, ms.
template <class Work> double milliseconds(Work&& work)
{
    const Stopwatch watch;
    work();
    return 1e3 * watch.seconds();
}

} // namespace retractor::benchmarks
