#pragma once
// A surface described by one radius per angle and plane about an upright axis. The functions complete a surface that
// was sampled in parts, and convert a surface to voxels. Angle 0 points to the back (+y); angles grow towards the left
// (+x).

#include "datasets/segmentation/image/working_image.h"

namespace retractor::datasets::segmentation {

inline constexpr int kAngles = 480; ///< samples per plane, 2 mm apart at a radius of 150 mm

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

/// The axis: its position in each plane, as continuous indices of the grid.
struct PolarAxis {
    std::vector<double> x;
    std::vector<double> y;
};

/// Replaces unknown values by a membrane (solution of Laplace's equation) through the known values. Angles are
/// periodic. Without known values the field stays the same.
void complete(PolarField& field, const std::vector<std::uint8_t>& known);

/// Sets the voxels of `limit` that are nearer to the axis than the surface.
Mask inside_surface(
    const Extent& extent, const PolarAxis& axis, const PolarField& radius, const Mask& limit, int threads);

} // namespace retractor::datasets::segmentation
