#include "planner/measures/sight/live_view.h"

#include "planner/measures/sight/surgeon_eye.h"
#include "planner/plan/wound_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace retractor::planner {

namespace {

    /// Half as many as a plan takes: the numbers follow the hand.
    constexpr int kSamples = 1000;

    OpeningGeometry geometry_of(const Approach& approach)
    {
        const IncisionPlace place = incision_place(approach, 0.5 * incision_length(approach));
        OpeningGeometry geometry;
        geometry.centre = place.of(approach.incision);
        geometry.normal = -place.of(approach.directions).normalized();
        geometry.start = approach.incision.front();
        geometry.end = approach.incision.back();
        geometry.along = (geometry.end - geometry.start).normalized();
        geometry.length_mm = (geometry.end - geometry.start).norm();
        geometry.incision_length_mm = incision_length(approach);
        return geometry;
    }

} // namespace

LiveView::LiveView(Patient& patient, const Approach& approach)
    : target_(patient.target(approach.target))
    , organs_(organ_occluders(approach, patient))
    , opening_(geometry_of(approach))
    , view_(approach.view)
{
}

SeenNow LiveView::look(const TriMesh& wall, const TriMesh& around, const Job& job) const
{
    const Stopwatch watch;
    std::vector<Occluder> occluders = organs_;
    occluders.push_back({ .name = "wall", .surface = wall, .labels = {}, .material = {} });
    occluders.push_back({ .name = "around", .surface = around, .labels = {}, .material = {} });
    const RayScene scene(*target_, std::move(occluders), job);
    const std::vector<SurfaceSample> samples = surface_samples(scene.target(), kSamples);
    const SurgeonEye best
        = best_eye(scene, eye_places_through(opening_, aim_through(scene, opening_, samples), view_), samples, job);
    SeenNow seen { .status = best.status, .seen_fraction = best.seen_fraction, .eye = best.eye, .aim = best.aim };
    // Samples that make up the bound, of all samples.
    const double of_bound
        = std::max(1.0, kSamples * best.bound_area_mm2 / std::max(scene.target_area_mm2(), best.bound_area_mm2));
    const double share = std::clamp(best.seen_fraction, 0.0, 1.0);
    seen.sampling_error = std::sqrt(share * (1.0 - share) / of_bound);
    const double cosine = (best.eye - best.aim).normalized().dot(opening_.normal);
    seen.off_straight_deg = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
    seen.seconds = watch.seconds();
    return seen;
}

} // namespace retractor::planner
