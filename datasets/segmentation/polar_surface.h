#pragma once
// A surface that is seen from an upright axis as one radius per angle and plane: sampled, completed where it was not
// seen, and turned back into voxels. Angle 0 looks to the back (+y), angles grow towards the left (+x).

#include "datasets/segmentation/image/working_image.h"

namespace retractor::datasets::segmentation {

inline constexpr int kAngles = 480; ///< 2 mm apart at a radius of 150 mm

/// One number per angle and plane, angles fastest.
struct PolarField {
    int planes = 0;
    std::vector<float> values;

    explicit PolarField(int plane_count, float value = 0.0F)
        : planes(plane_count)
        , values(static_cast<std::size_t>(plane_count) * kAngles, value)
    {
    }
    static std::size_t offset(int angle, int plane)
    {
        return static_cast<std::size_t>(plane) * kAngles + static_cast<std::size_t>(angle);
    }
};

/// Where the axis passes each plane, as continuous indices of the grid.
struct PolarAxis {
    std::vector<double> x;
    std::vector<double> y;
};

/// Fills what is not known with a membrane (Laplace's equation) through what is; angles are periodic. Nothing
/// happens when nothing is known.
void complete(PolarField& field, const std::vector<std::uint8_t>& known);

/// Voxels nearer to the axis than the surface, within `limit`.
Mask inside_surface(
    const Extent& extent, const PolarAxis& axis, const PolarField& radius, const Mask& limit, int threads);

} // namespace retractor::datasets::segmentation
