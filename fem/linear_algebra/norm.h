#pragma once
// The maximum norm that compares forces and displacements: the length of the largest vector of any node.

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace retractor::fem {

/// The maximum norm over nodes.
/// @param vector three entries per node, node by node
/// @return the largest length in the unit of the vector; 0 when the vector is empty
inline double largest_length(const Eigen::VectorXd& vector)
{
    double largest = 0.0;
    for (Eigen::Index i = 0; i < vector.size(); i += 3)
        largest = std::max(largest, vector.segment<3>(i).squaredNorm());
    return std::sqrt(largest);
}

} // namespace retractor::fem
