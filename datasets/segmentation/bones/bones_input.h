#pragma once
// What segment_bones() and its steps work on. mm and Hounsfield units; frame patient LPS.

#include "datasets/segmentation/image/working_image.h"
#include "mesh/image/volume.h"

namespace retractor::datasets::segmentation {

struct BonesInput {
    const WorkingImage& image;
    const Mask& body; ///< without table, blankets and leads
    const Mask& lungs; ///< both, airways included
    const mesh::LabelVolume* given = nullptr; ///< on the working grid; bones named in it are taken as they are
};

} // namespace retractor::datasets::segmentation
