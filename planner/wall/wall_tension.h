#pragma once
// The tension of a wall before the cut, from the pre-strain of its materials (fem/model/pre_strain.h), and the tension
// that a cut releases. Planner and knife share this code. Units mm, MPa; frame patient LPS.

#include "fem/material/material.h"
#include "fem/model/loads.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Whether the material has a pre-strain other than zero.
bool under_tension(const fem::Material& material);

/// Whether any of the materials has a pre-strain other than zero.
bool under_tension(std::span<const fem::Material> materials);

struct WallTension {
    std::vector<Mat3> stress_of_element {}; ///< stress of each element, MPa; empty: no tissue is under tension
    /// Flags the elements whose direction of pre-strain points through the tissue, within kThroughTissueDeg of the
    /// normal. The plane of such tissue has no direction along, so the mean of both stresses acts both ways.
    std::vector<std::uint8_t> without_direction {};
    /// No label is of the material "skin". Tissue under tension without its own normal then lies in the plane across
    /// `outward`.
    bool without_skin = false;
};

inline constexpr double kThroughTissueDeg = 5.0;

/// Computes the stress of each element before the cut. The plane of the tissue is the plane of the nearby skin (labels
/// of the material "skin"), unless the pre-strain has its own normal.
/// @param uncut four-node elements
/// @param material_of_label materials with the Poisson's ratios of the solution
/// @param held vertices of faces without skin, where the wall was cut off: the vertices that do not move, and
/// cut_off_vertices() (supports.h), because the spine may hold the wall and leave its rim free
/// @param outward the normal of tissue that lies under no skin
/// @throws InputError naming a label without a material, or a pre-strain that is out of range
WallTension wall_tension(const mesh::TetMesh& uncut, std::span<const fem::Material> material_of_label,
    const mesh::LabelTable& table, std::span<const VertexId> held, const Vec3& outward);

/// The tension that the wounds of a cut wall lose.
struct ReleasedTension {
    std::vector<fem::FaceTraction> tractions {};
    std::size_t without_direction = 0; ///< number of faces of elements flagged in WallTension::without_direction
};

/// @param wall the wall after the cut
/// @param origin element of the uncut wall to which each element of `wall` belongs
ReleasedTension released_tension(const mesh::TetMesh& wall, std::span<const TetId> origin,
    std::span<const mesh::TetFace> wound, const WallTension& tension);

/// Text for people: "4 % along (0, 0, 1), 2 % across", "4 % both ways", "4 % along (0, 0, 1), free to narrow".
std::string pre_strain_text(const fem::PreStrain& tension);

} // namespace retractor::planner
