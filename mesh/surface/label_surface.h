#pragma once
// Smooth triangle surfaces of voxel labels, for the line of sight and for pictures. Units mm; frame patient LPS. In
// CMake this module is a part of retractor::mesh_generation.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>
#include <span>

namespace retractor::mesh {

/// Surface of the union of the given labels: the half-level of the slightly smoothed indicator. The surface is closed
/// (also where the labels touch the image border) and oriented outwards. Empty when no voxel has one of the labels.
/// @param smoothing_mm standard deviation of the Gaussian on the indicator; 0: no smoothing. Parts below about 1.35
/// standard deviations, such as a small artery, would vanish and keep the outline of their voxels instead.
/// @throws InputError on a bad grid, a wrong number of voxels, or negative or NaN smoothing
TriMesh label_surface(
    const LabelVolume& labels, std::span<const Label> which, double smoothing_mm = 1.0, const Job& job = {});

/// A surface for pictures, not for measurements: small voxels are first joined to about half the smoothing length, and
/// smoothing may remove thin parts.
TriMesh viewing_surface(
    const LabelVolume& labels, std::span<const Label> which, double smoothing_mm, const Job& job = {});

/// label_surface() for an arbitrary mask on a grid (1 = inside).
TriMesh mask_surface(
    const ImageGrid& grid, std::span<const std::uint8_t> mask, double smoothing_mm = 1.0, const Job& job = {});

} // namespace retractor::mesh
