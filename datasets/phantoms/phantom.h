#pragma once
// Synthetic patients: a CT and its labels from implicit shapes, evaluated at voxel centres. Phantoms replace a patient
// in the demo and in the tests. Units mm and Hounsfield units. Frame patient LPS (x to the patient's left, y posterior,
// z superior). The patient lies supine, and the world origin is the middle of the chest.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>

namespace retractor::datasets {

/// A CT and its labels, on the same grid.
struct Phantom {
    mesh::Volume ct;
    mesh::LabelVolume labels;
};

/// Size, layers and imaging of a chest. The phantom is an adult chest without arms, from the base of the neck to the
/// upper abdomen. The defaults are an adult of average build. Thicknesses are absolute; organs scale with the rib cage.
struct ThoraxParameters {
    double width_mm = 330.0; ///< left to right over the skin, 260 to 460
    double depth_mm = 225.0; ///< front to back over the skin, 190 to 330
    double height_mm = 300.0; ///< length of the imaged part, 240 to 380
    Vec3 spacing_mm { 1.8, 1.8, 2.0 }; ///< voxel spacing, 0.5 to 6
    double margin_mm = 8.0; ///< air beyond the skin at left, right, front and back, 2 to 100
    double field_of_view_mm = 0.0; ///< imaged width and depth, at most 700; 0: the body and its margin
    double skin_mm = 3.0; ///< skin thickness, 1 to 6
    double fat_mm = 8.0; ///< subcutaneous fat, 3 to 40; thinner over the sternum, thicker over the belly
    double muscle_mm = 10.0; ///< muscle over the front of the ribs, 5 to 25; thicker at the back
    double aneurysm_diameter_mm = 55.0; ///< diameter of the bulge in the distal arch, 30 to 70
    double noise_hu = 12.0; ///< standard deviation of the CT noise, 0 to 100
    std::uint64_t seed = 1; ///< seed of the noise; the same parameters and seed give the same voxels
};

/// Makes CT and labels of a chest. Role wall: skin, fat, muscle, intercostal, rib_left_1..12, rib_right_1..12,
/// costal_cartilages, sternum, spine, scapula_left/right, clavicle_left/right. Role voxel: lung_left/right,
/// pericardium, mediastinal_fat, trachea, oesophagus, diaphragm, liver, stomach. Role target: aneurysm,
/// coronary_target. Role at risk: heart, aorta, pulmonary_artery, vena_cava. Records the parts "voxels" and "labels".
/// @throws InputError naming the parameter, its value and its range, and when the layers leave no room for a chest.
Phantom make_thorax_phantom(const ThoraxParameters& parameters, const Job& job = {});

/// Slabs of skin, fat and muscle over a cavity with a spherical target. The skin faces -y (the front of a supine
/// patient), the slabs are stacked along +y, and the world origin is the middle of the skin's outer face.
struct BlockParameters {
    Vec3 size_mm { 100.0, 80.0, 100.0 }; ///< x, y (depth with the cavity), z; each at least 20
    Vec3 spacing_mm { 2.0, 2.0, 2.0 }; ///< voxel spacing, 0.25 to 10
    double margin_mm = 6.0; ///< air on all six sides
    double skin_mm = 3.0;
    double fat_mm = 9.0;
    double muscle_mm = 12.0;
    bool bone_bar = false; ///< a bar along x in the middle of the muscle slab, like a rib; 12 mm along z, 6 mm along y
    double target_radius_mm = 10.0;
    double target_depth_mm = 50.0; ///< depth of the target's centre below the skin's outer face
    double noise_hu = 0.0;
    std::uint64_t seed = 1;
};

/// Makes CT and labels of the block. Role wall: skin, fat, muscle, and bone when requested. The label cavity has role
/// voxel and material lung; the label target has role target and material vessel.
/// @throws InputError naming the parameter.
Phantom make_block_phantom(const BlockParameters& parameters, const Job& job = {});

/// Returns the same voxels on a grid that is rotated about the world origin and then translated: x -> rotation * x +
/// translation.
/// @throws InputError unless `rotation` is a proper rotation (orthonormal to 1e-9, determinant +1).
Phantom transformed(const Phantom& phantom, const Mat3& rotation, const Vec3& translation);

} // namespace retractor::datasets
