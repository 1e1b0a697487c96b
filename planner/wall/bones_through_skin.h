#pragma once
// Finds bones that come out through the skin. Bones are meshed to their ends, also where the tissue round them is not
// (MeshSizing::whole_labels). A bone that is bare in the model is not held back by its tissue, and the skin beyond the
// region is only drawn (unmeshed_wall.h), so such a bone can pass through the skin. That is a failure of the model.
// Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// A bone that passes through the skin.
struct PiercingBone {
    std::string name; ///< label
    double out_mm = 0.0; ///< largest distance of its surface outside the skin
    Vec3 at = Vec3::Zero(); ///< this place of the bone at rest, mm
};

/// A bone that is less far outside lies within the error of the surfaces, which are smoothed from voxels.
inline constexpr double kLeastPiercingMm = 2.0;

/// Measures the signed distance of bare bones from the deformed skin: the skin of the mesh, and of the wall beyond the
/// mesh. A place whose nearest skin is the open edge of that surface (a lip, the rim) says nothing, and is left out.
/// Without a wall beyond the mesh, the coarse skin of a whole wall may run below the end of a bone in the image. Then
/// the distance at rest is taken off.
/// @param wall the cut wall at rest; @param displacement n x 3, mm, one row per vertex
/// @param is_rim one per vertex of the wall, see rim_flags()
/// @param beyond the deformed wall beyond the mesh with one label per triangle (unmeshed_wall_region()); may be empty
/// @returns the bones that are at least kLeastPiercingMm outside, the farthest first
std::vector<PiercingBone> bones_through_skin(const mesh::TetMesh& wall, const Points& displacement,
    std::span<const std::uint8_t> is_rim, const TriMesh& beyond, const mesh::LabelTable& table);

} // namespace retractor::planner
