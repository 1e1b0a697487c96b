#pragma once
// Elastic energy, stress and tangent at a point, as functions of the deformation gradient F. Units MPa.
//
// linear:       mu eps:eps + lambda/2 tr(eps)^2, eps = sym(F) - I.
// corotational: mu |F - R|^2 + lambda/2 (det F - 1)^2, with R the rotation nearest to F [Stomakhin, Howes, Schroeder,
//               Teran 2012, eq. 4.2]. Below det F = 1/2 a cubic penalty, 33 (lambda + 2 mu) (1/2 - det F)^3, keeps
//               crushed elements from turning over. The energy is written by singular values with signs that make both
//               bases rotations; the energy therefore also holds for inverted F.
// corotational_linear: mu |F - R|^2 + lambda/2 tr(S - I)^2, S = R^T F: the linear model in a frame that turns with the
//               tissue [Mueller, Gross 2004]. The stiffness nowhere exceeds the stiffness at rest. Iterations on an old
//               factor therefore converge, also for flat elements. The pressure lambda tr(S - I) is bounded by 1.8 mu:
//               without the bound, tissue stretched to three times its length at nu = 0.45 would get a negative
//               thickness. The bound keeps tension, but not compression, from turning elements over.
//
// The tangent is stored in the basis of singular vectors. There the tangent consists of three coupled scalings and, for
// each pair of axes, one flip and one twist [Smith, de Goes, Kim 2019, eq. 7-12, doi 10.1145/3241041]. Clamping their
// eigenvalues makes the tangent positive semidefinite.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

namespace retractor::fem {

/// `hyperelastic` names the laws of hyperelasticity.h. The functions below do not accept `hyperelastic`.
enum class Elasticity { linear, corotational, hyperelastic, corotational_linear };

/// Bound of the pressure in the corotational_linear model, in shear moduli. With a bound of two, tension alone could
/// give tissue a negative thickness.
inline constexpr double kLargestCorotationalLinearPressure = 1.8;

struct Lame {
    double mu = 0.0; ///< shear modulus, MPa
    double lambda = 0.0; ///< Lame's first parameter, MPa
};

/// F = U diag(sigma) V^T with det U = det V = 1 and sigma0 >= sigma1 >= |sigma2|. sigma2 has the sign of det F.
struct SignedSvd {
    Mat3 U, V;
    Vec3 sigma;
};

/// Singular values by one-sided Jacobi rotations, accurate also for repeated, tiny and zero singular values.
SignedSvd signed_svd(const Mat3& F);

/// The derivative dP/dF of the first Piola stress, in the singular bases. With dF' = U^T dF V and dP' = U^T dP V:
/// dP'_ii = sum_j scaling(i, j) dF'_jj, and dP'_ij = same(k) dF'_ij + cross(k) dF'_ji for i != j, with k the third
/// axis.
struct Tangent {
    Mat3 U, V;
    Mat3 scaling;
    Vec3 same, cross;
};

/// Row and column 3 i + j belong to the entry F(i, j).
using TangentMatrix = Eigen::Matrix<double, 9, 9>;

/// Derivative of the first Piola stress by F.
/// @param projected the share of their size by which negative eigenvalues are raised: 0 gives the true tangent, 1 the
/// nearest positive semidefinite one. On the measure-zero set sigma1 + sigma2 = 0, where the energy has a kink, the
/// true tangent is bounded at a large finite value.
Tangent tangent(Elasticity model, const Lame& lame, const Mat3& F, double projected);
/// As above, but with all negative eigenvalues raised where F stretches an axis to more than twice its length or
/// presses it to less than half. Slivers at the tip of a cut do so. They bear little force, and their negative
/// eigenvalues make the stiffness of a whole wall indefinite.
Tangent tangent_raised_at_extremes(Elasticity model, const Lame& lame, const Mat3& F, double projected);
TangentMatrix tangent_matrix(const Tangent& tangent);

/// Energy, stress and tangent, computed from one singular value decomposition.
struct PointResponse {
    double energy = 0.0; ///< per rest volume, N mm / mm^3
    Mat3 stress; ///< first Piola stress: the derivative of the energy density by F, MPa
    Tangent tangent; ///< computed on request, projected to positive semidefinite
    double volume_ratio = 1.0; ///< det F
};
PointResponse evaluate_point(Elasticity model, const Lame& lame, const Mat3& F, bool with_tangent);

} // namespace retractor::fem
