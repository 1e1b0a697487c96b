#pragma once
// The diaphragm as a height over the axial plane. It is seen where lung lies on it; under the heart it is stretched
// between the domes. Working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

struct DiaphragmHeight {
    std::vector<double> plane; ///< per column (x fastest): plane index, negative below the image
    bool seen = false;
};

DiaphragmHeight diaphragm_height(const Extent& extent, const Lungs& lungs);

} // namespace retractor::datasets::segmentation
