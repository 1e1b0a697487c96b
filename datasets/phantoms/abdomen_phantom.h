#pragma once
// A synthetic upper abdomen to be felt with both hands: wall, liver and stomach, which touch each other. Units mm;
// frame patient LPS; the world origin is the middle of the abdomen.

#include "datasets/phantoms/phantom.h"

namespace retractor::datasets {

struct AbdomenParameters {
    double width_mm = 300.0; ///< left to right over the skin, 220 to 420
    double depth_mm = 200.0; ///< front to back over the skin, 160 to 320
    double height_mm = 200.0; ///< imaged length, 120 to 300
    double wall_mm = 15.0; ///< skin, fat and muscle together, 8 to 40
    Vec3 spacing_mm { 2.0, 2.0, 2.0 }; ///< voxel spacing, 0.5 to 6: the source's MRI had 2 mm
    double margin_mm = 6.0; ///< air left, right, front and back, 2 to 100
    double noise_hu = 12.0; ///< 0 to 100
    std::uint64_t seed = 1;
};

/// Labels: abdominal_wall (role wall), spine (wall), liver, stomach, bowel (voxel). Records "voxels" and "labels".
/// @throws InputError naming the parameter, its value and its range.
Phantom make_abdomen_phantom(const AbdomenParameters& parameters, const Job& job = {});

/// The same patient's liver alone, as tissue to be touched (role wall), its grid just round it.
Phantom make_liver_phantom(const AbdomenParameters& parameters, const Job& job = {});

} // namespace retractor::datasets
