#include "ui/scene/moving_scene.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/open_address_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui {

namespace {

    /// Cubes on each side of the origin that a key can number.
    constexpr std::int64_t kCubes = 1 << 19;

    bool is_fine(const FineLine& fine, const Vec3& point)
    {
        return !(fine.radius_mm > 0.0)
            || (point - fine.point).cross(fine.direction).squaredNorm() <= fine.radius_mm * fine.radius_mm;
    }

    /// The cube of a vertex, its size and the octant that the vertex faces.
    std::uint64_t key_of(const Vec3& point, const Vec3& normal, double cube_mm, const FineLine& fine)
    {
        const bool coarser = !is_fine(fine, point);
        std::uint64_t key = coarser ? 1 : 0;
        for (int axis = 0; axis < 3; ++axis)
            key = 2 * key + (normal[axis] < 0.0 ? 1 : 0);
        const double side = coarser ? kCoarserFactor * cube_mm : cube_mm;
        for (int axis = 0; axis < 3; ++axis) {
            const auto cube = static_cast<std::int64_t>(std::floor(point[axis] / side));
            // Points beyond the numbered cubes share the outermost ones.
            key = key * (2 * kCubes)
                + static_cast<std::uint64_t>(std::clamp<std::int64_t>(cube + kCubes, 0, 2 * kCubes - 1));
        }
        return key;
    }

    /// Normals of the vertices, weighted by area; not of unit length.
    std::vector<Vec3> vertex_normals(const TriMesh& surface)
    {
        std::vector<Vec3> normals(static_cast<std::size_t>(surface.vertices.rows()), Vec3::Zero());
        for (const auto& t : surface.triangles) {
            const Vec3 a = point_at(surface.vertices, t[0]);
            const Vec3 normal = (point_at(surface.vertices, t[1]) - a).cross(point_at(surface.vertices, t[2]) - a);
            for (const VertexId v : t)
                normals[static_cast<std::size_t>(v)] += normal;
        }
        return normals;
    }

    /// Area of a surface as it counts in triangles: the area beyond the fine line has fewer.
    double counted_area(const TriMesh& surface, const FineLine& fine)
    {
        double area = 0.0;
        for (const auto& t : surface.triangles) {
            const Vec3 a = point_at(surface.vertices, t[0]);
            const double own
                = 0.5 * (point_at(surface.vertices, t[1]) - a).cross(point_at(surface.vertices, t[2]) - a).norm();
            area += is_fine(fine, a) ? own : own / (kCoarserFactor * kCoarserFactor);
        }
        return area;
    }

    std::size_t triangles_of(const Scene& scene)
    {
        std::size_t count = 0;
        for (const SurfaceItem& item : scene.surfaces)
            count += item.mesh->triangles.size();
        return count;
    }

    /// The scene with every surface clustered.
    Scene clustered_scene(Scene scene, double cube_mm, const FineLine& fine)
    {
        for (SurfaceItem& item : scene.surfaces)
            item.mesh = std::make_shared<const TriMesh>(clustered(*item.mesh, cube_mm, fine));
        return scene;
    }

    /// A size of cube that leaves about the asked number of triangles. Meshes that are coarser than the cubes already
    /// make the first guess too large, so that it is corrected once from what it leaves.
    Scene with_fewer_triangles(const Scene& scene, std::size_t triangles)
    {
        const FineLine fine { .point = scene.camera.aim,
            .direction = (scene.camera.aim - scene.camera.eye).normalized(),
            .radius_mm = kFineRadiusMm };
        double area = 0.0;
        for (const SurfaceItem& item : scene.surfaces)
            area += counted_area(*item.mesh, fine);
        if (!(area > 0.0))
            return scene;
        // A clustered plane along the grid has two triangles for each square of a cube's side.
        double cube_mm = std::sqrt(2.0 * area / static_cast<double>(triangles));
        Scene fewer = clustered_scene(scene, cube_mm, fine);
        const double left = static_cast<double>(triangles_of(fewer)) / static_cast<double>(triangles);
        constexpr double kNear = 0.25; // 25 % more or fewer than asked is drawn as fast
        if (left > 0.0 && std::abs(left - 1.0) > kNear) {
            cube_mm *= std::sqrt(left);
            fewer = clustered_scene(scene, cube_mm, fine);
        }
        return fewer;
    }

} // namespace

TriMesh clustered(const TriMesh& surface, double cube_mm, const FineLine& fine)
{
    if (!(cube_mm > 0.0) || !std::isfinite(cube_mm))
        throw InputError("the cube's side must be positive, not " + std::to_string(cube_mm));
    if (!surface.vertices.allFinite())
        throw InputError("a coordinate is not finite");
    OpenAddressMap<VertexId> cube_of_key;
    std::vector<VertexId> cube_of(static_cast<std::size_t>(surface.vertices.rows()));
    std::vector<Vec3> sum;
    std::vector<int> count;
    const std::vector<Vec3> normals = vertex_normals(surface);
    for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
        const Vec3 point = surface.vertices.row(v).transpose();
        bool is_new = false;
        VertexId& cube = cube_of_key.at(key_of(point, normals[static_cast<std::size_t>(v)], cube_mm, fine), is_new);
        if (is_new) {
            cube = static_cast<VertexId>(sum.size());
            sum.emplace_back(Vec3::Zero());
            count.push_back(0);
        }
        cube_of[static_cast<std::size_t>(v)] = cube;
        sum[static_cast<std::size_t>(cube)] += point;
        ++count[static_cast<std::size_t>(cube)];
    }
    TriMesh result;
    result.vertices.resize(static_cast<Eigen::Index>(sum.size()), 3);
    for (std::size_t c = 0; c < sum.size(); ++c)
        result.vertices.row(static_cast<Eigen::Index>(c)) = (sum[c] / count[c]).transpose();
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        std::array<VertexId, 3> corners {};
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = cube_of[static_cast<std::size_t>(surface.triangles[t][k])];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            continue;
        result.triangles.push_back(corners);
        if (!surface.labels.empty())
            result.labels.push_back(surface.labels[t]);
    }
    return result;
}

Scene moving_scene(Scene scene, std::size_t triangles)
{
    RETRACTOR_ASSERT(triangles > 0);
    for (SurfaceItem& item : scene.surfaces) {
        item.look.texture = 0.0;
        for (auto& [label, look] : item.look_of_label)
            look.texture = 0.0;
    }
    return triangles_of(scene) > triangles ? with_fewer_triangles(scene, triangles) : scene;
}

} // namespace retractor::ui
