#pragma once
// Compares the moments in ribs and sternum with those at which tested bones broke, and says from which opening on a
// bone would break. Units mm, N, N m; frame patient LPS.
//
// Capacity of a rib: 52 pieces of ribs of four bodies broke at bending moments of 2.0 N m in the anterior, 2.9 N m in
// the lateral and 3.9 N m in the posterior part, in the mean (Cormier, Stitzel, Duma, Matsuoka 2005, PMC3217457). The
// place on a rib is the angle round the chest: 45 degrees from straight back counts as posterior, 90 as lateral, 135 as
// anterior, linear between. The capacity grows with the outer area of the section to the power of 1.5, as the section
// modulus of similar sections does.
// - Torsion: no capacity of a rib in torsion is published. Bending M and torsion T together count as the bending moment
//   (M + sqrt(M^2 + T^2)) / 2, which has the same largest tension in a round tube (Timoshenko, Strength of Materials,
//   part 1, combined bending and torsion; largest principal stress).
// - Sternum, joints and cartilage: no capacity is published; their loads are given without one.
// - Age: the capacity is not changed. Cortical bone of ribs thins by 0.01 to 0.04 mm in ten years (Holcombe, Derstine
//   2022, J Anat), but how old the tested bodies were per piece, and how thick their bone, is not known here.

#include "planner/anatomy/anatomy.h"
#include "planner/measures/bones/section_moments.h"
#include "planner/measures/field_metrics.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Mean bending moments at which pieces of ribs broke (Cormier 2005), N m.
inline constexpr double kPosteriorRibNm = 3.9, kLateralRibNm = 2.9, kAnteriorRibNm = 2.0;

/// Outer area of the section for which these moments are taken to hold, mm^2. The areas of the tested ribs are not
/// known here: an assumption, the area of an ellipse of 13.5 by 7 mm, as of an adult's middle rib.
inline constexpr double kTestedRibAreaMm2 = 75.0;

/// The change of the capacity with the section stays within these factors. Adults' ribs vary less in area; a larger
/// ratio comes from labels that are too thick or too thin.
inline constexpr double kSmallestSectionFactor = 0.6, kLargestSectionFactor = 1.5;

/// The labels whose moments are computed: ribs ("rib_left_5") and the sternum.
bool is_rib(std::string_view label);
bool is_long_bone(std::string_view label);

/// Angle of a point round the chest: 0 straight back, 90 lateral, 180 straight ahead, on either side.
double angle_round_chest_deg(const AnatomicalFrame& frame, const Vec3& point);

/// Capacity of a rib's section, N m.
double rib_capacity_Nm(double angle_deg, double section_mm2);

/// The bending moment with the same largest tension as bending and torsion together.
double equivalent_moment_Nm(double bending_Nm, double torsion_Nm);

/// The worst section of a bone: of its pieces the one, and there the section, with the largest utilisation, or without
/// a capacity with the largest moment.
/// @param pieces at least one with sections
BoneMetrics bone_limit(const std::string& name, std::span<const BoneBar> pieces, const AnatomicalFrame& frame);

/// Sorts the bones, and sets the openings at which bones reach their capacity, `attainable` and
/// `largest_uninjured_opening_mm`. Skin that would tear is an injury too (ball_strain.h); the uninjured opening is that
/// of the bones alone.
/// @param in_equilibrium false: the field is not attainable, whatever its bones bear
/// @pre field.hooks, field.tissue_strain, and field.bones or field.bones_message are filled
void set_attainable(FieldMetrics& field, bool in_equilibrium);

/// Whether the largest uninjured opening was solved; otherwise it is an estimate in proportion.
bool is_uninjured_opening_solved(const FieldMetrics& field);

/// Whether a bone is loaded beyond its capacity. @pre set_attainable() was called
bool breaks_bone(const FieldMetrics& field);

/// "yes", "with_injury", "no", "unknown": the words of metrics.json.
std::string_view to_string(Attainable attainable);

/// "27 mm": the opening from which the bone would break, rounded down.
/// @pre bone.opening_at_limit_mm is set
std::string opening_at_limit_text(const BoneMetrics& bone);

/// "rib 5 on the left", "the sternum".
std::string bone_in_words(std::string_view label);
/// The text with a capital letter first.
std::string capital(std::string text);

/// Short: "yes", "with injury: rib 5 on the left, skin", "no", "not known".
std::string attainable_text(const FieldMetrics& field);

/// One or two sentences for people about the bone that is loaded most: "Rib 5 on the left would break ...".
std::string bones_text(const FieldMetrics& field);

/// One sentence about the loads of a bone's joints; empty without any.
std::string joints_text(const FieldMetrics& field);

} // namespace retractor::planner
