#pragma once
// Fills holes of a mask plane by plane.

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::mesh {

/// Sets unset voxels that the mask encloses within a plane perpendicular to `axis` (0, 1 or 2), plane by plane.
/// @param size voxels along each axis, the first one fastest
/// @param mask one byte per voxel, 0 or 1
std::vector<std::uint8_t> holes_filled_in_planes(
    const std::array<int, 3>& size, const std::vector<std::uint8_t>& mask, int axis);

} // namespace retractor::mesh
