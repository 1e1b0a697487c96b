#pragma once
// What benches make of many numbers.

#include <Eigen/Core>

#include <vector>

namespace retractor::benchmarks {

/// The value of nearest rank at this share (0 to 1) of all; 0 without values.
double percentile(std::vector<double> values, double share);
double median(std::vector<double> values);

/// Largest difference of two fields over the reference's largest value. Where one is longer, as after ids that only it
/// has met, what the other lacks must be zero. @throws SolverError when it is not.
double relative_difference(const Eigen::VectorXd& field, const Eigen::VectorXd& reference);

} // namespace retractor::benchmarks
