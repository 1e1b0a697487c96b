#pragma once
// The soft tissue of the chest wall in layers that a mesher can follow: skin, fat, muscle, and the muscle between the
// ribs. Units mm and HU; working grid.

#include "datasets/segmentation/cavity.h"

namespace retractor::datasets::segmentation {

enum class Layer : std::uint8_t { none, skin, fat, muscle, intercostal };

struct WallInput {
    const WorkingImage& image;
    const Mask& wall; ///< what is to be divided: no bone
    const std::vector<float>& depth; ///< mm under the body's surface
    const Mask& ribs; ///< with cartilages
    const Mask& shell; ///< see Cavity
    const Mask& air; ///< lungs and windpipe: next to them, voxels that hold both look like fat
};

std::vector<Layer> wall_layers(const WallInput& input, int threads);

} // namespace retractor::datasets::segmentation
