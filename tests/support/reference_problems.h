#pragma once
// What the tests of fem/ share: materials, a linear solve with conditions on single unknowns, what an error says.

#include "fem/model/elastic_body.h"
#include "fem/material/material.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/verification/framework/meshes.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace retractor::fixtures {

Material material(double youngs_modulus_MPa, double poissons_ratio);

/// Every element of one material.
std::vector<Lame> uniform(const TetMesh& mesh, const Material& material);

/// One entry per unknown, 1 on the nodes of the mesh's boundary.
std::vector<std::uint8_t> boundary_unknowns(const TetMesh& mesh);

/// Linear elasticity under nodal loads with prescribed unknowns.
Eigen::VectorXd solve_linear(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads);

/// "where: what" of the Error that f throws, or "nothing was thrown".
std::string message_of(const std::function<void()>& f);

} // namespace retractor::fixtures
