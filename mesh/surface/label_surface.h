#pragma once
// Smooth triangle surfaces of voxel labels: what blocks the view, what is looked at, what is drawn.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>
#include <functional>
#include <span>

namespace retractor::mesh {

/// Surface of the union of the given labels: the half-level of the slightly smoothed indicator, closed
/// (also where the labels touch the image border), oriented outwards, mm in patient LPS.
/// @param smoothing_mm standard deviation of the Gaussian on the indicator (0: none). Parts too thin to survive it
/// (below about 1.35 standard deviations, e.g. a small artery) keep their voxels' outline.
/// @throws InputError on a bad grid, a wrong number of voxels, or negative or NaN smoothing.
/// @returns an empty mesh when no voxel has one of the labels.
TriMesh label_surface(
    const LabelVolume& labels, std::span<const Label> which, double smoothing_mm = 1.0, const Job& job = {});

/// A surface to look at, not to measure: small voxels are joined to about half the smoothing first, and thin parts
/// are smoothed away like everything else.
TriMesh viewing_surface(
    const LabelVolume& labels, std::span<const Label> which, double smoothing_mm, const Job& job = {});

/// label_surface() for an arbitrary mask on a grid (1 = inside).
TriMesh mask_surface(
    const ImageGrid& grid, std::span<const std::uint8_t> mask, double smoothing_mm = 1.0, const Job& job = {});

} // namespace retractor::mesh
