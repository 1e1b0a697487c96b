#pragma once
// Energy, first Piola stress and tangent of hyperelastic tissue at a point, as functions of the deformation gradient
// F. Units MPa.
//
// All laws but the coupled neo-Hookean one are W(J^(-1/3) F) + K/2 (ln J)^2 with J = det F: a distortional energy of
// the volume-preserving part of F, and a volumetric energy [Simo, Taylor, Pister 1985, doi
// 10.1016/0045-7825(85)90033-7]. Where J <= 0 the energy is infinite, so a line search on the energy never turns an
// element over.

#include "fem/material/elasticity.h"
#include "fem/material/tissue_law.h"
#include "mesh/base/geometry.h"

namespace retractor::fem {

/// @throws InputError naming the law and the parameter that is NaN or out of range.
void check_hyperelastic(const Hyperelastic& law);

/// The law with the bulk modulus that its shear modulus and Poisson's ratio give at small strain. A neo-Hookean law
/// is returned unchanged.
Hyperelastic with_bulk(Hyperelastic law, double poissons_ratio);

/// The law's linear elasticity at small strain, without fibres (Guccione: across the fibres, bt).
Lame small_strain_moduli(const Hyperelastic& law);

struct HyperelasticPoint {
    double energy = 0.0; ///< N mm / mm^3; infinite where det F <= 0, and all other members are then zero
    Mat3 stress = Mat3::Zero(); ///< first Piola
    TangentMatrix tangent = TangentMatrix::Zero(); ///< dP/dF, MPa, symmetric; computed on request
    double volume_ratio = 1.0; ///< det F
};
/// @pre check_hyperelastic(law) accepts the law, and the fibre directions are unit vectors.
HyperelasticPoint evaluate_point(
    const Hyperelastic& law, const FibreDirections& fibres, const Mat3& F, bool with_tangent);

/// Raises the negative eigenvalues of a symmetric tangent by the share `projected` of their size. A share of 1 gives
/// the nearest positive semidefinite tangent.
void lift_negative(TangentMatrix& tangent, double projected);

} // namespace retractor::fem
