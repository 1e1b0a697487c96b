#pragma once
// What the tests of fem/ share: materials, a linear solve with conditions on single unknowns, what an error says.

#include "fem/material/material.h"
#include "fem/model/elastic_body.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/verification/framework/meshes.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace retractor::test_support {

fem::Material material(double youngs_modulus_MPa, double poissons_ratio);

/// Every element of one material.
std::vector<fem::Lame> uniform(const mesh::TetMesh& mesh, const fem::Material& material);

/// One entry per unknown, 1 on the nodes of the mesh's boundary.
std::vector<std::uint8_t> boundary_unknowns(const mesh::TetMesh& mesh);

/// Linear elasticity under nodal loads with prescribed unknowns.
Eigen::VectorXd solve_linear(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads);

/// "where: what" of the Error that f throws, or "nothing was thrown".
std::string message_of(const std::function<void()>& f);

} // namespace retractor::test_support
