#include "planner/measures/sight/ray_scene.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace retractor::planner {

namespace {

    /// Distance (mm) behind a hit at which a ray continues: larger than the round-off of single precision at 1 m,
    /// smaller than any tissue.
    constexpr double kStepPastHit = 1e-3;
    /// Winding number above which a point is inside. A closed surface winds once round a point inside; a flat plate
    /// never reaches a half.
    constexpr double kInsideWinding = 0.75;

    void check_surface(const TriMesh& mesh, const std::string& name)
    {
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            if (!mesh.vertices.row(v).allFinite())
                throw InputError(
                    "the surface '" + name + "' has a vertex that is not finite", "vertex " + std::to_string(v));
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const VertexId v : mesh.triangles[t])
                if (v < 0 || v >= mesh.vertices.rows())
                    throw InputError("the surface '" + name + "' uses vertex " + std::to_string(v) + " of "
                            + std::to_string(mesh.vertices.rows()),
                        "triangle " + std::to_string(t));
        if (!mesh.labels.empty() && mesh.labels.size() != mesh.triangles.size())
            throw InputError("the surface '" + name + "' has " + std::to_string(mesh.labels.size()) + " labels for "
                + std::to_string(mesh.triangles.size()) + " triangles");
    }

    double radical_step(std::uint64_t i, double generator)
    {
        const double x = 0.5 + generator * static_cast<double>(i);
        return x - std::floor(x);
    }

    /// Number of times that the surface winds round a point: the sum of the solid angles of its triangles, over 4 pi
    /// [van Oosterom and Strackee 1983].
    double winding_number(const TriMesh& mesh, const Vec3& point)
    {
        double sum = 0.0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            auto p = triangle_corners(mesh.vertices, mesh.triangles[t]);
            for (Vec3& q : p)
                q -= point;
            const double a = p[0].norm(), b = p[1].norm(), c = p[2].norm();
            const double y = p[0].dot(p[1].cross(p[2]));
            const double x = a * b * c + p[0].dot(p[1]) * c + p[1].dot(p[2]) * a + p[2].dot(p[0]) * b;
            sum += std::atan2(y, x);
        }
        return sum / (2.0 * std::numbers::pi);
    }

    /// A surface in the scene with the names of its triangles.
    struct Body {
        TriMesh surface;
        Eigen::AlignedBox3d box;
        std::string name;
        unsigned mask = 0;
        std::vector<int> tissue; ///< index into the scene's tissue names, per triangle
    };

} // namespace

std::vector<SurfaceSample> surface_samples(const TriMesh& surface, int count)
{
    if (count < 1)
        throw InputError("at least one sample is needed, not " + std::to_string(count));
    std::vector<double> cumulated;
    double area = 0.0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        cumulated.push_back(area += triangle_area(surface.vertices, surface.triangles[t]));
    RETRACTOR_ASSERT(area > 0.0);

    // Generators of the R2 sequence: powers of the inverse of the plastic number.
    constexpr double kPlastic = 1.32471795724474602596;
    std::vector<SurfaceSample> samples;
    std::size_t t = 0;
    for (int i = 0; i < count; ++i) {
        const double at = area * (i + 0.5) / count;
        while (t + 1 < cumulated.size() && cumulated[t] <= at)
            ++t;
        const auto n = static_cast<std::uint64_t>(i) + 1;
        double u = radical_step(n, 1.0 / kPlastic), v = radical_step(n, 1.0 / (kPlastic * kPlastic));
        // Reflect the second half of the unit square onto the triangle.
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        const auto p = triangle_corners(surface.vertices, surface.triangles[t]);
        samples.push_back({ p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]), static_cast<int>(t) });
    }
    return samples;
}

struct RayScene::Parts {
    std::vector<Body> bodies; ///< the target is first; indices are Embree's geometry ids
    std::vector<Tissue> tissues;
    double target_area_mm2 = 0.0;
    Vec3 centre = Vec3::Zero(); ///< origin of the single precision coordinates
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    Parts() = default;
    Parts(const Parts&) = delete;
    Parts& operator=(const Parts&) = delete;
    ~Parts()
    {
        if (scene != nullptr)
            rtcReleaseScene(scene);
        if (device != nullptr)
            rtcReleaseDevice(device);
    }

