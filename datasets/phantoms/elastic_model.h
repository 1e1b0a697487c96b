#pragma once
// A body to be touched: tetrahedra with their elasticity, and what its vertices are to it. On disk a VTU file that
// ParaView and 3D Slicer open, and a scene file (JSON) beside it. Units mm, MPa; frame patient LPS.

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

enum class VertexRole : std::uint8_t {
    free = 0, ///< moves
    fixed = 1, ///< does not
    inner_wall = 2, ///< moves; blood presses on the boundary faces that have such a vertex
};

struct ElasticModel {
    mesh::TetMesh mesh;
    std::vector<VertexRole> roles; ///< one per vertex
    std::vector<double> youngs_modulus, poissons_ratio; ///< MPa, -; one per element
};

/// @throws InputError as check_mesh does, on wrong lengths, and naming the element or vertex whose value is out of its
/// range (E > 0, -1 < nu < 0.5), or that no vertex is fixed.
void check_elastic_model(const ElasticModel& model);

/// Whether blood presses on it from inside.
bool has_inner_wall(const ElasticModel& model);

/// Point array "role", cell arrays "youngs_modulus_MPa" and "poissons_ratio". @throws as write_vtu and the check.
void write_elastic_model(const std::filesystem::path& vtu, const ElasticModel& model);
/// @throws as read_vtu and the check; InputError naming the array that is missing.
ElasticModel read_elastic_model(const std::filesystem::path& vtu);

/// A place where a finger presses.
struct TouchSite {
    std::string name;
    Vec3 point = Vec3::Zero(); ///< on the surface at rest
    Vec3 outward = Vec3::UnitX(); ///< unit normal there
};

/// One of several bodies that touch each other.
struct TouchedOrgan {
    Label label = 0; ///< of its elements
    std::string name;
};

struct PalpationScene {
    std::string name;
    ElasticModel body;
    std::vector<TouchSite> sites;
    std::vector<TouchedOrgan> organs = {}; ///< what spheres fill, one by one; empty: the body is one
    int sheet_particles = 0; ///< a side of the sheet of springs that the body stands for; 0: none
    double heart_rate_per_min = 75.0, diastolic_mmHg = 80.0, systolic_mmHg = 120.0;
    double rest_mmHg = 80.0; ///< the pressure at which the body has the shape of its mesh

    /// @throws InputError naming the sites there are.
    const TouchSite& site(const std::string& wanted) const;
};

/// `file` (JSON) and the mesh beside it, as STEM.vtu. @throws IoError, InputError.
void write_palpation_scene(const std::filesystem::path& file, const PalpationScene& scene);
/// Whether a file says that it is one, whatever else is wrong with it.
bool is_palpation_scene(const std::filesystem::path& file);
/// @throws IoError when a file cannot be read; InputError naming the JSON pointer that is missing or wrong.
PalpationScene read_palpation_scene(const std::filesystem::path& file);

} // namespace retractor::datasets
