#pragma once
// Writes and reads bodies for palpation. On disk, a body is a VTU file that ParaView and 3D Slicer open, with a scene
// file (JSON) beside it. Units mm, MPa; frame patient LPS.

#include "datasets/phantoms/elastic_model.h"

#include <filesystem>

namespace retractor::datasets {

/// Writes the point array "role" and the cell arrays "youngs_modulus_MPa" and "poissons_ratio".
/// @throws as mesh::write_vtu() and check_elastic_model() do.
void write_elastic_model(const std::filesystem::path& vtu, const ElasticModel& model);
/// Reads a model. @throws as mesh::read_vtu() and check_elastic_model() do; InputError naming a missing array.
ElasticModel read_elastic_model(const std::filesystem::path& vtu);

/// Writes `file` (JSON), and the mesh beside it as STEM.vtu. @throws InputError as write_elastic_model() does; IoError
/// when writing fails.
void write_palpation_scene(const std::filesystem::path& file, const PalpationScene& scene);
/// True when the file declares the format of a palpation scene, even when other parts of the file are wrong.
bool is_palpation_scene(const std::filesystem::path& file);
/// Reads a scene and its mesh.
/// @throws IoError when a file cannot be read; InputError naming the JSON pointer that is missing or wrong.
PalpationScene read_palpation_scene(const std::filesystem::path& file);

} // namespace retractor::datasets
