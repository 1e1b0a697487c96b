#pragma once
// Reads a CalculiX deck that serves as a reference, and the displacements that CalculiX printed. The deck may have
// ten-node tetrahedra, one isotropic material, node sets, fixed and prescribed displacements, and nodal forces.

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

/// @throws IoError naming the file when the file cannot be read or refers to an undefined name.
CalculixModel read_calculix(const std::filesystem::path& file);

/// The printed displacements, one per vertex, mm.
/// @throws IoError when a vertex is missing.
std::vector<Vec3> read_calculix_displacements(const std::filesystem::path& file, const CalculixModel& model);

} // namespace retractor::verification