    int tissue(const std::string& name, const std::string& material)
    {
        for (std::size_t i = 0; i < tissues.size(); ++i)
            if (tissues[i].name == name && tissues[i].material == material)
                return static_cast<int>(i);
        tissues.push_back({ name, material });
        return static_cast<int>(tissues.size()) - 1;
    }

    void add(Occluder occluder, unsigned mask);
    std::size_t build();
    RTCRay ray(const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const;
};

void RayScene::Parts::add(Occluder occluder, unsigned mask)
{
    check_surface(occluder.surface, occluder.name);
    Body body { std::move(occluder.surface), {}, occluder.name, mask, {} };
    for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v)
        body.box.extend(Vec3(body.surface.vertices.row(v).transpose()));
    const int unnamed = tissue(occluder.name, occluder.material);
    std::map<Label, int> by_label;
    for (const mesh::LabelInfo& info : occluder.labels)
        by_label.emplace(info.id, tissue(info.name, info.material));
    body.tissue.assign(body.surface.triangles.size(), unnamed);
    for (std::size_t t = 0; t < body.surface.labels.size(); ++t)
        if (const auto found = by_label.find(body.surface.labels[t]); found != by_label.end())
            body.tissue[t] = found->second;
    bodies.push_back(std::move(body));
}

/// Passes the surfaces to Embree. @returns the approximate number of bytes that they take there
std::size_t RayScene::Parts::build()
{
    Eigen::AlignedBox3d box;
    for (const Body& body : bodies)
        box.extend(body.box);
    centre = box.center();
    device = rtcNewDevice(nullptr);
    if (device == nullptr)
        throw SolverError(
            "the ray tracer (Embree) cannot start", "error " + std::to_string(rtcGetDeviceError(nullptr)));
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) == 0)
        throw SolverError("this build of Embree has no ray masks");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    std::size_t bytes = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const TriMesh& mesh = bodies[b].surface;
        if (mesh.triangles.empty())
            continue;
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        const auto rows = static_cast<std::size_t>(mesh.vertices.rows());
        auto* points = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), rows));
        auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
        if (points == nullptr || indices == nullptr)
            throw SolverError("the ray tracer has no memory for '" + bodies[b].name + "'");
        for (std::size_t v = 0; v < rows; ++v)
            for (int axis = 0; axis < 3; ++axis)
                *points++ = static_cast<float>(mesh.vertices(static_cast<Eigen::Index>(v), axis) - centre[axis]);
        for (const auto& triangle : mesh.triangles)
            for (const VertexId v : triangle)
                *indices++ = static_cast<unsigned>(v);
        rtcSetGeometryMask(geometry, bodies[b].mask);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(b));
        rtcReleaseGeometry(geometry);
        bytes += rows * 3 * (sizeof(float) + sizeof(double))
            + mesh.triangles.size() * (6 * sizeof(unsigned) + sizeof(int));
    }
    rtcCommitScene(scene);
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
        throw SolverError("the ray tracer (Embree) failed to build its tree", "error " + std::to_string(error));
    return bytes;
}

