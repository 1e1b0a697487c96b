#include "planner/measures/sight/surgeon_eye.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/measures/sight/instruments.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr unsigned kEverything = kTargetMask | kOrganMask | kWallMask;

    /// A place of the eye, relative to the aim.
    struct Place {
        Vec3 direction = Vec3::UnitZ(); ///< unit
        double distance_mm = 0.0;
    };

    /// The samples that a place sees at less than the largest incidence.
    struct Sight {
        std::size_t seen = 0; ///< past everything
        std::size_t bound = 0; ///< with the wall removed
        std::vector<std::size_t> samples; ///< that are seen
    };

    double cosine_of_incidence(const RayScene& scene, const SurfaceSample& sample, const Vec3& direction)
    {
        return std::abs(scene.normal(sample).dot(direction));
    }

    bool sees(const RayScene& scene, const Vec3& eye, const Vec3& place, unsigned mask)
    {
        const Vec3 line = place - eye;
        const double distance = line.norm();
        const Vec3 direction = line / distance;
        return ((mask & kTargetMask) == 0
                   || scene.clear(eye, direction, 0.0, distance - kSampleToleranceMm, kTargetMask))
            && ((mask & ~kTargetMask) == 0
                || scene.clear(eye, direction, 0.0, distance - kTouchingMm, mask & ~kTargetMask));
    }

    Sight sight_from(const RayScene& scene, const Vec3& eye, const std::vector<SurfaceSample>& samples)
    {
        const double least_cosine = std::cos(kLargestIncidenceDeg * kDegree);
        Sight sight;
        for (std::size_t s = 0; s < samples.size(); ++s) {
            const Vec3& at = samples[s].position;
            if (cosine_of_incidence(scene, samples[s], (at - eye).normalized()) < least_cosine
                || !sees(scene, eye, at, kTargetMask | kOrganMask))
                continue;
            ++sight.bound;
            if (sees(scene, eye, at, kWallMask)) {
                ++sight.seen;
                sight.samples.push_back(s);
            }
        }
        return sight;
    }

    /// The search for the best place.
    struct Search {
        const RayScene& scene;
        const EyePlaces& places;
        const std::vector<SurfaceSample>& samples;
        const Job& job;
        Vec3 axis = Vec3::UnitZ(); ///< of the cone, unit
        std::size_t bound = 0; ///< largest of all places so far
        Place best {};
        std::size_t seen = 0; ///< from the best place

        Vec3 eye(const Place& place) const { return places.cone.aim + place.distance_mm * place.direction; }

        bool is_allowed(const Place& place) const
        {
            constexpr double kRoundOff = 1e-9;
            return axis.dot(place.direction) >= std::cos(places.cone.half_angle_deg * kDegree) - kRoundOff
                && place.distance_mm >= places.nearest_mm - kRoundOff
                && place.distance_mm <= places.farthest_mm + kRoundOff;
        }

        bool is_high_enough(const Place& place) const
        {
            return !places.up || places.up->dot(place.direction) >= std::sin(kLowestSightDeg * kDegree);
        }

        /// Takes a place that sees more than the best one so far. @returns whether it did
        bool try_place(const Place& place)
        {
            const Sight sight = sight_from(scene, eye(place), samples);
            const bool more = sight.seen > seen && is_high_enough(place);
            if ((more || sight.bound > bound) && !scene.enclosing(eye(place)).empty())
                return false;
            bound = std::max(bound, sight.bound);
            if (more) {
                seen = sight.seen;
                best = place;
            }
            return more;
        }
    };

    /// All directions of the cone at three distances. @returns false when the job was cancelled
    bool search_grid(Search& search)
    {
        const EyePlaces& places = search.places;
        const std::vector<Vec3> eyes = eye_positions(places.cone);
        const double middle = 0.5 * (places.nearest_mm + places.farthest_mm);
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            const Vec3 direction = (eyes[i] - places.cone.aim).normalized();
            for (const double distance : { middle, places.nearest_mm, places.farthest_mm }) {
                if (search.job.cancelled())
                    return false;
                search.try_place({ direction, distance });
                if (places.nearest_mm == places.farthest_mm)
                    break;
            }
            search.job.report("best eye", static_cast<double>(i + 1) / static_cast<double>(eyes.size()));
        }
        return true;
    }

    /// Steps to better neighbours of the best place; the steps are halved until they are small.
    void refine(Search& search)
    {
        constexpr int kHalvings = 4, kStepsEach = 6;
        const ViewCone& cone = search.places.cone;
        double turn = 2.0 * cone.half_angle_deg * kDegree / std::sqrt(static_cast<double>(cone.eyes));
        double shift = 0.25 * (search.places.farthest_mm - search.places.nearest_mm);
        for (int halving = 0; halving < kHalvings; ++halving, turn *= 0.5, shift *= 0.5) {
            bool moved = true;
            for (int step = 0; moved && step < kStepsEach; ++step) {
                moved = false;
                const Place from = search.best;
                const Vec3 right = cone.up.cross(from.direction).normalized(), up = from.direction.cross(right);
                std::vector<Place> neighbours;
                for (const double sign : { 1.0, -1.0 }) {
                    for (const Vec3& about : { right, up })
                        neighbours.push_back(
                            { Eigen::AngleAxisd(sign * turn, about) * from.direction, from.distance_mm });
                    neighbours.push_back({ from.direction, from.distance_mm + sign * shift });
                }
                for (const Place& place : neighbours)
                    if (search.is_allowed(place) && search.try_place(place))
                        moved = true;
            }
        }
    }

    /// The sample nearest to the middle of the seen samples, so that the eye looks at the target and not beside a bent
    /// vessel.
    Vec3 middle_of(const std::vector<SurfaceSample>& samples, const std::vector<std::size_t>& seen)
    {
        RETRACTOR_ASSERT(!seen.empty());
        Vec3 middle = Vec3::Zero();
        for (const std::size_t s : seen)
            middle += samples[s].position / static_cast<double>(seen.size());
        const auto nearer = [&](std::size_t a, std::size_t b) {
            return (samples[a].position - middle).squaredNorm() < (samples[b].position - middle).squaredNorm();
        };
        return samples[*std::min_element(seen.begin(), seen.end(), nearer)].position;
    }

    /// What hides the target from this eye, the share of its picture, and the mean incidence of what is seen.
    void describe(
        SurgeonEye& best, const RayScene& scene, const std::vector<SurfaceSample>& samples, const Sight& sight)
    {
        constexpr double kLeastOffAxis = 0.1; // no flat picture holds what lies more than 84 degrees off its axis
        const double least_cosine = std::cos(kLargestIncidenceDeg * kDegree);
        std::vector<std::size_t> hidden(scene.tissues().size(), 0);
        std::size_t facing = 0;
        double picture = 0.0, alone = 0.0; // area in a flat picture per area of sample
        const Vec3 axis = (best.aim - best.eye).normalized();
        for (const SurfaceSample& sample : samples) {
            const Vec3 line = sample.position - best.eye;
            const double distance = line.norm();
            const Vec3 direction = line / distance;
            if (!sees(scene, best.eye, sample.position, kTargetMask))
                continue;
            const double cosine = cosine_of_incidence(scene, sample, direction);
            const auto hit = scene.first(best.eye, direction, 0.0, distance - kTouchingMm, kOrganMask | kWallMask);
            const double off_axis = std::max(direction.dot(axis), kLeastOffAxis);
            const double area = cosine / (distance * distance * off_axis * off_axis * off_axis);
            alone += area;
            picture += hit ? 0.0 : area;
            if (cosine < least_cosine)
                continue;
            ++facing;
            if (hit)
                ++hidden[hit->tissue];
        }
        best.picture_share = alone > 0.0 ? picture / alone : 0.0;
        best.hidden_by = sorted_shares(scene.tissues(), hidden, facing);
        for (const std::size_t s : sight.samples)
            best.incidence_deg
                += std::acos(std::min(
                       1.0, cosine_of_incidence(scene, samples[s], (samples[s].position - best.eye).normalized())))
                / kDegree / static_cast<double>(sight.samples.size());
    }

    void check_places(const EyePlaces& places)
    {
        if (!(places.nearest_mm > 0.0 && places.nearest_mm <= places.farthest_mm && std::isfinite(places.farthest_mm)))
            throw InputError("the eye's distances must be positive and in order, not "
                + std::to_string(places.nearest_mm) + " to " + std::to_string(places.farthest_mm) + " mm");
        constexpr double kRoundOff = 1e-6;
        if (places.up && !(std::abs(places.up->norm() - 1.0) < kRoundOff))
            throw InputError("the direction away from the floor must have the length 1");
    }

} // namespace

