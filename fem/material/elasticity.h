#pragma once
// Elastic energy, stress and tangent at a point, as functions of the deformation gradient F. Units MPa.
//
// linear:       mu eps:eps + lambda/2 tr(eps)^2, eps = sym(F) - I.
// corotational: mu |F - R|^2 + lambda/2 (det F - 1)^2, R the rotation nearest to F [Stomakhin et al. 2012, eq. 4.2].
//               Below det F = 1/2 a cubic penalty, 10 (lambda + 2 mu) (1/2 - det F)^3, keeps crushed elements from
//               turning over. By its singular values, signed so that both bases are rotations, it also holds for
//               inverted F.
// bounded:      mu |F - R|^2 + lambda/2 tr(S - I)^2, S = R^T F: the linear model in the frame that turns with the
// tissue
//               [Mueller, Gross 2004]. Its stiffness nowhere exceeds that at rest, so that steps on an old factor go
//               on converging, flat elements among others included. Where tissue is stretched so far that this would
//               draw it thinner than nothing (three times its length at nu = 0.45), the pressure lambda tr(S - I) stays
//               at 1.8 mu: elements are not turned over by tension. They may be by compression.
// The tangent is kept in the basis of singular vectors, where it is three scalings coupled with each other and, per
// pair of axes, one flip and one twist [Smith, de Goes, Kim 2019, eq. 7-12]; clamping these makes it positive
// semidefinite.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

namespace retractor::fem {

/// `hyperelastic` stands for the laws of hyperelasticity.h; the functions below do not take it.
enum class Elasticity { linear, corotational, hyperelastic, corotational_linear };

/// Of the bounded model's pressure, in shear moduli: at two, tension alone would make tissue thinner than nothing.
inline constexpr double kLargestBoundedPressure = 1.8;

struct Lame {
    double mu = 0.0; ///< shear modulus, MPa
    double lambda = 0.0; ///< MPa
};

/// F = U diag(sigma) V^T with det U = det V = 1 and sigma0 >= sigma1 >= |sigma2|; sigma2 carries the sign of det F.
struct SignedSvd {
    Mat3 U, V;
    Vec3 sigma;
};

/// One-sided Jacobi: accurate also for repeated, tiny and zero singular values.
SignedSvd signed_svd(const Mat3& F);

/// dP/dF in the singular bases: with dF' = U^T dF V, dP'_ii = sum_j scaling(i, j) dF'_jj and, for i != j with k the
/// third axis, dP'_ij = same(k) dF'_ij + cross(k) dF'_ji.
struct Tangent {
    Mat3 U, V;
    Mat3 scaling;
    Vec3 same, cross;
};

/// Row and column 3 i + j stand for F(i, j).
using TangentMatrix = Eigen::Matrix<double, 9, 9>;

/// Derivative of the stress, its negative eigenvalues lifted by the share `projected` of their size: 0 leaves it as it
/// is, 1 gives the nearest positive semidefinite matrix. On the measure-zero
/// set sigma1 + sigma2 = 0, where the energy has a kink, the unprojected tangent is cut off at a large finite value.
Tangent tangent(Elasticity model, const Lame& lame, const Mat3& F, double projected);
TangentMatrix tangent_matrix(const Tangent& tangent);

/// Energy and stress by one decomposition.
struct PointResponse {
    double energy = 0.0; ///< per rest volume, N mm / mm^3
    Mat3 stress; ///< first Piola: the derivative of the energy density by F
    Tangent tangent; ///< set when asked for, projected
    double volume_ratio = 1.0; ///< det F
};
PointResponse evaluate_point(Elasticity model, const Lame& lame, const Mat3& F, bool with_tangent);

} // namespace retractor::fem
