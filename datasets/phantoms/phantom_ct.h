#pragma once
// Turns the ideal Hounsfield values of a phantom into the values that a scanner shows.

#include "mesh/image/volume.h"

#include <cstdint>
#include <span>

namespace retractor::datasets {

/// Applies partial-volume blur (weights 1 2 1 along each axis) and Gaussian noise of standard deviation `noise_hu`,
/// then rounds and clamps to the range of a CT (-1024 to 3071 HU).
/// @param ideal_hu one value per voxel of `grid`; the function overwrites these values
mesh::Volume render_ct(const mesh::ImageGrid& grid, std::span<float> ideal_hu, double noise_hu, std::uint64_t seed);

/// @throws InputError "NAME must be between LOW and HIGH, got VALUE" unless LOW <= value <= HIGH; NaN is refused.
void check_parameter(const char* name, double value, double low, double high);

} // namespace retractor::datasets
