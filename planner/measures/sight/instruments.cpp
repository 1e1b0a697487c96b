#include "planner/measures/sight/instruments.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::planner {

namespace {

    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr unsigned kEverything = kTargetMask | kOrganMask | kWallMask;

    /// A straight round rod: an instrument's shaft or a finger.
    struct Rod {
        double diameter_mm = 0.0;
        double length_mm = 0.0;
    };

    /// Whether a rod fits with its tip at a place: its axis outwards, and its surface beyond the tip, which tapers.
    bool fits(
        const RayScene& scene, const OpeningGeometry& opening, const Rod& rod, const Vec3& place, const Vec3& outward)
    {
        constexpr double kTipMm = 10.0;
        constexpr int kRays = 6; // on the rod's surface
        if (!scene.clear(place, outward, kTouchingMm, rod.length_mm, kEverything))
            return false;
        const Vec3 u = across_of(outward, opening), v = outward.cross(u);
        for (int i = 0; i < kRays; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / kRays;
            const Vec3 from = place + 0.5 * rod.diameter_mm * (std::cos(angle) * u + std::sin(angle) * v);
            if (!scene.clear(from, outward, kTipMm, rod.length_mm, kEverything))
                return false;
        }
        return true;
    }

    constexpr Rod kShaft { .diameter_mm = kShaftMm, .length_mm = kShaftLengthMm };

    /// Places in the opening through which rods are tried.
    std::vector<Vec3> gates_of(const OpeningGeometry& opening)
    {
        constexpr int kAlong = 17, kAcross = 7;
        const Vec3 across = opening.normal.cross(opening.along);
        std::vector<Vec3> gates;
        for (int i = 0; i < kAlong; ++i)
            for (int j = 0; j < kAcross; ++j)
                gates.push_back(opening.centre + opening.length_mm * ((i + 0.5) / kAlong - 0.5) * opening.along
                    + opening.width_mm * ((j + 0.5) / kAcross - 0.5) * across);
        return gates;
    }

    bool two_shafts_reach(
        const RayScene& scene, const OpeningGeometry& opening, const std::vector<Vec3>& gates, const Vec3& place)
    {
        const double apart = std::cos(kShaftsApartDeg * kDegree);
        std::vector<Vec3> shafts;
        for (const Vec3& gate : gates) {
            const Vec3 outward = (gate - place).normalized();
            if (!fits(scene, opening, kShaft, place, outward))
                continue;
            if (std::any_of(
                    shafts.begin(), shafts.end(), [&](const Vec3& other) { return other.dot(outward) < apart; }))
                return true;
            shafts.push_back(outward);
        }
        return false;
    }

    /// Beyond the skin the finger goes on into the hand.
    constexpr double kHandMm = 30.0;

    /// The shortest finger that touches a place, from the skin; infinite where none fits.
    /// @param longest_mm longer ones are not tried
    double finger_needed(const RayScene& scene, const OpeningGeometry& opening, const std::vector<Vec3>& gates,
        const Vec3& place, double longest_mm)
    {
        double needed = std::numeric_limits<double>::infinity();
        for (const Vec3& gate : gates) {
            const double length = (gate - place).norm();
            if (length < std::min(needed, longest_mm)
                && fits(scene, opening, { .diameter_mm = kFingerMm, .length_mm = length + kHandMm }, place,
                    (gate - place) / length))
                needed = length;
        }
        return needed;
    }

    /// Whether the straight line from a place passes the opening's ellipse in the skin plane.
    bool passes(const OpeningGeometry& opening, const Vec3& place, const Vec3& outward)
    {
        const double rise = outward.dot(opening.normal);
        if (!(rise > 0.0))
            return false;
        const Vec3 at = place + (opening.centre - place).dot(opening.normal) / rise * outward - opening.centre;
        const Vec3 across = opening.normal.cross(opening.along);
        return std::hypot(at.dot(opening.along) / (0.5 * opening.length_mm), at.dot(across) / (0.5 * opening.width_mm))
            <= 1.0;
    }

} // namespace

Vec3 across_of(const Vec3& line, const OpeningGeometry& opening)
{
    const Vec3 across = line.cross(opening.along), other = line.cross(opening.normal);
    return (across.squaredNorm() > other.squaredNorm() ? across : other).normalized();
}

std::vector<std::size_t> reached_by_two(const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const std::vector<std::size_t>& places, const Job& job)
{
    const std::vector<Vec3> gates = gates_of(opening);
    std::vector<std::size_t> reached;
    for (std::size_t i = 0; i < places.size() && !job.cancelled(); ++i) {
        if (two_shafts_reach(scene, opening, gates, samples[places[i]].position))
            reached.push_back(places[i]);
        job.report("instruments", static_cast<double>(i + 1) / static_cast<double>(places.size()));
    }
    return reached;
}

FingerReach finger_reach(
    const RayScene& scene, const OpeningGeometry& opening, const std::vector<SurfaceSample>& samples, const Job& job)
{
    constexpr std::size_t kFarSamples = 200; // for the length that a finger lacks
    const std::vector<Vec3> gates = gates_of(opening);
    FingerReach reach;
    for (std::size_t s = 0; s < samples.size() && !job.cancelled(); ++s)
        if (finger_needed(scene, opening, gates, samples[s].position, kFingerReachMm) <= kFingerReachMm)
            reach.touched.push_back(s);
    if (!reach.touched.empty())
        return reach;
    double needed = kShaftLengthMm;
    for (std::size_t s = 0; s < samples.size() && !job.cancelled(); s += 1 + samples.size() / kFarSamples)
        needed = std::min(needed, finger_needed(scene, opening, gates, samples[s].position, needed));
    if (needed < kShaftLengthMm)
        reach.lacks_mm = needed - kFingerReachMm;
    return reach;
}

double surgical_freedom_mm2(const RayScene& scene, const OpeningGeometry& opening, const Vec3& place)
{
    constexpr int kDirections = 4000;
    constexpr double kWidestDeg = 85.0, kMarginDeg = 2.0;
    const Vec3 axis = (opening.centre - place).normalized();
    double widest = 0.0;
    const Vec3 across = opening.normal.cross(opening.along);
    for (const double a : { -0.5, 0.5 })
        for (const double b : { -0.5, 0.5 }) {
            const Vec3 corner
                = opening.centre + a * opening.length_mm * opening.along + b * opening.width_mm * across - place;
            widest = std::max(widest, std::acos(std::clamp(corner.normalized().dot(axis), -1.0, 1.0)));
        }
    const double half_angle = std::min(widest + kMarginDeg * kDegree, kWidestDeg * kDegree);
    const Vec3 u = across_of(axis, opening), v = axis.cross(u);
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0)); // of a sunflower's seeds
    int free = 0;
    for (int n = 0; n < kDirections; ++n) {
        const double cosine = 1.0 - (n + 0.5) / kDirections * (1.0 - std::cos(half_angle));
        const double sine = std::sqrt(1.0 - cosine * cosine), turn = golden * n;
        const Vec3 outward = cosine * axis + sine * (std::cos(turn) * u + std::sin(turn) * v);
        free += passes(opening, place, outward) && fits(scene, opening, kShaft, place, outward) ? 1 : 0;
    }
    const double cap_sr = 2.0 * std::numbers::pi * (1.0 - std::cos(half_angle));
    return cap_sr * free / kDirections * kShaftLengthMm * kShaftLengthMm;
}

} // namespace retractor::planner
