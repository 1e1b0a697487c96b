#include "planner/measures/exposure.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

namespace retractor::planner {

namespace {

    constexpr unsigned kTargetMask = 1, kOrganMask = 2, kWallMask = 4;
    constexpr double kDegree = std::numbers::pi / 180.0;
    /// Distance (mm) behind a hit at which a ray continues: larger than the round-off of single precision at 1 m,
    /// smaller than any tissue.
    constexpr double kStepPastHit = 1e-3;
    /// The target does not hide a sample from a ray that comes this near to the sample. The distance is larger than the
    /// error of single precision (about 1e-4 mm at 1 m), and smaller than a surgeon could see.
    constexpr double kToleranceMm = 0.02;
    /// No other surface hides a sample from this near either. Surfaces of touching labels are smoothed separately and
    /// overlap by a part of a voxel, so an artery on the heart would dip under the surface of the heart.
    constexpr double kContactMm = 0.5;
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

    void check_cone(const ViewCone& cone)
    {
        if (!cone.aim.allFinite() || !cone.axis.allFinite() || !cone.up.allFinite())
            throw InputError("the view cone has a value that is not finite");
        if (!(cone.axis.norm() > 0.0))
            throw InputError("the view cone's axis has no length");
        if (!(cone.up.cross(cone.axis).norm() > 1e-6 * cone.up.norm() * cone.axis.norm()))
            throw InputError("the view cone's up vector must not lie along its axis");
        if (!(cone.eye_distance_mm > 0.0) || !std::isfinite(cone.eye_distance_mm))
            throw InputError("the eye distance must be above 0 mm, not " + std::to_string(cone.eye_distance_mm));
        if (!(cone.half_angle_deg >= 0.0 && cone.half_angle_deg < 90.0))
            throw InputError(
                "the cone's half angle must be 0 to 90 degrees, not " + std::to_string(cone.half_angle_deg));
        if (cone.eyes < 1)
            throw InputError("a view cone needs at least one eye, not " + std::to_string(cone.eyes));
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

    /// Name and material of the triangles of a body.
    struct TissueName {
        std::string name, material;
    };

    /// A surface in the scene with the names of its triangles.
    struct Body {
        TriMesh surface;
        Eigen::AlignedBox3d box;
        std::string name;
        unsigned mask = 0;
        std::vector<int> tissue; ///< index into the scene's tissue names, per triangle
    };

    /// Counts over all eyes while lines of sight are followed.
    struct Tally {
        std::size_t facing = 0;
        std::vector<std::size_t> blocked, bone; ///< per tissue name
        std::vector<std::size_t> seen, seen_without_wall; ///< number of eyes, per sample
    };

    double share(std::size_t part, std::size_t whole)
    {
        return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
    }

    std::vector<SightShare> sorted_shares(
        const std::vector<TissueName>& tissues, const std::vector<std::size_t>& counts, std::size_t total)
    {
        RETRACTOR_ASSERT(counts.size() == tissues.size());
        std::map<std::string, std::size_t> by_name;
        for (std::size_t i = 0; i < counts.size(); ++i)
            if (counts[i] > 0)
                by_name[tissues[i].name] += counts[i];
        std::vector<SightShare> shares;
        for (const auto& [name, count] : by_name)
            shares.push_back({ name, static_cast<double>(count) / static_cast<double>(total) });
        std::stable_sort(
            shares.begin(), shares.end(), [](const SightShare& a, const SightShare& b) { return a.share > b.share; });
        return shares;
    }

} // namespace

std::vector<Vec3> eye_positions(const ViewCone& cone)
{
    check_cone(cone);
    const Vec3 axis = cone.axis.normalized();
    const Vec3 right = cone.up.cross(axis).normalized();
    const Vec3 up = axis.cross(right);
    const double cap = 1.0 - std::cos(cone.half_angle_deg * kDegree); // area of the cap over 2 pi
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    std::vector<Vec3> eyes;
    for (int i = 0; i < cone.eyes; ++i) {
        // Equal steps in height have equal areas. The first cell is the cap round the axis, with the eye in its middle.
        const double drop = i == 0 ? 0.0 : cap * (i + 0.5) / cone.eyes;
        const double radius = std::sqrt(drop * (2.0 - drop)), turn = golden * i;
        eyes.push_back(cone.aim
            + cone.eye_distance_mm * ((1.0 - drop) * axis + radius * (std::cos(turn) * up + std::sin(turn) * right)));
    }
    return eyes;
}

namespace {

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

