#pragma once
// The stretch of tissue before anything is cut. pre_strain.h computes its stress. Frame patient LPS.

#include "mesh/base/geometry.h"

namespace retractor::fem {

enum class PreStrainKind {
    none,
    uniaxial_stress, ///< strain e along the pull, free across: stress E e along the pull, zero across
    /// strain e along the pull, zero across it in the plane, free in thickness: stress E e / (1 - nu^2) along the
    /// pull
    held_width,
    /// strains e along the pull and a across it, free in thickness: stress E (e + nu a) / (1 - nu^2) along the pull
    biaxial,
    equibiaxial, ///< strain e in both directions of the plane, free in thickness: stress E e / (1 - nu)
    isotropic, ///< strain e in all directions: stress E e / (1 - 2 nu)
};

struct PreStrain {
    PreStrainKind kind = PreStrainKind::none;
    double strain = 0.0; ///< strain e, 0 to kLargestPreStrain
    /// direction of the pull, any length; needed by uniaxial_stress, held_width, and biaxial with two different
    /// strains
    Vec3 pull = Vec3::Zero();
    /// Normal of the tissue's plane. Zero stands for the normal of the label's own surface nearby. The pull is
    /// projected into the plane. With uniaxial_stress and without a surface the pull is used unprojected.
    Vec3 normal = Vec3::Zero();
    double across = 0.0; ///< biaxial: the strain across the pull, same range as `strain`
};

/// Largest pre-strain for which small strains are a valid description. Published skin tension is 0.02 to 0.06.
inline constexpr double kLargestPreStrain = 0.5;

} // namespace retractor::fem
