#pragma once
// A chest whose landmarks are known in closed form: a round trunk with ribs on helices. Tests only. Units mm; LPS.

#include "mesh/image/volume.h"

namespace retractor::test_support {

struct ChestShape {
    double radius = 120.0; ///< of the skin, axis x = y = 0
    double wall = 24.0; ///< thickness
    double rib_radius = 104.0; ///< of the ribs' centre-lines
    double rib_height = 9.0, rib_thickness = 8.0;
    double rib_pitch = 24.0; ///< rib n lies rib_pitch below rib n - 1
    double rib_slope = 0.1; ///< mm down per degree from back to front
    double first_rib = 100.0; ///< height of rib 1 at the back
    int ribs = 8;
    double spacing = 3.0;
};

inline constexpr double kSternumTop = 80.0, kSternumBottom = -75.0, kRibFromDeg = 15.0, kRibToDeg = 140.0;

/// Height of the centre-line of rib n at an angle from straight back.
double rib_height_at(const ChestShape& shape, int number, double angle_deg);

/// Labels: skin, muscle, rib_left_n, rib_right_n, sternum, spine (wall), lung_left, lung_right, mediastinal_fat
/// (voxel), heart (at risk), coronary_target and aneurysm (target).
mesh::LabelVolume synthetic_chest(const ChestShape& shape = {});

/// x -> rotation * x + translation.
mesh::LabelVolume moved(const mesh::LabelVolume& labels, const Mat3& rotation, const Vec3& translation);

/// The same patient, the voxels stored backwards along one grid axis.
mesh::LabelVolume stored_backwards(const mesh::LabelVolume& labels, int axis);

} // namespace retractor::test_support
