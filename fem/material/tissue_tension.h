#pragma once
// What tissue is stretched by before anything is cut; what it does is in pre_strain.h. Frame patient LPS.

#include "mesh/base/geometry.h"

namespace retractor::fem {

enum class PreStrainKind {
    none,
    uniaxial_stress, ///< strain e along the pull, free to narrow: stress E e along it, none across
    held_width, ///< strain e along the pull, none across it in the plane, free in thickness: E e / (1 - nu^2) along it
    biaxial, ///< strains e along the pull and a across it, free in thickness: E (e + nu a) / (1 - nu^2) along it
    equibiaxial, ///< strain e both ways in the plane, free in thickness: E e / (1 - nu)
    isotropic, ///< strain e every way: E e / (1 - 2 nu)
};

struct PreStrain {
    PreStrainKind kind = PreStrainKind::none;
    double strain = 0.0; ///< 0 to kLargestPreStrain
    Vec3 pull = Vec3::Zero(); ///< uniaxial_stress, held_width, biaxial of two strains that differ; need not be unit
    /// Across the tissue's plane; zero: that of the label's own surface near by. The pull is put into the plane; zero
    /// with uniaxial_stress leaves it as it is when there is no surface either.
    Vec3 normal = Vec3::Zero();
    double across = 0.0; ///< biaxial: the strain across the pull, in the range of `strain`
};

/// Beyond it small strains are no description of anything: published skin tension is 0.02 to 0.06.
inline constexpr double kLargestPreStrain = 0.5;

} // namespace retractor::fem
