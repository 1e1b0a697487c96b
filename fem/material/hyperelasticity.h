#pragma once
// Hyperelastic tissue at a point: energy, first Piola stress and tangent as functions of the deformation gradient F.
// Units MPa.
//
// All but the coupled neo-Hookean law are W(J^(-1/3) F) + K/2 (ln J)^2: a distortional energy of the part of F that
// keeps the volume, and a volumetric one [Simo, Taylor, Pister 1985, doi 10.1016/0045-7825(85)90033-7]. Where J = det F
// <= 0 the energy is infinite: a line search on the energy never turns an element over.

#include "fem/material/elasticity.h"
#include "fem/material/tissue_law.h"
#include "mesh/base/geometry.h"

namespace retractor::fem {

/// @throws InputError naming the law and the parameter that is NaN or out of its range.
void check_hyperelastic(const Hyperelastic& law);

/// The law with the bulk modulus that Poisson's ratio gives with its shear modulus at small strain; a neo-Hookean one
/// stays as it is.
Hyperelastic with_bulk(Hyperelastic law, double poissons_ratio);

/// Linear elasticity that the law turns into for small strains, fibres left out (Guccione: across them, bt).
Lame small_strain_moduli(const Hyperelastic& law);

struct HyperelasticPoint {
    double energy = 0.0; ///< N mm / mm^3; infinite where det F <= 0, and then the rest is zero
    Mat3 stress = Mat3::Zero(); ///< first Piola
    TangentMatrix tangent = TangentMatrix::Zero(); ///< dP/dF, symmetric; set when asked for
    double volume_ratio = 1.0; ///< det F
};
/// @pre check_hyperelastic(law), unit fibres.
HyperelasticPoint evaluate_point(
    const Hyperelastic& law, const FibreDirections& fibres, const Mat3& F, bool with_tangent);

/// Lifts negative eigenvalues of a symmetric tangent by the share `projected` of their size (1: the nearest positive
/// semidefinite one).
void lift_negative(TangentMatrix& tangent, double projected);

} // namespace retractor::fem
