#pragma once
// The measure by which forces and displacements are compared: the length of the largest vector of any node.

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace retractor::fem {

/// @param vector three entries per node, node by node. @return in the vector's unit; 0 when it is empty.
inline double largest_nodal_norm(const Eigen::VectorXd& vector)
{
    double largest = 0.0;
    for (Eigen::Index i = 0; i < vector.size(); i += 3)
        largest = std::max(largest, vector.segment<3>(i).squaredNorm());
    return std::sqrt(largest);
}

} // namespace retractor::fem