Vec3 aim_through(const RayScene& scene, const OpeningGeometry& opening, const std::vector<SurfaceSample>& samples)
{
    for (const unsigned mask : { kTargetMask | kOrganMask, static_cast<unsigned>(kTargetMask), 0U }) {
        std::vector<std::size_t> seen;
        for (std::size_t s = 0; s < samples.size(); ++s)
            if (sees(scene, opening.centre, samples[s].position, mask))
                seen.push_back(s);
        if (!seen.empty())
            return middle_of(samples, seen);
    }
    throw InputError("the target has no samples");
}

SurgeonEye best_eye(
    const RayScene& scene, const EyePlaces& places, const std::vector<SurfaceSample>& samples, const Job& job)
{
    check_places(places);
    SurgeonEye best;
    Search search { .scene = scene, .places = places, .samples = samples, .job = job };
    search.axis = places.cone.axis.normalized();
    search.best = { search.axis, 0.5 * (places.nearest_mm + places.farthest_mm) };
    if (!search_grid(search)) {
        best.status = ExposureStatus::cancelled;
        return best;
    }
    if (search.seen > 0)
        refine(search);
    best.eye = search.eye(search.best);
    best.aim = places.cone.aim;
    const auto all = static_cast<double>(samples.size());
    best.bound_area_mm2 = scene.target_area_mm2() * static_cast<double>(search.bound) / all;
    const Sight sight = sight_from(scene, best.eye, samples);
    if (search.seen > 0) {
        best.seen_fraction = static_cast<double>(search.seen) / static_cast<double>(search.bound);
        best.aim = middle_of(samples, sight.samples);
    }
    describe(best, scene, samples, sight);
    return best;
}

