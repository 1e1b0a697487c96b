#pragma once
// The largest strain in a displacement field on a mesh that is being cut: the place where tissue may tear. Units mm.

#include "fem/interactive/online_stiffness.h"

#include <Eigen/Core>

#include <span>

namespace retractor::fem {

struct StrainPeak {
    double p99 = 0.0; ///< largest principal Green-Lagrange strain: 99th percentile by volume
    Vec3 where = Vec3::Zero(); ///< middle of the element with this strain, mm, at rest
};

/// @param displacement three per vertex id, mm
/// @param held vertices under hooks; elements that touch them are excluded, because the strain there has no limit under
/// refinement
/// @throws InputError when the displacement has another size
StrainPeak strain_peak(
    const OnlineStiffness& stiffness, const Eigen::VectorXd& displacement, std::span<const VertexId> held);

} // namespace retractor::fem
