#pragma once
// What no hand does: a pose beyond these comes from a fault, and is refused wherever poses come in.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <cmath>

namespace retractor::haptics {

constexpr double kMostSpeed = 1e6; ///< mm/s; a device's own limit lies near 1e3
constexpr double kUnitTolerance = 1e-3; ///< a quaternion's length may be off by this: more is no rounding

/// NaN is none of either.
inline bool is_rotation(const Eigen::Quaterniond& q) noexcept { return std::abs(q.norm() - 1.0) <= kUnitTolerance; }
inline bool is_speed(const Vec3& velocity) noexcept { return velocity.norm() <= kMostSpeed; }

} // namespace retractor::haptics
