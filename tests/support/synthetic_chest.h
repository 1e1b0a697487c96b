#pragma once
// A chest with landmarks in closed form: a round trunk with ribs on helices. Units mm; frame patient LPS.

#include "mesh/image/volume.h"

namespace retractor::test_support {

struct ChestShape {
    double radius = 120.0; ///< radius of the skin about the axis x = y = 0
    double wall = 24.0; ///< thickness of the wall
    double rib_radius = 104.0; ///< radius of the ribs' centre-lines
    double rib_height = 9.0, rib_thickness = 8.0;
    double rib_pitch = 24.0; ///< distance of rib n below rib n - 1
    double rib_slope = 0.1; ///< descent of a rib from back to front, mm per degree
    double first_rib = 100.0; ///< z of rib 1 at the back
    int ribs = 8;
    double spacing = 3.0;
};

inline constexpr double kSternumTop = 80.0, kSternumBottom = -75.0, kRibFromDeg = 15.0, kRibToDeg = 140.0;

/// Height z (mm) of the centre-line of rib n at an angle from straight back.
double rib_height_at(const ChestShape& shape, int number, double angle_deg);

/// Height z (mm) of the upper edge of rib n at an angle from straight back.
double upper_edge_at(const ChestShape& shape, int number, double angle_deg);

/// Labels: skin, muscle, rib_left_n, rib_right_n, sternum, spine (wall), lung_left, lung_right, mediastinal_fat
/// (voxel), heart (at risk), coronary_target and aneurysm (target).
mesh::LabelVolume synthetic_chest(const ChestShape& shape = {});

/// The same patient, moved: x becomes rotation * x + translation.
mesh::LabelVolume moved(const mesh::LabelVolume& labels, const Mat3& rotation, const Vec3& translation);

/// The same patient with voxels stored backwards along one grid axis.
mesh::LabelVolume stored_backwards(const mesh::LabelVolume& labels, int axis);

} // namespace retractor::test_support