    /// Target and occluders in Embree, for lines of sight from any eye.
    struct RayScene {
        std::vector<Body> bodies; ///< the target is first; indices are Embree's geometry ids
        std::vector<TissueName> tissues;
        Vec3 centre = Vec3::Zero(); ///< origin of the single precision coordinates
        RTCDevice device = nullptr;
        RTCScene scene = nullptr;

        RayScene() = default;
        RayScene(const RayScene&) = delete;
        RayScene& operator=(const RayScene&) = delete;
        ~RayScene()
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
        /// Index of the tissue that was hit.
        std::size_t tissue_of(const RTCHit& hit) const
        {
            RETRACTOR_ASSERT(hit.geomID < bodies.size() && hit.primID < bodies[hit.geomID].tissue.size());
            return static_cast<std::size_t>(bodies[hit.geomID].tissue[hit.primID]);
        }

        RTCRay ray(const Vec3& from, const Vec3& direction, double near, double far, unsigned mask) const;
        bool clear(const Vec3& from, const Vec3& direction, double far, unsigned mask) const;
        std::optional<RTCRayHit> first(
            const Vec3& from, const Vec3& direction, double near, double far, unsigned mask) const;
        std::vector<std::size_t> tissues_along(
            const Vec3& from, const Vec3& direction, double far, unsigned mask) const;
        std::string enclosing(const Vec3& point) const;
        void look(EyeView& view, const std::vector<SurfaceSample>& samples, const std::vector<bool>& is_bone,
            Tally& tally) const;
    };

    void RayScene::add(Occluder occluder, unsigned mask)
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
    std::size_t RayScene::build()
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
            auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
                geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), rows));
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

    RTCRay RayScene::ray(const Vec3& from, const Vec3& direction, double near, double far, unsigned mask) const
    {
        const Eigen::Vector3f o = (from - centre).cast<float>(), d = direction.cast<float>();
        RTCRay ray {};
        ray.org_x = o.x();
        ray.org_y = o.y();
        ray.org_z = o.z();
        ray.dir_x = d.x();
        ray.dir_y = d.y();
        ray.dir_z = d.z();
        ray.tnear = static_cast<float>(near);
        ray.tfar = static_cast<float>(far);
        ray.mask = mask;
        return ray;
    }

    bool RayScene::clear(const Vec3& from, const Vec3& direction, double far, unsigned mask) const
    {
        RTCRay r = ray(from, direction, 0.0, far, mask);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene, &context, &r);
        return r.tfar >= 0.0F; // Embree sets it to minus infinity at a hit
    }

    std::optional<RTCRayHit> RayScene::first(
        const Vec3& from, const Vec3& direction, double near, double far, unsigned mask) const
    {
        RTCRayHit query {};
        query.ray = ray(from, direction, near, far, mask);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return std::nullopt;
        return query;
    }

    /// All tissues along a line of sight, each once.
    std::vector<std::size_t> RayScene::tissues_along(
        const Vec3& from, const Vec3& direction, double far, unsigned mask) const
    {
        std::vector<std::size_t> met;
        double near = 0.0;
        while (const auto query = first(from, direction, near, far, mask)) {
            const std::size_t tissue = tissue_of(query->hit);
            if (std::find(met.begin(), met.end(), tissue) == met.end())
                met.push_back(tissue);
            near = static_cast<double>(query->ray.tfar) + kStepPastHit;
            if (near >= far)
                break;
        }
        return met;
    }

    /// Follows the lines of sight from one eye to all samples. Fills the view's shares and adds to the tally.
    void RayScene::look(
        EyeView& view, const std::vector<SurfaceSample>& samples, const std::vector<bool>& is_bone, Tally& tally) const
    {
        const TriMesh& target = bodies.front().surface;
        std::size_t seen = 0;
        double picture = 0.0, picture_without_wall = 0.0; // solid angle per area of sample
        for (std::size_t s = 0; s < samples.size(); ++s) {
            const Vec3 line = samples[s].position - view.eye;
            const double distance = line.norm(), far = distance - kContactMm;
            const Vec3 direction = line / distance;
            if (!clear(view.eye, direction, distance - kToleranceMm, kTargetMask))
                continue; // the target hides the sample itself
            ++tally.facing;
            const auto hit = first(view.eye, direction, 0.0, far, kOrganMask | kWallMask);
            if (hit)
                ++tally.blocked[tissue_of(hit->hit)];
            if (hit && !clear(view.eye, direction, far, kOrganMask))
                continue; // hidden even with the wall removed
            const Vec3 normal
                = unit_normal(target.vertices, target.triangles[static_cast<std::size_t>(samples[s].triangle)]);
            const double solid_angle = std::abs(normal.dot(direction)) / (distance * distance);
            ++tally.seen_without_wall[s];
            picture_without_wall += solid_angle;
            if (hit) {
                for (const std::size_t tissue : tissues_along(view.eye, direction, far, kWallMask))
                    if (is_bone[tissue])
                        ++tally.bone[tissue];
            } else {
                ++seen;
                ++tally.seen[s];
                picture += solid_angle;
            }
        }
        view.visible_fraction = share(seen, samples.size());
        view.picture_share = picture_without_wall > 0.0 ? picture / picture_without_wall : 0.0;
    }

    std::string RayScene::enclosing(const Vec3& point) const
    {
        for (const Body& body : bodies)
            if (body.box.contains(point) && winding_number(body.surface, point) > kInsideWinding)
                return body.name;
        return {};
    }

    /// Computes the numbers over all eyes from the single views and the tally.
    void summarise(Exposure& out, const Tally& tally, const std::vector<TissueName>& tissues)
    {
        const auto count_seen = [](const std::vector<std::size_t>& by) {
            return static_cast<std::size_t>(std::count_if(by.begin(), by.end(), [](std::size_t n) { return n > 0; }));
        };
        out.visible_fraction = share(count_seen(tally.seen), out.samples);
        out.visible_fraction_unobstructed = share(count_seen(tally.seen_without_wall), out.samples);
        for (const EyeView& view : out.eyes)
            out.mean_visible_fraction += view.visible_fraction / static_cast<double>(out.eyes.size());
        out.central_eye_fraction = out.eyes.front().visible_fraction;
        for (const std::size_t n : tally.seen)
            out.sample_seen.push_back(static_cast<float>(share(n, out.eyes.size())));
        out.blocked_by = sorted_shares(tissues, tally.blocked, tally.facing);
        out.bone_in_sight = sorted_shares(tissues, tally.bone, tally.facing);
    }

} // namespace

