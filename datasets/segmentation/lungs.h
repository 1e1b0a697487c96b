#pragma once
// Lungs, left and right, and the windpipe down to the main bronchi. Units mm and HU; working grid.

#include "datasets/segmentation/image/working_image.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

struct Lungs {
    Mask left; ///< vessels inside included, windpipe and main bronchi not
    Mask right;
    Mask trachea; ///< the air in windpipe and main bronchi
    std::optional<double> carina_z; ///< world mm; where the windpipe parts, when it was followed that far
    std::vector<std::string> warnings;

    Mask both() const { return united(left, right); }
};

/// @throws InputError when there is no lung (how much air was found, and where, is in the message).
Lungs segment_lungs(const WorkingImage& image, const Mask& body);

} // namespace retractor::datasets::segmentation
