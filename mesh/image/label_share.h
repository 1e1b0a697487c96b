#pragma once
// The share of some labels round a point, continuous in the point. Units mm; frame patient LPS.

#include "mesh/image/volume.h"

namespace retractor::mesh {

/// Share of the labels in `mask` in the eight voxels round a point, by trilinear weights, from 0 to 1; nothing lies
/// outside the grid. The labels' surface is where the share is a half.
double label_share(const LabelVolume& labels, const LabelFlags& mask, const Vec3& point);

} // namespace retractor::mesh
