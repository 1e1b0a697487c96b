#pragma once
// Describes, for a message, where an equilibrium was missed. Units mm, N; frame patient LPS.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

#include <string>

namespace retractor::fem {

/// "the largest force left is 0.02 N, at (1.0, 2.0, 3.0) mm". The place is the displaced position of the node.
/// @param displacement three per point
/// @param forces residual forces, three per point; zero at fixed and held nodes
std::string largest_force_left(
    const Points& points, const Eigen::VectorXd& displacement, const Eigen::VectorXd& forces);

} // namespace retractor::fem
