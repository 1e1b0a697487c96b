#pragma once
// A body for palpation: tetrahedra with their elasticity, the roles of the vertices, places to press and a pulse. Units
// mm, MPa; frame patient LPS. In CMake this module is retractor::elastic_model, which needs neither ITK nor VTK.

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::datasets {

/// The mechanical role of a vertex.
enum class VertexRole : std::uint8_t {
    free = 0, ///< the vertex moves
    fixed = 1, ///< the vertex does not move
    inner_wall = 2, ///< the vertex moves, and blood presses on its boundary faces
};

/// Tetrahedra with isotropic elasticity.
struct ElasticModel {
    mesh::TetMesh mesh;
    std::vector<VertexRole> roles; ///< one per vertex
    std::vector<double> youngs_modulus, poissons_ratio; ///< MPa and dimensionless; one per element
};

/// Checks a model.
/// @throws InputError as mesh::check_mesh() does, for wrong lengths, for a value outside its range (E > 0, -1 < nu <
/// 0.5; the message names the element or vertex), and when no vertex is fixed.
void check_elastic_model(const ElasticModel& model);

/// True when blood presses on the body from inside.
bool has_inner_wall(const ElasticModel& model);

/// A place to press.
struct TouchSite {
    std::string name;
    Vec3 point = Vec3::Zero(); ///< on the surface at rest, mm
    Vec3 outward = Vec3::UnitX(); ///< unit normal of the surface
};

/// One of several bodies in contact with each other.
struct TouchedOrgan {
    Label label = 0; ///< label of its elements
    std::string name;
};

/// A body with sites to press and a pulse.
struct PalpationScene {
    std::string name;
    ElasticModel body;
    std::vector<TouchSite> sites;
    /// Organs that the sphere model fills one by one; empty: the body is one organ.
    std::vector<TouchedOrgan> organs = {};
    int sheet_particles = 0; ///< particles along a side of the sheet of springs that represents the body; 0: no sheet
    /// The pulse of the blood.
    double heart_rate_per_min = 75.0, diastolic_mmHg = 80.0, systolic_mmHg = 120.0;
    double rest_mmHg = 80.0; ///< pressure at which the body has the shape of its mesh

    /// Finds a site by its name. @throws InputError naming the existing sites.
    const TouchSite& site(const std::string& wanted) const;
};

} // namespace retractor::datasets
