#pragma once
// Separates the patient from table, blankets and leads. Units mm and HU; working grid.

#include "datasets/segmentation/image/working_image.h"

#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

/// The patient.
struct Body {
    Mask mask; ///< the body with lungs and inner gas, also where the upper or lower border of the image opens them
    std::vector<std::string> warnings;
};

/// Finds the body with this number of threads.
/// @throws InputError when no piece of the image is as large as a trunk, and when the image is a crop from inside the
/// body.
Body segment_body(const WorkingImage& image, int threads);

} // namespace retractor::datasets::segmentation