namespace {

    /// The number of samples that two eyes see round a place, by the best of several turns of the head.
    std::size_t seen_by_two_eyes(const RayScene& scene, const SurgeonEye& best, const OpeningGeometry& opening,
        const std::vector<SurfaceSample>& samples, const std::vector<std::size_t>& seen)
    {
        constexpr int kTurns = 4;
        const Vec3 sight = (best.aim - best.eye).normalized();
        const Vec3 across = across_of(sight, opening);
        std::size_t most = 0;
        for (int turn = 0; turn < kTurns; ++turn) {
            const Vec3 side = Eigen::AngleAxisd(std::numbers::pi * turn / kTurns, sight) * across;
            const Vec3 left = best.eye + 0.5 * kEyesApartMm * side, right = best.eye - 0.5 * kEyesApartMm * side;
            const auto both = std::count_if(seen.begin(), seen.end(), [&](std::size_t s) {
                return sees(scene, left, samples[s].position, kEverything)
                    && sees(scene, right, samples[s].position, kEverything);
            });
            most = std::max(most, static_cast<std::size_t>(both));
        }
        return most;
    }

} // namespace

void add_two_eyes_and_instruments(SurgeonEye& best, const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const Job& job)
{
    const Sight sight = sight_from(scene, best.eye, samples);
    if (sight.seen == 0)
        return;
    const double bound = best.bound_area_mm2 / scene.target_area_mm2() * static_cast<double>(samples.size());
    best.two_eyes_fraction
        = static_cast<double>(seen_by_two_eyes(scene, best, opening, samples, sight.samples)) / bound;
    const std::vector<std::size_t> reached = reached_by_two(scene, opening, samples, sight.samples, job);
    if (job.cancelled()) {
        best.status = ExposureStatus::cancelled;
        return;
    }
    best.two_instruments_fraction = static_cast<double>(reached.size()) / bound;
    best.two_instruments_reach.assign(reached.begin(), reached.end());
}

void add_reach(SurgeonEye& best, const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const Job& job)
{
    const FingerReach finger = finger_reach(scene, opening, samples, job);
    best.finger_lacks_mm = finger.lacks_mm;
    best.finger_touches.assign(finger.touched.begin(), finger.touched.end());
    if (best.bound_area_mm2 > 0.0)
        best.finger_fraction = std::min(1.0,
            static_cast<double>(finger.touched.size()) / static_cast<double>(samples.size()) * scene.target_area_mm2()
                / best.bound_area_mm2);
    best.freedom_mm2 = surgical_freedom_mm2(scene, opening, best.aim);
    if (job.cancelled())
        best.status = ExposureStatus::cancelled;
}

} // namespace retractor::planner
