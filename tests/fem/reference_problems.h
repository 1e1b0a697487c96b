#pragma once
// What the tests of fem/ share: small meshes and a linear solve with conditions on single unknowns.

#include "fem/elastic_body.h"
#include "fem/material.h"
#include "mesh/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <vector>

namespace retractor::testing {

Material material(double youngs_modulus_MPa, double poissons_ratio);

/// Every element of one material.
std::vector<Lame> uniform(const TetMesh& mesh, const Material& material);

/// Kuhn box with its inner vertices moved at random by up to `share` of the spacing.
TetMesh distorted_box(int n, double spacing, double share, unsigned seed);

/// The stiffness as a dense matrix.
Eigen::MatrixXd dense(const BlockMatrix& K);

/// Three entries per node.
Eigen::VectorXd nodal(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field);

/// One entry per unknown, 1 on the nodes of the mesh's boundary.
std::vector<std::uint8_t> boundary_unknowns(const TetMesh& mesh);

/// Linear elasticity under nodal loads with prescribed unknowns.
Eigen::VectorXd solve_linear(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads);

/// Consistent nodal loads of a body force.
Eigen::VectorXd body_loads(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& force);

/// Square root of the integral of |u_h - u|^2.
double l2_error(const TetMesh& mesh, const Eigen::VectorXd& u_h, const std::function<Vec3(const Vec3&)>& u);

} // namespace retractor::testing
