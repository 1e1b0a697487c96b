#pragma once
// A labelled patient in space, before anything is planned. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

/// One opaque surface per bone and per label of role target or at-risk, in label_color(), named as the label; then the
/// body round them, translucent. Where no soft tissue of role wall is labelled (a crop of the mediastinum), every
/// label (the lungs only where there is nothing else), and no body. Drawn from voxels of about 2 mm. Empty when nothing
/// of that is labelled.
std::vector<SurfaceItem> label_surfaces(const mesh::LabelVolume& labels, const Job& job = {});

} // namespace retractor::ui
