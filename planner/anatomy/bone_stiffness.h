#pragma once
// Young's moduli of ribs and costal cartilage from the patient's own CT, one per label. Units mm, MPa, Hounsfield units
// (HU).
//
// A rib is a thin tube of cortex filled with marrow, and the model gives it one modulus. What counts when ribs are
// spread is the bending stiffness E I of a section. The cortex has E = 13.5 GPa (Subit and others 2013, arXiv
// 1108.0390), and marrow bears nothing beside it. So the modulus of the whole section is E times the share of the
// cortex in the second moment of area of the section's outline.
//
// The cortex, 0.5 to 1.5 mm, is thinner than a voxel. Its thickness cannot be seen, but its area can: blurring spreads
// the Hounsfield values and keeps their integral. The area of the cortex is the integral over the section of
// (HU - marrow) / (cortex - marrow), each voxel between 0 and 1. No threshold is applied. The area is taken as a shell
// at the outline of the label, of the same share a of the area everywhere: the share in the second moment is then
// 1 - (1 - a)^2 about every axis. For a shell of even thickness round an ellipse the mean over both axes differs from
// that by less than 2 %.
//
// Ribs tested whole in bending had 2.8 +- 1.3 GPa (age 10 to 15) and 7.4 +- 2.9 GPa (16 to 22) (Pezowicz, Glowacki
// 2012): the modulus of a rib lies within 2 and 8 GPa, and a value beyond is cut off with a message. Without a CT, or
// where the CT cannot tell, a rib has 4 GPa, the geometric mean.
//
// Costal cartilage is 15 MPa (5 to 25). Its perichondrium bears a part of the load: without it the force is 47 % (35 to
// 58) less (Forman and others 2010), so that the whole is 1.9 times as stiff. Cartilage that is calcified to 24 % is
// 2.3 to 3.8 times as stiff (doi 10.1080/10255842.2012.671307); in between the increase is taken as proportional.
//
// The sternum keeps the modulus of the material table: no bending test of a whole sternum with a homogenised modulus is
// known to us, and its wide flat section is not a tube.

#include "fem/material/material.h"
#include "mesh/image/volume.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

inline constexpr double kCorticalBoneMPa = 13'500.0; ///< Subit 2013: coupons of rib cortex in tension
inline constexpr double kSoftestRibMPa = 2'000.0, kStiffestRibMPa = 8'000.0; ///< Pezowicz 2012
inline constexpr double kMiddleRibMPa = 4'000.0; ///< geometric mean of the two

/// Hounsfield values of marrow with its trabeculae, and of cortex that fills a voxel; the ranges are ours.
inline constexpr double kMarrowHU = 100.0, kLeastMarrowHU = 0.0, kMostMarrowHU = 200.0;
inline constexpr double kCortexHU = 1'600.0, kLeastCortexHU = 1'400.0, kMostCortexHU = 1'900.0;

inline constexpr double kCartilageSubstanceMPa = 15.0, kSoftestCartilageMPa = 5.0, kStiffestCartilageMPa = 25.0;
inline constexpr double kPerichondrium = 1.9; ///< 1 / (1 - 0.47), Forman 2010
/// Stiffness of calcified cartilage over that of cartilage without, less 1, per share that is calcified: 3.05, the
/// middle of 2.3 to 3.8, at a share of 0.24; up to the largest ratio measured.
inline constexpr double kStiffeningPerShare = (3.05 - 1.0) / 0.24, kMostStiffening = 3.8;

/// How a modulus was found.
enum class StiffnessOrigin {
    own, ///< the case gives it
    image, ///< the CT
    middle, ///< no CT, or a CT that cannot tell: the middle of what is published
};

/// "case", "CT", "published range": the words of metrics.json.
std::string_view to_string(StiffnessOrigin origin);

/// The modulus of one label of the skeleton.
struct BoneStiffness {
    Label label = 0;
    std::string name; ///< of the label
    std::string material; ///< "bone" or "cartilage"
    StiffnessOrigin origin = StiffnessOrigin::middle;
    double modulus_MPa = 0.0;
    /// Range of the modulus: of published values, or by the ranges of the Hounsfield values above; both ends are the
    /// modulus where the case gives it.
    double low_MPa = 0.0, high_MPa = 0.0;
    /// The modulus by the CT before it was cut off to kSoftestRibMPa and kStiffestRibMPa; not set: it was not cut off.
    std::optional<double> cut_off_MPa {};
    double share = 0.0; ///< with a CT: cortex over the area of a rib's section, or calcified share of cartilage
    std::size_t sections = 0; ///< number of sections of a rib
    std::string words; ///< one sentence with the source
};

/// The cortex of a rib in a CT.
struct RibSections {
    std::vector<double> shares; ///< cortex over the area of the outline, one per section from one end to the other
    std::string unknown; ///< why the CT cannot tell; empty: it can
};

/// Measures the sections of a rib. Slices of 8 mm along the rib count; those at its ends, where joints and cartilage
/// are near, do not.
/// @param labels, ct may have different grids
/// @param marrow_HU, cortex_HU Hounsfield values without and with cortex, marrow_HU < cortex_HU
/// @throws InputError when the two values are not finite or not in order
RibSections measure_rib_sections(const mesh::LabelVolume& labels, Label rib, const mesh::Volume& ct,
    double marrow_HU = kMarrowHU, double cortex_HU = kCortexHU);

/// The modulus of a section with this share of cortex, not cut off.
/// @throws InputError when the share is not between 0 and 1
double section_modulus_MPa(double cortex_share);

/// The calcified share of cartilage: voxels from 150 HU (none) to 250 HU (all), without those beside bone. Cartilage
/// itself has some 100 HU. The two values are ours. Nothing when the label has no such voxel.
std::optional<double> calcified_share(const mesh::LabelVolume& labels, Label cartilage, const mesh::Volume& ct);

/// The modulus of cartilage with perichondrium, from the calcified share. @throws InputError as section_modulus_MPa()
double cartilage_modulus_MPa(double calcified_share);

/// Moduli of all ribs ("rib_left_5") and cartilages of the wall that the label table names.
/// A material of the case that differs from default_materials() is the case's own, and its modulus holds for all labels
/// of the material.
/// @param ct not set: none; @param without_ct why there is none, for the words
/// @throws InputError as find_material() does
std::vector<BoneStiffness> find_bone_stiffness(const mesh::LabelVolume& labels, const mesh::Volume* ct,
    const fem::MaterialTable& materials, std::string_view without_ct = "no CT");

/// Gives the labels their own moduli. The material keeps its name; its source becomes the words of the modulus.
/// @param material_of_label indexed by label; labels beyond its end are left out
void apply_bone_stiffness(std::span<const BoneStiffness> bones, std::vector<fem::Material>& material_of_label);

} // namespace retractor::planner
