#pragma once
// The patient told from table, blankets and leads. Units mm and HU; working grid.

#include "datasets/segmentation/image/working_image.h"

#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

struct Body {
    Mask mask; ///< lungs and gas inside included, also where the image's upper or lower border opens them
    std::vector<std::string> warnings;
};

/// @throws InputError when nothing in the image is as large as a trunk.
Body segment_body(const WorkingImage& image, int threads);

} // namespace retractor::datasets::segmentation
