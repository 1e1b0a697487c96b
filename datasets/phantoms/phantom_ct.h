#pragma once
// From ideal Hounsfield values to what a scanner shows, shared by the phantoms.

#include "mesh/image/volume.h"

#include <cstdint>
#include <span>

namespace retractor::datasets {

/// Partial-volume blur (1 2 1 along each axis) and Gaussian noise, rounded and held to the range of a CT
/// (-1024 to 3071 HU). `ideal_hu` has one value per voxel of `grid`; it is used as working memory.
mesh::Volume render_ct(const mesh::ImageGrid& grid, std::span<float> ideal_hu, double noise_hu, std::uint64_t seed);

/// @throws InputError "NAME must be between LOW and HIGH, got VALUE" unless it is (NaN is not).
void check_parameter(const char* name, double value, double low, double high);

} // namespace retractor::datasets
