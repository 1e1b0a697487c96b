#pragma once
// Recovered gradients: smooth gradients fitted to an answer on ten-node elements. Their distance from the answer's
// own gradients estimates the error of the answer and of numbers taken from the answer. Units mm, N, MPa.
//
// Superconvergent patch recovery [Zienkiewicz, Zhu 1992, doi 10.1002/nme.1620330702]: round each vertex, and in each
// tissue separately, a quadratic is fitted by least squares to the displacement gradients at the points where
// ten-node elements are most accurate. Between vertices the fit is interpolated quadratically. Where the elements are
// so flat or so few that a quadratic would extrapolate far, a linear function or the mean is fitted instead. The
// distance in energy between the recovered gradients and the answer's own gradients estimates the answer's error in
// energy norm, for smooth and singular fields.

#include "fem/material/elasticity.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>

namespace retractor::fem {

/// Twice the distortional energy (N mm) of the difference between the answer's gradients and the recovered ones, as
/// small strains on top of the answer. Volumetric energy is left out: plain four-node elements lock by volumetric
/// energy, which would dominate the result in nearly incompressible tissue.
/// @param mesh ten-node elements; gradients are fitted per label.
/// @param model elasticity of the answer.
/// @param lame one per element.
/// @param u the answer, three per node, mm.
double recovered_energy(
    const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u);

/// Twice the distortional energy of the difference of two answers on one mesh, as small strains on top of the first
/// answer, N mm.
double energy_between(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u,
    const Eigen::VectorXd& other);

/// Remaining error of a number from ten-node elements, relative to the change of this number from plain four-node to
/// ten-node elements on the same mesh. Numbers that behave like energies (the work of a load, the force of a
/// prescribed motion) have errors in proportion to the squared error in energy norm, and these squares add up in
/// nested spaces [Ainsworth, Oden 2000]. The share is therefore recovered_energy() over energy_between(). The share
/// is 1/3 where stress grows like one over the root of the distance, as at the ends of a cut, and smaller where
/// stress is smooth. The share is infinite when the two answers are equal and the recovered gradients still differ.
/// Above one the elements are too large or too flat for an estimate.
/// @param ten_node the answer, three per node, mm.
/// @param four_node the answer of plain elements at the corners, which come first, mm.
/// @throws InputError naming the argument that does not fit the mesh.
double share_left(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame,
    const Eigen::VectorXd& ten_node, const Eigen::VectorXd& four_node);

} // namespace retractor::fem
