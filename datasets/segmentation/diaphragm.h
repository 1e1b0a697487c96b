#pragma once
// Finds the diaphragm as a height over the axial plane. Lung on the diaphragm shows the height. Under the heart the
// height is interpolated between the domes. Working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

/// The height of the diaphragm over every column of the grid.
struct DiaphragmHeight {
    std::vector<double> plane; ///< plane index per column (x fastest); negative below the image
    bool seen = false; ///< lung shows the diaphragm in at least one column
};

/// Finds the height of the diaphragm below both lungs.
DiaphragmHeight diaphragm_height(const Extent& extent, const Lungs& lungs);

} // namespace retractor::datasets::segmentation
