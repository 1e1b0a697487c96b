#pragma once
// Surfaces of a labelled patient, before any planning. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

/// The surfaces of the labels, drawn from voxels of about 2 mm: one opaque surface per bone and per label of role
/// target or at-risk, in label_color() and with the label's name; then the translucent body around them.
/// Labels without soft tissue of role wall (a crop of the mediastinum) give a surface of every label, and no body. The
/// lungs are then drawn only when there is no other label.
/// @returns nothing when no such label exists
std::vector<SurfaceItem> label_surfaces(const mesh::LabelVolume& labels, const Job& job = {});

} // namespace retractor::ui
