#include "planner/measures/sight/exposure.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kDegree = std::numbers::pi / 180.0;

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

} // namespace

std::vector<SightShare> sorted_shares(
    const std::vector<RayScene::Tissue>& tissues, const std::vector<std::size_t>& counts, std::size_t total)
{
    RETRACTOR_ASSERT(counts.size() == tissues.size());
    std::map<std::string, std::size_t> by_name;
    for (std::size_t i = 0; i < counts.size(); ++i)
        if (counts[i] > 0)
            by_name[tissues[i].name] += counts[i];
    std::vector<SightShare> shares;
    for (const auto& [name, count] : by_name)
        shares.push_back({ name, share(count, total) });
    std::stable_sort(
        shares.begin(), shares.end(), [](const SightShare& a, const SightShare& b) { return a.share > b.share; });
    return shares;
}

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

    /// Follows the lines of sight from one eye to all samples. Fills the view's share and adds to the tally.
    void look(const RayScene& scene, EyeView& view, const std::vector<SurfaceSample>& samples,
        const std::vector<bool>& is_bone, Tally& tally)
    {
        std::size_t seen = 0;
        for (std::size_t s = 0; s < samples.size(); ++s) {
            const Vec3 line = samples[s].position - view.eye;
            const double distance = line.norm(), far = distance - kTouchingMm;
            const Vec3 direction = line / distance;
            if (!scene.clear(view.eye, direction, 0.0, distance - kSampleToleranceMm, kTargetMask))
                continue; // the target hides the sample itself
            ++tally.facing;
            const auto hit = scene.first(view.eye, direction, 0.0, far, kOrganMask | kWallMask);
            if (hit)
                ++tally.blocked[hit->tissue];
            if (hit && !scene.clear(view.eye, direction, 0.0, far, kOrganMask))
                continue; // hidden even with the wall removed
            ++tally.seen_without_wall[s];
            if (hit) {
                for (const std::size_t tissue : scene.tissues_along(view.eye, direction, far, kWallMask))
                    if (is_bone[tissue])
                        ++tally.bone[tissue];
            } else {
                ++seen;
                ++tally.seen[s];
            }
        }
        view.visible_fraction = share(seen, samples.size());
    }

    /// Computes the numbers over all eyes from the single views and the tally.
    void summarise(Exposure& out, const Tally& tally, const std::vector<RayScene::Tissue>& tissues)
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

Exposure measure_exposure(const RayScene& scene, const ViewCone& cone, int samples, const Job& job)
{
    Exposure out;
    out.cone = cone;
    out.target_area_mm2 = scene.target_area_mm2();
    const std::vector<Vec3> eyes = eye_positions(cone);
    out.sample_points = surface_samples(scene.target(), samples);
    out.samples = out.sample_points.size();
    if (const std::string inside = scene.enclosing(eyes.front()); !inside.empty())
        throw InputError("the central eye is inside '" + inside + "': move it away from the aim");

    const std::vector<RayScene::Tissue>& tissues = scene.tissues();
    std::vector<bool> is_bone;
    for (const RayScene::Tissue& tissue : tissues)
        is_bone.push_back(tissue.material == "bone" || tissue.material == "cartilage");
    Tally tally { .blocked = std::vector<std::size_t>(tissues.size(), 0),
        .bone = std::vector<std::size_t>(tissues.size(), 0),
        .seen = std::vector<std::size_t>(out.samples, 0),
        .seen_without_wall = std::vector<std::size_t>(out.samples, 0) };
    for (const Vec3& eye : eyes) {
        if (job.cancelled()) {
            out.status = ExposureStatus::cancelled;
            return out;
        }
        out.eyes.push_back({ .eye = eye });
        look(scene, out.eyes.back(), out.sample_points, is_bone, tally);
        job.report("exposure", static_cast<double>(out.eyes.size()) / static_cast<double>(eyes.size()));
    }
    summarise(out, tally, tissues);
    return out;
}

Exposure measure_exposure(
    TriMesh target, std::vector<Occluder> occluders, const ViewCone& cone, int samples, const Job& job)
{
    return measure_exposure(RayScene(std::move(target), std::move(occluders), job), cone, samples, job);
}

} // namespace retractor::planner
