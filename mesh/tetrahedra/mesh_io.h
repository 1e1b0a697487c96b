#pragma once
// Meshes as VTK files (ParaView, 3D Slicer): VTU for tetrahedra, VTP for surfaces; XML with binary appended
// data. Units mm; patient LPS, stated in the file as the field data string "frame". Written whole or not at all.

#include "mesh/tetrahedra/tet_mesh.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::mesh {

/// Named values on a mesh.
struct MeshFields {
    std::map<std::string, Points> point_vectors; ///< n x 3 each, one row per vertex, e.g. "displacement" in mm
    std::map<std::string, std::vector<double>> point_scalars;
    std::map<std::string, std::vector<double>> cell_scalars; ///< one per element
    std::map<std::string, std::string> texts; ///< field data strings; written, not read back
};

/// Elements with 4 or 10 nodes; the element labels become the cell array "label".
/// @throws InputError as check_mesh does, or naming a field whose length does not fit; IoError when writing fails.
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh, const MeshFields& fields = {});

/// What write_vtu wrote. `fields`, when given, receives the other arrays.
/// @throws IoError naming the file and what is missing or wrong in it (no such file, no VTU, other cell types, no
/// "label", a frame other than LPS), InputError as check_mesh does.
TetMesh read_vtu(const std::filesystem::path& path, MeshFields* fields = nullptr);

/// Triangles; their labels, when there are any, become the cell array "label".
/// @throws InputError naming the triangle or vertex that is out of range or not finite, or as write_vtu.
void write_vtp(const std::filesystem::path& path, const TriMesh& mesh, const MeshFields& fields = {});

} // namespace retractor::mesh