Exposure measure_exposure(
    TriMesh target, std::vector<Occluder> occluders, const ViewCone& cone, int samples, const Job& job)
{
    const Stopwatch watch;
    check_surface(target, "target");
    Exposure out;
    out.cone = cone;
    for (std::size_t t = 0; t < target.triangles.size(); ++t)
        out.target_area_mm2 += triangle_area(target.vertices, target.triangles[t]);
    if (!(out.target_area_mm2 > 0.0))
        throw InputError("the target's surface is empty or has no area");
    const std::vector<Vec3> eyes = eye_positions(cone);
    out.sample_points = surface_samples(target, samples);
    out.samples = out.sample_points.size();

    RayScene scene;
    target.labels.clear();
    scene.add({ .name = "target", .surface = std::move(target), .labels = {}, .material = {} }, kTargetMask);
    for (Occluder& occluder : occluders) {
        const unsigned mask = occluder.wall ? kWallMask : kOrganMask;
        scene.add(std::move(occluder), mask);
    }
    const std::size_t bytes = scene.build();
    record_part(job, "ray tracer", watch, bytes);
    if (const std::string inside = scene.enclosing(eyes.front()); !inside.empty())
        throw InputError("the central eye is inside '" + inside + "': move it away from the aim");

    std::vector<bool> is_bone;
    for (const TissueName& tissue : scene.tissues)
        is_bone.push_back(tissue.material == "bone" || tissue.material == "cartilage");
    Tally tally { .blocked = std::vector<std::size_t>(scene.tissues.size(), 0),
        .bone = std::vector<std::size_t>(scene.tissues.size(), 0),
        .seen = std::vector<std::size_t>(out.samples, 0),
        .seen_without_wall = std::vector<std::size_t>(out.samples, 0) };
    for (const Vec3& eye : eyes) {
        if (job.cancelled()) {
            out.status = ExposureStatus::cancelled;
            return out;
        }
        out.eyes.push_back({ .eye = eye });
        scene.look(out.eyes.back(), out.sample_points, is_bone, tally);
        job.report("exposure", static_cast<double>(out.eyes.size()) / static_cast<double>(eyes.size()));
    }
    summarise(out, tally, scene.tissues);
    return out;
}

} // namespace retractor::planner
