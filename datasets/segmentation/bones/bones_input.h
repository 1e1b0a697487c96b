#pragma once
// The input of segment_bones() and its steps. Units mm and Hounsfield units; frame patient LPS.

#include "datasets/segmentation/image/working_image.h"
#include "mesh/image/volume.h"

namespace retractor::datasets::segmentation {

/// The image and the structures found before. All masks are on the working grid.
struct BonesInput {
    const WorkingImage& image;
    const Mask& body; ///< without table, blankets and leads
    const Mask& lungs; ///< both lungs, with airways
    const mesh::LabelVolume* given = nullptr; ///< on the working grid, or null; bones with a label here keep this label
};

} // namespace retractor::datasets::segmentation
