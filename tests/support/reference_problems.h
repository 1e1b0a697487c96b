#pragma once
// Shared by tests of mechanics: materials, and a linear solve with prescribed unknowns; includes the message of an
// error. Units mm, N, MPa.

#include "fem/material/material.h"
#include "fem/model/elastic_body.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/support/test_help.h"
#include "tests/verification/framework/meshes.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::test_support {

fem::Material material(double youngs_modulus_MPa, double poissons_ratio);

/// The Lame parameters of every element, for one material.
std::vector<fem::Lame> uniform(const mesh::TetMesh& mesh, const fem::Material& material);

/// One entry per unknown: 1 on boundary nodes of the mesh, else 0.
std::vector<std::uint8_t> boundary_unknowns(const mesh::TetMesh& mesh);

/// Displacements (mm) of linear elasticity under nodal loads (N), with prescribed values (mm) of the marked unknowns.
/// All vectors have one entry per unknown.
Eigen::VectorXd solve_linear(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads);

} // namespace retractor::test_support
