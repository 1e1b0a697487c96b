#include "planner/session/wall_picture.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace retractor::planner {

namespace {

    /// Radius over which the surface is averaged to find the inward direction: larger than an element of the skin,
    /// smaller than the curvature of a rib cage.
    constexpr double kNormalRadiusMm = 15.0;
    /// Smallest cosine between a face and the touched face on the same side of the body.
    constexpr double kSameSide = 0.25;
    /// A narrower gap behind the wall is no cavity.
    constexpr double kCavityMm = 4.0;
    constexpr std::size_t kThicknessSamples = 40;

    /// Where a ray meets a triangle, from either side.
    std::optional<LineHit> meet(const Ray& ray, const std::array<Vec3, 3>& p)
    {
        const auto hit = line_hit(ray.origin, ray.direction, p);
        return hit && hit->distance > 0.0 ? hit : std::nullopt;
    }

    /// Mean inward rest normal of the skin round a place; nearer faces weigh more.
    Vec3 inward_near(const WallSurface& surface, const Vec3& at, const Vec3& own)
    {
        Vec3 sum = Vec3::Zero();
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            if (surface.is_lip[t] != 0)
                continue;
            const auto p = triangle_corners(surface.rest, surface.triangles[t]);
            const double share = 1.0 - ((p[0] + p[1] + p[2]) / 3.0 - at).squaredNorm() / std::pow(kNormalRadiusMm, 2);
            if (share <= 0.0)
                continue;
            const Vec3 area = area_vector(p);
            if (area.dot(own) > kSameSide * area.norm() * own.norm())
                sum += share * area;
        }
        return sum.norm() > 0.0 ? Vec3(-sum.normalized()) : Vec3(-own.normalized());
    }

    /// Distance at which a ray that starts in the wall finally leaves it, by counting exits minus entries.
    std::optional<double> far_side(const WallSurface& surface, const Ray& ray, double limit_mm)
    {
        std::vector<std::pair<double, int>> passages;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            if (surface.is_lip[t] != 0)
                continue;
            const auto p = triangle_corners(surface.rest, surface.triangles[t]);
            if (const auto hit = meet(ray, p); hit && hit->distance <= limit_mm)
                passages.emplace_back(hit->distance, area_vector(p).dot(ray.direction) > 0.0 ? -1 : 1);
        }
        std::sort(passages.begin(), passages.end());
        int inside = 1;
        for (std::size_t i = 0; i < passages.size(); ++i) {
            inside += passages[i].second;
            const bool ends = i + 1 == passages.size() || passages[i + 1].first - passages[i].first > kCavityMm;
            if (inside <= 0 && ends)
                return passages[i].first;
        }
        return std::nullopt;
    }

} // namespace

std::optional<Touch> touch(const WallPicture& picture, const Ray& ray)
{
    const WallSurface& surface = *picture.surface;
    RETRACTOR_ASSERT(picture.shown.rows() == surface.rest.rows());
    std::optional<LineHit> nearest;
    std::size_t where = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const auto p = triangle_corners(picture.shown, surface.triangles[t]);
        const auto hit = meet(ray, p);
        if (hit && (!nearest || hit->distance < nearest->distance)) {
            nearest = hit;
            where = t;
        }
    }
    if (!nearest)
        return std::nullopt;
    const auto p = triangle_corners(surface.rest, surface.triangles[where]);
    Touch found;
    found.rest = (1.0 - nearest->u - nearest->v) * p[0] + nearest->u * p[1] + nearest->v * p[2];
    found.shown = ray.origin + nearest->distance * ray.direction;
    found.inward = inward_near(surface, found.rest, area_vector(p));
    found.triangle = surface.triangles[where];
    found.label = surface.labels[where];
    found.on_lip = surface.is_lip[where] != 0;
    found.distance = nearest->distance;
    return found;
}

std::optional<double> first_hit(const TriMesh& surface, const Ray& ray)
{
    std::optional<double> nearest;
    for (const auto& triangle : surface.triangles) {
        const auto p = triangle_corners(surface.vertices, triangle);
        const auto hit = meet(ray, p);
        if (hit && (!nearest || hit->distance < *nearest))
            nearest = hit->distance;
    }
    return nearest;
}

std::optional<double> thickness_near(const WallSurface& surface, const Touch& at, double radius_mm, double limit_mm)
{
    /// Start above the touched face, so that the ray does not meet this face.
    constexpr double kStartMm = 0.01;
    std::vector<Vec3> places;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_lip[t] != 0)
            continue;
        const auto p = triangle_corners(surface.rest, surface.triangles[t]);
        const Vec3 middle = (p[0] + p[1] + p[2]) / 3.0, area = area_vector(p);
        if ((middle - at.rest).norm() <= radius_mm && -area.dot(at.inward) > kSameSide * area.norm())
            places.push_back(middle);
    }
    const std::size_t stride = std::max<std::size_t>(1, places.size() / kThicknessSamples);
    std::optional<double> thickest = far_side(surface, { at.rest + kStartMm * at.inward, at.inward }, limit_mm);
    for (std::size_t i = 0; i < places.size(); i += stride) {
        // The far side of the body faces the same way as the wall's inner side, but is farther away than any wall near
        // here.
        const auto through = far_side(surface, { places[i] + kStartMm * at.inward, at.inward }, limit_mm);
        if (through && (!thickest || *through > *thickest))
            thickest = through;
    }
    return thickest;
}

std::vector<std::array<VertexId, 2>> wound_rims(const WallSurface& surface)
{
    std::map<std::array<VertexId, 2>, int> sides; // bit 0: a lip lies on the edge, bit 1: skin does
    const auto edge = [](VertexId a, VertexId b) { return std::array { std::min(a, b), std::max(a, b) }; };
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        if (surface.is_lip[t] != 0)
            for (std::size_t i = 0; i < 3; ++i)
                sides[edge(surface.triangles[t][i], surface.triangles[t][(i + 1) % 3])] = 1;
    if (sides.empty())
        return {};
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        if (surface.is_lip[t] == 0)
            for (std::size_t i = 0; i < 3; ++i)
                if (const auto found = sides.find(edge(surface.triangles[t][i], surface.triangles[t][(i + 1) % 3]));
                    found != sides.end())
                    found->second |= 2;
    std::vector<std::array<VertexId, 2>> rims;
    for (const auto& [key, side] : sides)
        if (side == 3)
            rims.push_back(key);
    return rims;
}

} // namespace retractor::planner
