#pragma once
// Where an equilibrium was missed, in words. Units mm, N; frame patient LPS.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

#include <string>

namespace retractor::fem {

/// "the largest force left is 0.02 N, at (1.0, 2.0, 3.0) mm": the node's place as it is displaced.
/// @param displacement @param forces three per point, the forces of nodes that are held zero.
std::string largest_force_left(
    const Points& points, const Eigen::VectorXd& displacement, const Eigen::VectorXd& forces);

} // namespace retractor::fem
