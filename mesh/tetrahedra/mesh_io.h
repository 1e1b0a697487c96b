#pragma once
// Meshes as VTK files (ParaView, 3D Slicer): VTU for tetrahedra, VTP for surfaces, both XML with appended binary data.
// Units mm; frame patient LPS, stated in the file as the field data string "frame". Files are written atomically.
// In CMake this module is the library retractor::mesh_io.

#include "mesh/tetrahedra/tet_mesh.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::mesh {

/// Named values on a mesh.
struct MeshFields {
    std::map<std::string, Points> point_vectors; ///< n x 3, one row per vertex; e.g. "displacement" (mm)
    std::map<std::string, std::vector<double>> point_scalars; ///< one per vertex
    std::map<std::string, std::vector<double>> cell_scalars; ///< one per element
    std::map<std::string, std::string> texts; ///< field data strings; written but not read back
};

/// Writes elements with 4 or 10 nodes. The element labels become the cell array "label".
/// @throws InputError as check_mesh(), or naming a field of the wrong length; IoError when writing fails
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh, const MeshFields& fields = {});

/// Reads a file of write_vtu(). `fields`, when not null, receives the other arrays.
/// @throws IoError naming the file and the fault (no such file, no VTU, other cell types, no "label", a frame other
/// than LPS); InputError as check_mesh()
TetMesh read_vtu(const std::filesystem::path& path, MeshFields* fields = nullptr);

/// Writes triangles. Their labels, when present, become the cell array "label".
/// @throws InputError naming the triangle or vertex that is out of range or not finite; otherwise as write_vtu()
void write_vtp(const std::filesystem::path& path, const TriMesh& mesh, const MeshFields& fields = {});

/// Writes triangles as binary STL, which holds no labels. @throws as write_vtp()
void write_stl(const std::filesystem::path& path, const TriMesh& mesh);

} // namespace retractor::mesh
