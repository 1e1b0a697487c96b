#pragma once
// Finds the left and the right lung, and the windpipe down to the main bronchi. Units mm and HU; working grid.

#include "datasets/segmentation/image/working_image.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

/// The lungs and the windpipe.
struct Lungs {
    Mask left; ///< with the vessels inside, without windpipe and main bronchi
    Mask right; ///< as for the left lung
    Mask trachea; ///< air in windpipe and main bronchi
    /// World height where the windpipe divides, mm; none when the windpipe could not be followed to its division.
    std::optional<double> carina_z;
    std::vector<std::string> warnings;

    Mask both() const { return united(left, right); }
};

/// Finds the lungs in the body. @throws InputError when there is no lung; the message gives the volume and place of the
/// air found.
Lungs segment_lungs(const WorkingImage& image, const Mask& body);

} // namespace retractor::datasets::segmentation
