#pragma once
// Reads the FEBio 4.0 model files that serve as references: one part of four-node tetrahedra, node sets, one surface,
// fixed and prescribed displacements, one traction or nodal force, neo-Hookean or Mooney-Rivlin.

#include "fem/material/hyperelasticity.h"
#include "fem/model/loads.h"
#include "tests/verification/framework/meshes.h"

#include <filesystem>

namespace retractor::verification {

struct FebioModel {
    mesh::TetMesh mesh;
    Held held; ///< at the end of the step
    Eigen::VectorXd loads; ///< nodal, at the end of the step
    fem::Hyperelastic law;
    std::string law_name;
};

/// @throws IoError naming the file when it cannot be read, and the tag that is missing.
FebioModel read_febio(const std::filesystem::path& file);

} // namespace retractor::verification
