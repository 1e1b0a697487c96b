#pragma once
// Limits of a plausible pose. A pose beyond these limits comes from a fault; every input of poses refuses it.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <cmath>

namespace retractor::haptics {

constexpr double kMostSpeed = 1e6; ///< mm/s; the limit of a device is near 1e3
constexpr double kUnitTolerance = 1e-3; ///< largest error of a quaternion's length; a larger error is not rounding

/// Both functions return false for NaN.
inline bool is_rotation(const Eigen::Quaterniond& q) noexcept { return std::abs(q.norm() - 1.0) <= kUnitTolerance; }
inline bool is_speed(const Vec3& velocity) noexcept { return velocity.norm() <= kMostSpeed; }

} // namespace retractor::haptics
