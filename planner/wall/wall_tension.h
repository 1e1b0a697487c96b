#pragma once
// The tension that a wall is under before it is cut, by the pre-strain of its materials (pre_strain.h), and what a cut
// sets free of it. Planner and knife share it. Units mm, MPa; frame patient LPS.

#include "fem/material/material.h"
#include "fem/model/loads.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Whether the material is stretched at all: a strain of zero is none.
bool under_tension(const fem::Material& material);

/// Whether any of the materials is under tension.
bool under_tension(std::span<const fem::Material> materials);

struct WallTension {
    std::vector<Mat3> stress_of_element {}; ///< MPa; empty: no tissue is under any
    /// Per element: its direction of pre-strain points through the tissue, within kThroughTissueDeg of the normal.
    /// There is no along in the plane then, and the mean of both stresses acts both ways.
    std::vector<std::uint8_t> without_direction {};
    /// Tissue under tension without a normal of its own lies in the plane across `outward`, for no label is of the
    /// material "skin".
    bool without_skin = false;
};

inline constexpr double kThroughTissueDeg = 5.0;

/// The plane of tissue is that of the skin (labels of the material "skin") near by, unless the pre-strain has a normal
/// of its own.
/// @param uncut four-node elements. @param material_of_label with Poisson's ratios as they are solved with.
/// @param held vertices between which the wall was cut off, and has no skin: those that do not move, and
/// cut_off_vertices() (supports.h), for the spine may hold the wall and leave its rim free.
/// @param outward the normal of tissue that lies under no skin.
/// @throws InputError naming a label without a material, or the material's pre-strain that is out of range.
WallTension wall_tension(const mesh::TetMesh& uncut, std::span<const fem::Material> material_of_label,
    const mesh::LabelTable& table, std::span<const VertexId> held, const Vec3& outward);

/// What the wounds of a cut wall lose.
struct ReleasedTension {
    std::vector<fem::FaceTraction> tractions {};
    std::size_t without_direction = 0; ///< faces of elements that WallTension says so of
};

/// @param wall after the cut. @param origin per element of it, the element of the uncut wall that it is a part of.
ReleasedTension released_tension(const mesh::TetMesh& wall, std::span<const TetId> origin,
    std::span<const mesh::TetFace> wound, const WallTension& tension);

/// "4 % along (0, 0, 1), 2 % across", "4 % both ways", "4 % along (0, 0, 1), free to narrow".
std::string pre_strain_text(const fem::PreStrain& tension);

} // namespace retractor::planner
