#pragma once
// Bending moment and torsion in the sections of a long bone. Units mm, N, N m; frame patient LPS.
//
// The bone is cut by sections across its centre-line. The part beyond a section is a free body: the forces on its nodes
// from outside the bone are in balance with the traction in the section. Their moment about the section's centroid,
// M = sum (x - c) x f, has the part T along the bone's axis, the torsion, and the part across the axis, the bending
// moment (Timoshenko, Strength of Materials, part 1, chapters 4 and 10). This holds for any law of the bone. What the
// mesh leaves in error is the forces on the bone, not their sum: a bone with few elements across has the same moments.

#include "mesh/base/geometry.h"
#include "planner/measures/bones/bone_forces.h"

#include <vector>

namespace retractor::planner {

/// Distance between sections: about half the thickness of a rib.
inline constexpr double kSectionSpacingMm = 5.0;

struct BoneSection {
    double at_mm = 0.0; ///< distance from the first end, along the centre-line
    Vec3 centre = Vec3::Zero(); ///< centroid of the section at rest, mm
    double area_mm2 = 0.0; ///< outer area at rest
    double bending_Nm = 0.0, torsion_Nm = 0.0; ///< magnitudes
};

/// A piece of a bone with its sections, from its first end to its last.
struct BoneBar {
    double length_mm = 0.0; ///< 0: too short for sections
    std::vector<BoneSection> sections;
};

/// The sections of a piece, with `spacing_mm` between them and from the ends.
/// @throws InputError when the spacing is not positive
BoneBar section_moments(const BoneForces& bone, double spacing_mm = kSectionSpacingMm);

/// The same bar with its ends exchanged.
BoneBar reversed(BoneBar bar);

} // namespace retractor::planner