RTCRay RayScene::Parts::ray(const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const
{
    const Eigen::Vector3f o = (from - centre).cast<float>(), d = direction.cast<float>();
    RTCRay ray {};
    ray.org_x = o.x();
    ray.org_y = o.y();
    ray.org_z = o.z();
    ray.dir_x = d.x();
    ray.dir_y = d.y();
    ray.dir_z = d.z();
    ray.tnear = static_cast<float>(near_mm);
    ray.tfar = static_cast<float>(far_mm);
    ray.mask = mask;
    return ray;
}

RayScene::RayScene(TriMesh target, std::vector<Occluder> occluders, const Job& job)
{
    const Stopwatch watch;
    const auto parts = std::make_shared<Parts>();
    parts_ = parts;
    check_surface(target, "target");
    for (const auto& triangle : target.triangles)
        parts->target_area_mm2 += triangle_area(target.vertices, triangle);
    if (!(parts->target_area_mm2 > 0.0))
        throw InputError("the target's surface is empty or has no area");
    target.labels.clear();
    parts->add({ .name = "target", .surface = std::move(target), .labels = {}, .material = {} }, kTargetMask);
    for (Occluder& occluder : occluders) {
        const unsigned mask = occluder.wall ? kWallMask : kOrganMask;
        parts->add(std::move(occluder), mask);
    }
    const std::size_t bytes = parts->build();
    record_part(job, "ray tracer", watch, bytes);
}

RayScene::RayScene(const RayScene& open, Aperture aperture, std::string_view wall)
    : parts_(open.parts_)
{
    const auto found = std::ranges::find_if(parts_->tissues, [&](const Tissue& tissue) { return tissue.name == wall; });
    if (found == parts_->tissues.end())
        throw InputError("the scene has no tissue \"" + std::string(wall) + "\"");
    wall_
        = Wall { .aperture = std::move(aperture), .tissue = static_cast<std::size_t>(found - parts_->tissues.begin()) };
}

RayScene::~RayScene() = default;

const TriMesh& RayScene::target() const { return parts_->bodies.front().surface; }

const std::vector<RayScene::Tissue>& RayScene::tissues() const { return parts_->tissues; }

double RayScene::target_area_mm2() const { return parts_->target_area_mm2; }

Vec3 RayScene::normal(const SurfaceSample& sample) const
{
    RETRACTOR_ASSERT(static_cast<std::size_t>(sample.triangle) < target().triangles.size());
    return unit_normal(target().vertices, target().triangles[static_cast<std::size_t>(sample.triangle)]);
}

bool RayScene::clear(const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const
{
    if (wall_ && (mask & kWallMask) != 0 && !wall_->aperture.passes(from, direction))
        return false;
    RTCRay ray = parts_->ray(from, direction, near_mm, far_mm, mask);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(parts_->scene, &context, &ray);
    return ray.tfar >= 0.0F; // Embree sets it to minus infinity at a hit
}

std::optional<RayHit> RayScene::first(
    const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const
{
    RTCRayHit query {};
    query.ray = parts_->ray(from, direction, near_mm, far_mm, mask);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(parts_->scene, &context, &query);
    const bool hits = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (wall_ && (mask & kWallMask) != 0 && !wall_->aperture.passes(from, direction))
        if (const double at = wall_->aperture.distance_to_skin(from, direction);
            at >= near_mm && at <= far_mm && !(hits && static_cast<double>(query.ray.tfar) < at))
            return RayHit { at, wall_->tissue };
    if (!hits)
        return std::nullopt;
    RETRACTOR_ASSERT(query.hit.geomID < parts_->bodies.size());
    const Body& body = parts_->bodies[query.hit.geomID];
    RETRACTOR_ASSERT(query.hit.primID < body.tissue.size());
    return RayHit { static_cast<double>(query.ray.tfar), static_cast<std::size_t>(body.tissue[query.hit.primID]) };
}

std::vector<std::size_t> RayScene::tissues_along(
    const Vec3& from, const Vec3& direction, double far_mm, unsigned mask) const
{
    std::vector<std::size_t> met;
    double near_mm = 0.0;
    while (const auto hit = first(from, direction, near_mm, far_mm, mask)) {
        if (std::find(met.begin(), met.end(), hit->tissue) == met.end())
            met.push_back(hit->tissue);
        near_mm = hit->distance_mm + kStepPastHit;
        if (near_mm >= far_mm)
            break;
    }
    return met;
}

std::string RayScene::enclosing(const Vec3& point) const
{
    for (const Body& body : parts_->bodies)
        if (body.box.contains(point) && winding_number(body.surface, point) > kInsideWinding)
            return body.name;
    return {};
}

} // namespace retractor::planner
