#pragma once
// Synthetic patients: a CT and its labels from implicit shapes, evaluated at voxel centres. They stand in for a
// patient in the demo and in the tests. Units mm and Hounsfield units; frame patient LPS (x to the patient's Left,
// y Posterior, z Superior; the patient lies supine, the world origin is the middle of the chest).

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>

namespace retractor::datasets {

/// A CT and the labels of the same voxels (both on one grid).
struct Phantom {
    mesh::Volume ct;
    mesh::LabelVolume labels;
};

/// An adult chest, arms not included, from the base of the neck to the upper abdomen. The defaults are an adult of
/// average build; thicknesses are absolute, organs follow the size of the rib cage.
struct ThoraxParameters {
    double width_mm = 330.0; ///< left to right over the skin, 260 to 460
    double depth_mm = 225.0; ///< front to back over the skin, 190 to 330
    double height_mm = 300.0; ///< length of the imaged piece, 240 to 380
    Vec3 spacing_mm { 1.8, 1.8, 2.0 }; ///< voxel spacing, 0.5 to 6
    double margin_mm = 8.0; ///< air around the skin, left, right, front and back, 2 to 100
    double field_of_view_mm = 0.0; ///< imaged left to right and front to back, to 700; 0: the body and its margin
    double skin_mm = 3.0; ///< skin thickness, 1 to 6
    double fat_mm = 8.0; ///< subcutaneous fat, 3 to 40; thinner over the sternum, thicker over the belly
    double muscle_mm = 10.0; ///< muscle over the front of the ribs, 5 to 25; the back has more
    double squareness = 2.4; ///< exponent of the cross-section: 2 is an ellipse, 3 nearly a rounded box; 2 to 3
    double aneurysm_diameter_mm = 55.0; ///< bulge of the distal arch, 30 to 70
    Vec3 aneurysm_offset_mm { 0.0, 0.0, 0.0 }; ///< moves the bulge, each component within 20
    double coronary_target_diameter_mm = 12.0; ///< anastomosis site on the anterior descending artery, 6 to 20
    double noise_hu = 12.0; ///< standard deviation of the CT noise, 0 to 100
    std::uint64_t seed = 1; ///< of the noise; the same parameters and seed give the same voxels
};

/// Labels: skin, fat, muscle, intercostal, rib_left_1..12, rib_right_1..12, costal_cartilages, sternum, spine,
/// scapula_left/right, clavicle_left/right (role wall); lung_left/right, pericardium, mediastinal_fat, trachea,
/// oesophagus, diaphragm, liver, stomach (voxel); aneurysm, coronary_target (target); heart, aorta,
/// pulmonary_artery, vena_cava (at risk). Records the parts "voxels" and "labels".
/// @throws InputError naming the parameter, its value and its range, or when the layers leave no room for a chest.
Phantom make_thorax_phantom(const ThoraxParameters& parameters, const Job& job = {});

/// Slabs of skin, fat and muscle over a cavity with a spherical target. The skin faces -y (the front of a supine
/// patient), slabs are stacked along +y, the world origin is the middle of the skin's outer face.
struct BlockParameters {
    Vec3 size_mm { 100.0, 80.0, 100.0 }; ///< x, y (depth, cavity included), z; each at least 20
    Vec3 spacing_mm { 2.0, 2.0, 2.0 }; ///< voxel spacing, 0.25 to 10
    double margin_mm = 6.0; ///< air on all six sides
    double skin_mm = 3.0;
    double fat_mm = 9.0;
    double muscle_mm = 12.0;
    bool bone_bar = false; ///< a bar along x in the middle of the muscle slab, as a rib crosses an intercostal field
    double bone_height_mm = 12.0; ///< of the bar, along z
    double bone_thickness_mm = 6.0; ///< of the bar, along y; less than the muscle
    double target_radius_mm = 10.0;
    double target_depth_mm = 50.0; ///< of the target's centre below the skin's outer face
    double noise_hu = 0.0;
    std::uint64_t seed = 1;
};

/// Labels: skin, fat, muscle, bone (when asked for) with role wall; cavity (voxel, lung); target (target, vessel).
/// @throws InputError naming the parameter.
Phantom make_block_phantom(const BlockParameters& parameters, const Job& job = {});

/// The same voxels on a grid that is rotated about the world origin and then moved: x -> rotation * x + translation.
/// @throws InputError unless `rotation` is a proper rotation (orthonormal to 1e-9, determinant +1).
Phantom transformed(const Phantom& phantom, const Mat3& rotation, const Vec3& translation);

} // namespace retractor::datasets
