#pragma once
// Divides the soft tissue of the chest wall into layers that a mesher can follow: skin, fat, muscle, and the muscle
// between the ribs. Units mm and HU; working grid.

#include "datasets/segmentation/cavity.h"

namespace retractor::datasets::segmentation {

/// The layer of a voxel; `none` outside the wall.
enum class Layer : std::uint8_t { none, skin, fat, muscle, intercostal };

/// The image and the structures found before. All masks are on the working grid.
struct WallInput {
    const WorkingImage& image;
    const Mask& wall; ///< soft tissue to divide, without bone
    const std::vector<float>& depth; ///< depth under the surface of the body, mm, per voxel
    const Mask& ribs; ///< ribs with cartilages
    const Mask& shell; ///< see Cavity
    const Mask& air; ///< lungs and windpipe; a neighbouring voxel that contains both air and tissue looks like fat
};

/// Returns the layer of every voxel.
std::vector<Layer> wall_layers(const WallInput& input, int threads);

} // namespace retractor::datasets::segmentation
