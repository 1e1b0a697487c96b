#pragma once
// How far the wall moves where the model was cut off from the rest of the body. There nothing beyond holds the tissue,
// so a rim that moves says that the region is too small. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::planner {

/// The limit of a meshed region (mesh::MeshSizing).
struct RegionLimit {
    std::vector<Vec3> line; ///< mesh::region_line()
    double region_mm = 0.0; ///< 0: no limit
};

/// The rim of the model: places of the vertices where the wall goes on beyond the mesh or the image ends. Cuts leave
/// these places where they are, so that the places name the rim's vertices in the cut wall too.
/// Inside the region no wall was cut off. Vertices there that cut_off_vertices() names lie on long faces that run a
/// little below the body's surface, and are left out.
/// @param uncut the wall before any cut; @param cut_off its cut_off_vertices()
std::vector<Vec3> rim_places(const mesh::TetMesh& uncut, std::span<const VertexId> cut_off, const RegionLimit& limit,
    const mesh::ImageGrid& grid);

/// Per vertex of a wall, whether it lies at a place of the rim.
std::vector<std::uint8_t> rim_flags(const mesh::TetMesh& wall, std::span<const Vec3> rim);

/// The largest motion of a part of the rim.
struct RimMotion {
    double moved_mm = 0.0; ///< 0 also where no vertex belongs to this part
    Vec3 at = Vec3::Zero(); ///< place of this vertex at rest, mm
    Label label = 0; ///< of an element at this vertex
};

struct RimMotions {
    RimMotion region; ///< where the region ends inside the image: bare bones too
    RimMotion image; ///< where the image ends: no region can be larger there
};

/// @param displacement n x 3, mm, one row per vertex of the wall
/// @param fixed vertices that are held, and do not count; midpoints of ten-node elements are passed over
/// @param is_rim one per vertex of the wall, see rim_flags()
RimMotions rim_motions(const mesh::TetMesh& wall, const Points& displacement, std::span<const VertexId> fixed,
    std::span<const std::uint8_t> is_rim, const mesh::ImageGrid& grid);

/// The largest distance from a polyline of a vertex that moves farther than `limit_mm`; 0 where none does.
double moving_reach(
    const mesh::TetMesh& wall, const Points& displacement, std::span<const Vec3> polyline, double limit_mm);

} // namespace retractor::planner
