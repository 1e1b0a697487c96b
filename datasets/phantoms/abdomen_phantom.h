#pragma once
// A synthetic upper abdomen for palpation with both hands: wall, liver and stomach, in contact with each other. The
// structures are those of Suzuki N and others, "Performing virtual surgery with a force feedback system" (International
// Conference on Artificial Reality and Telexistence). Units mm; frame patient LPS; the world origin is the middle of
// the abdomen.

#include "datasets/phantoms/phantom.h"

namespace retractor::datasets {

/// Size and imaging of the abdomen.
struct AbdomenParameters {
    double width_mm = 300.0; ///< left to right over the skin, 220 to 420
    double depth_mm = 200.0; ///< front to back over the skin, 160 to 320
    double height_mm = 200.0; ///< imaged length, 120 to 300
    double wall_mm = 15.0; ///< thickness of skin, fat and muscle together, 8 to 40
    Vec3 spacing_mm { 2.0, 2.0, 2.0 }; ///< voxel spacing, 0.5 to 6; the MRI of Suzuki and others had 2 mm
    double margin_mm = 6.0; ///< air left, right, front and back, 2 to 100
    double noise_hu = 12.0; ///< standard deviation of the CT noise, 0 to 100
    std::uint64_t seed = 1; ///< seed of the noise
};

/// Makes CT and labels: abdominal_wall and spine (role wall); liver, stomach and bowel (role voxel). Records the parts
/// "voxels" and "labels".
/// @throws InputError naming the parameter, its value and its range.
Phantom make_abdomen_phantom(const AbdomenParameters& parameters, const Job& job = {});

/// Makes only the liver of the same patient, as tissue for palpation (role wall), on a grid that just contains the
/// liver.
/// @throws as make_abdomen_phantom() does.
Phantom make_liver_phantom(const AbdomenParameters& parameters, const Job& job = {});

} // namespace retractor::datasets
