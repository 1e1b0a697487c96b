#pragma once
// Reads the FEBio 4.0 model files that serve as references: one part of four-node tetrahedra, node sets, one surface,
// fixed and prescribed displacements, one traction or nodal force, and a neo-Hookean or Mooney-Rivlin material.

#include "fem/material/hyperelasticity.h"
#include "fem/model/loads.h"
#include "tests/verification/framework/meshes.h"

#include <filesystem>

namespace retractor::verification {

struct FebioModel {
    mesh::TetMesh mesh;
    Held held; ///< prescribed displacements at the end of the step, mm
    Eigen::VectorXd loads; ///< nodal forces at the end of the step, N
    fem::Hyperelastic law;
    std::string law_name;
};

/// @throws IoError naming the file that cannot be read, or the missing tag.
FebioModel read_febio(const std::filesystem::path& file);

} // namespace retractor::verification
