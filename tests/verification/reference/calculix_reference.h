#pragma once
// Reads the CalculiX deck that serves as a reference: ten-node tetrahedra, one isotropic material, node sets, fixed and
// prescribed displacements, nodal forces; and the displacements it printed.

#include "tests/verification/framework/meshes.h"

#include <filesystem>
#include <map>

namespace retractor::verification {

struct CalculixModel {
    mesh::TetMesh mesh;
    std::map<int, VertexId> vertex_of_number;
    Held held;
    Eigen::VectorXd loads;
    fem::Lame lame;
};

/// @throws IoError naming the file when it cannot be read or names what it does not define.
CalculixModel read_calculix(const std::filesystem::path& file);

/// One per vertex. @throws IoError when a vertex is missing.
std::vector<Vec3> read_calculix_displacements(const std::filesystem::path& file, const CalculixModel& model);

} // namespace retractor::verification
