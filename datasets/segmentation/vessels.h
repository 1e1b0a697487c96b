#pragma once
// Finds heart region and aorta inside the mediastinum. Units mm and HU; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

/// The image and the structures found before. All masks are on the working grid.
struct VesselsInput {
    const WorkingImage& image;
    const Mask& mediastinum; ///< thoracic cavity without lungs and airways
    const Mask& abdomen; ///< inside the wall, below the diaphragm
    const Lungs& lungs;
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones;
};

/// Heart and aorta, and how each was found.
struct Vessels {
    Mask heart; ///< all zero when no heart was found
    Mask aorta; ///< all zero when no aorta was found
    bool contrast = false; ///< contrast shows the aorta
    std::string heart_how; ///< see FoundStructure::how
    std::string aorta_how; ///< see FoundStructure::how
    std::vector<std::string> warnings;
};

/// Finds heart and aorta with this number of threads.
Vessels find_vessels(const VesselsInput& input, int threads);

} // namespace retractor::datasets::segmentation
