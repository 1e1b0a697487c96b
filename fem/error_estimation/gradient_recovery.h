#pragma once
// How far an answer on ten-node elements is from smoother gradients that are fitted to it, and what that says of the
// error of a number taken from the answer. Units mm, N, MPa.
//
// Superconvergent patch recovery [Zienkiewicz, Zhu 1992, doi 10.1002/nme.1620330702]: round each vertex, and in each
// tissue by itself, a quadratic is fitted by least squares to the displacement's gradients at the points where
// ten-node elements have them best; between vertices it is interpolated quadratically. Where elements are so flat, or
// so few, that a quadratic would be carried far beyond what is known, it is a linear function or the mean. The distance
// in energy between those gradients and the answer's own estimates the answer's error in energy norm, smooth or not.

#include "fem/material/elasticity.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>

namespace retractor::fem {

/// Twice the energy of shape (N mm), of small strains on top of where the answer is, between its gradients and the
/// recovered ones. That of volume is left out: it is what plain four-node elements lock by, and in nearly
/// incompressible tissue would hide all else. @param mesh ten-node; fitted per label. @param model of the answer.
/// @param lame one per element. @param u three per node.
double recovered_energy(
    const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u);

/// The same between two answers on one mesh, on top of where the first is.
double energy_between(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u,
    const Eigen::VectorXd& other);

/// What ten-node elements still lack of a number, over what they add to that of plain four-node ones on the same mesh.
/// Numbers that are like energies (the work of a load, the force of what is moved) err in proportion to the squared
/// error in energy norm, and the squares of nested spaces add up [Ainsworth, Oden 2000]: the recovered energy over that
/// between the answers, of shape alone here. 1/3 where stress grows like one over the root of the distance, as at the
/// ends of a cut, less where it is smooth. Infinite where ten-node elements add nothing and yet lack something; where
/// it is above one, elements are too large or too flat to tell.
/// @param ten_node the answer, three per node. @param four_node plain elements' answer at the corners, which come
/// first. @throws InputError naming what does not fit the mesh.
double share_left(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame,
    const Eigen::VectorXd& ten_node, const Eigen::VectorXd& four_node);

} // namespace retractor::fem
