#pragma once
// Heart region and aorta inside the mediastinum. Units mm and HU; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

struct VesselsInput {
    const WorkingImage& image;
    const Mask& mediastinum; ///< the cavity without lungs and airways
    const Mask& abdomen; ///< inside the wall, below the diaphragm
    const Lungs& lungs;
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones;
};

struct Vessels {
    Mask heart; ///< empty when it was not found
    Mask aorta;
    bool contrast = false; ///< the aorta was followed by its contrast
    std::string heart_how;
    std::string aorta_how;
    std::vector<std::string> warnings;
};

Vessels find_vessels(const VesselsInput& input, int threads);

} // namespace retractor::datasets::segmentation
