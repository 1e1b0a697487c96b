#include "planner/wall/rim_motion.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"

#include <algorithm>
#include <array>
#include <set>

namespace retractor::planner {

namespace {

    /// A vertex nearer to the end of the image lies on the border of the image. The smooth surface of the mesh ends up
    /// to a voxel inside.
    constexpr double kImageEndVoxels = 2.0;

    /// Faces straddle the border of the region, whose tissue ends up to this distance inside it.
    constexpr double kRimBandMm = 10.0;

    using Place = std::array<double, 3>;

    Place place_of(const Vec3& p) { return { p.x(), p.y(), p.z() }; }

    bool is_at_image_end(const mesh::ImageGrid& grid, const Vec3& point)
    {
        const Vec3 index = grid.index(point);
        for (int axis = 0; axis < 3; ++axis) {
            const double last = grid.size[static_cast<std::size_t>(axis)] - 1.0;
            if (std::min(index[axis], last - index[axis]) < kImageEndVoxels)
                return true;
        }
        return false;
    }

} // namespace

std::vector<Vec3> rim_places(const mesh::TetMesh& uncut, std::span<const VertexId> cut_off, const RegionLimit& limit,
    const mesh::ImageGrid& grid)
{
    const auto is_at_limit = [&](const Vec3& p) {
        return limit.region_mm > 0.0 && polyline_distance(limit.line, p) >= limit.region_mm - kRimBandMm;
    };
    std::vector<Vec3> places;
    for (const VertexId v : cut_off)
        if (const Vec3 p = point_at(uncut.vertices, v); is_at_limit(p) || is_at_image_end(grid, p))
            places.push_back(p);
    return places;
}

std::vector<std::uint8_t> rim_flags(const mesh::TetMesh& wall, std::span<const Vec3> rim)
{
    std::set<Place> places;
    for (const Vec3& place : rim)
        places.insert(place_of(place));
    std::vector<std::uint8_t> flags(wall.vertex_count(), 0);
    for (VertexId v = 0; v < static_cast<VertexId>(wall.vertex_count()); ++v)
        flags[static_cast<std::size_t>(v)] = places.contains(place_of(point_at(wall.vertices, v))) ? 1 : 0;
    return flags;
}

RimMotions rim_motions(const mesh::TetMesh& wall, const Points& displacement, std::span<const VertexId> fixed,
    std::span<const std::uint8_t> is_rim, const mesh::ImageGrid& grid)
{
    RETRACTOR_ASSERT(is_rim.size() == wall.vertex_count() && wall.labels.size() == wall.tet_count());
    RETRACTOR_ASSERT(displacement.rows() == wall.vertices.rows());
    std::vector<std::uint8_t> counts(is_rim.begin(), is_rim.end());
    for (const VertexId v : fixed)
        if (static_cast<std::size_t>(v) < counts.size()) // midpoints of ten-node elements are no vertices of the wall
            counts[static_cast<std::size_t>(v)] = 0;
    RimMotions motions;
    for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t)
        for (const VertexId v : wall.tet(t)) {
            if (counts[static_cast<std::size_t>(v)] == 0)
                continue;
            counts[static_cast<std::size_t>(v)] = 0; // once is enough
            const Vec3 at = point_at(wall.vertices, v);
            RimMotion& part = is_at_image_end(grid, at) ? motions.image : motions.region;
            if (const double moved = displacement.row(v).norm(); moved > part.moved_mm)
                part = { moved, at, wall.labels[static_cast<std::size_t>(t)] };
        }
    return motions;
}

double moving_reach(
    const mesh::TetMesh& wall, const Points& displacement, std::span<const Vec3> polyline, double limit_mm)
{
    RETRACTOR_ASSERT(displacement.rows() == wall.vertices.rows());
    double reach = 0.0;
    for (VertexId v = 0; v < static_cast<VertexId>(wall.vertex_count()); ++v)
        if (displacement.row(v).norm() > limit_mm)
            reach = std::max(reach, polyline_distance(polyline, point_at(wall.vertices, v)));
    return reach;
}

} // namespace retractor::planner
