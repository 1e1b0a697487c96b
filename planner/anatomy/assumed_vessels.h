#pragma once
// Where vessels and nerves of the chest wall usually are. A CT of 1 mm or more hardly shows them, and labels seldom
// name them, but a surgeon keeps away from them: the mammary arteries beside the sternum, and the vessels and the nerve
// under each rib. The lines are estimates to be corrected by hand. Units mm; frame patient LPS.
//
// The mammary artery runs down behind the cartilages, 12.0 mm (left) and 12.8 mm (right) beside the sternum, with a
// diameter of 2.0 and 2.3 mm [Paliouras et al. 2015, Ann Transl Med 3:212, 50 specimens], and divides at the sixth
// space [Henriquez-Pino et al. 1997, Ann Thorac Surg 64:1041, 100 cadavers]. The intercostal vein, artery and nerve run
// in the groove under each rib, on its inner side.

#include "mesh/image/volume.h"
#include "planner/anatomy/anatomy.h"
#include "planner/case/assumed_vessel.h"

#include <span>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Distance of the middle of the mammary arteries from the sternum's edge, mm: the mean of both sides.
inline constexpr double kMammaryFromSternumMm = 12.4;
inline constexpr double kMammaryRadiusMm = 1.1;
/// Radius of the bundle of intercostal vein, artery and nerve, mm (ours).
inline constexpr double kBundleRadiusMm = 2.0;
/// The numbers of the ribs that have a space, and so a bundle, below them.
inline constexpr int kLastRibWithBundle = 11;

/// "mammary_artery_left", "mammary_artery_right" and "neurovascular_bundle_left_1" to "neurovascular_bundle_right_11".
/// What is labelled (is_labelled()) is left out, and so is a bundle whose rib the labels do not show.
std::vector<AssumedVessel> assumed_vessels(const mesh::LabelVolume& labels, const Anatomy& anatomy);
/// The same; nothing where the labels show no sternum, spine or ribs.
std::vector<AssumedVessel> assumed_vessels(const mesh::LabelVolume& labels);

/// Whether a name is of a mammary artery, as labels spell it.
bool is_mammary(std::string_view name);
/// Whether a label shows the vessel of this name: a label of the same name or, of a mammary artery, any label of a
/// mammary artery of the same side, or of no side.
bool is_labelled(std::string_view vessel, const mesh::LabelTable& table);
/// Whether a name is of an intercostal bundle. Every space has one, so it tells no approach from another.
bool is_neurovascular_bundle(std::string_view name);

/// Places along the line of a vessel, not farther apart than `step_mm`. @pre step_mm > 0
std::vector<Vec3> places_along(const AssumedVessel& vessel, double step_mm);

} // namespace retractor::planner
