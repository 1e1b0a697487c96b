#include "haptics/surroundings/finger_access.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr double kTipMm = 10.0; ///< of the rod, which may lie on the touched structure, as in the measure
    constexpr double kEveryMm = 4.0; ///< along the rod: between two questions a point comes 0.26 mm nearer at most

} // namespace

FingerAccess::FingerAccess(Surroundings surroundings, const Opening& opening, const StraightRod& finger)
    : surroundings_(std::move(surroundings))
    , opening_(opening)
    , finger_(finger)
{
    if (!(opening.length_mm > 0.0) || !(opening.width_mm > 0.0) || !(finger.thickness_mm > 0.0)
        || !(finger.reach_mm > 0.0))
        throw InputError("an opening and a finger need an extent");
    constexpr int kAlong = 17, kAcross = 7; // as the measure "touched by a finger" tries them
    const Vec3 across = opening.normal.cross(opening.along);
    for (int i = 0; i < kAlong; ++i)
        for (int j = 0; j < kAcross; ++j)
            gates_.push_back(opening.centre + opening.length_mm * ((i + 0.5) / kAlong - 0.5) * opening.along
                + opening.width_mm * ((j + 0.5) / kAcross - 0.5) * across);
    std::ranges::stable_sort(gates_, {}, [&](const Vec3& gate) { return (gate - opening.centre).squaredNorm(); });
}

std::optional<FingerAccess::Hindrance> FingerAccess::hindrance(
    const Vec3& tip, double tip_radius_mm, const Vec3& outward, double length_mm) const noexcept
{
    const DistanceGrid& around = *surroundings_.around;
    const double thick = 0.5 * finger_.thickness_mm, thin = std::min(tip_radius_mm, thick);
    // As deep as the tip presses, the structure gives way to the rod beside it, too.
    const double pressed = surroundings_.structure != nullptr
        ? std::max(0.0, tip_radius_mm - surroundings_.structure->distance(tip))
        : 0.0;
    for (double s = kEveryMm; s <= length_mm; s += kEveryMm) {
        const Vec3 at = tip + s * outward;
        const double share = finger_.taper_mm > 0.0 ? std::min(s / finger_.taper_mm, 1.0) : 1.0;
        const double radius = thin + share * (thick - thin);
        if (around.distance(at) < std::min(radius, around.farthest_mm()))
            return Hindrance { s, at };
        if (s >= kTipMm && surroundings_.structure != nullptr
            && surroundings_.structure->distance(at)
                < std::min(thick - pressed, surroundings_.structure->farthest_mm()))
            return Hindrance { s, at, true };
    }
    return std::nullopt;
}

FingerAccess::Answer FingerAccess::refused(const Hindrance& hindrance, std::size_t gate) const noexcept
{
    const DistanceGrid& met = hindrance.is_structure ? *surroundings_.structure : *surroundings_.around;
    return { .hindrance = hindrance.is_structure ? kStructure : met.nearest(hindrance.at),
        .away = met.away(hindrance.at),
        .gate = gate };
}

FingerAccess::Answer FingerAccess::at(const Vec3& tip, double tip_radius_mm, std::size_t gate, Ways ways) const noexcept
{
    const DistanceGrid& around = *surroundings_.around;
    const double above = (tip - opening_.centre).dot(opening_.normal);
    gate = std::min(gate, gates_.size() - 1);
    const Answer too_far { .hindrance = kTooFar, .away = (opening_.centre - tip).normalized(), .gate = gate };
    if (!around.contains(tip)) {
        if (above < 0.0 && around.box().exteriorDistance(tip) < kAwayMm)
            return too_far;
        return { .fits = true, .gate = gate };
    }
    if (around.distance(tip) < std::min(tip_radius_mm, around.farthest_mm()))
        return { .hindrance = around.nearest(tip), .away = around.away(tip), .gate = gate };
    if (above >= 0.0) {
        const auto stopped = hindrance(tip, tip_radius_mm, opening_.normal, finger_.outside_mm);
        return stopped ? refused(*stopped, gate) : Answer { .fits = true, .outward = opening_.normal, .gate = gate };
    }
    constexpr std::size_t kFew = 12;
    const std::size_t most = ways == Ways::all ? gates_.size() : std::min(kFew, gates_.size());
    std::optional<Hindrance> farthest; // of the way that is free longest
    std::size_t of_farthest = gate;
    for (std::size_t n = 0; n <= most; ++n) {
        const std::size_t g = n == 0 ? gate : n - 1; // the last way first
        if (n > 0 && g == gate)
            continue;
        const Vec3 way = gates_[g] - tip;
        const double length = way.norm();
        if (!(length > 0.0) || length > finger_.reach_mm)
            continue;
        const Vec3 outward = way / length;
        const auto stopped = hindrance(tip, tip_radius_mm, outward, length + finger_.outside_mm);
        if (!stopped)
            return { .fits = true, .outward = outward, .gate = g };
        if (!farthest || stopped->from_tip_mm > farthest->from_tip_mm) {
            farthest = stopped;
            of_farthest = g;
        }
    }
    return farthest ? refused(*farthest, of_farthest) : too_far;
}

FingerAccess::Place FingerAccess::towards(
    const Vec3& allowed, const Vec3& wanted, double tip_radius_mm, std::size_t gate) const noexcept
{
    constexpr int kHalvings = 6;
    const Answer there = at(wanted, tip_radius_mm, gate);
    if (there.fits)
        return { wanted, there };
    Answer refused = there; // nearest beyond what is free
    const auto as_far_as_free = [&](const Place& from, const Vec3& to) {
        Place best = from;
        double low = 0.0, high = 1.0;
        for (int n = 0; n < kHalvings; ++n) {
            const double middle = 0.5 * (low + high);
            const Vec3 tip = from.tip + middle * (to - from.tip);
            const Answer tried = at(tip, tip_radius_mm, best.answer.gate, Ways::few);
            (tried.fits ? low : high) = middle;
            if (tried.fits)
                best = { tip, tried };
            else
                refused = tried;
        }
        return best;
    };
    Place begin { allowed, at(allowed, tip_radius_mm, gate) };
    if (!begin.answer.fits || !surroundings_.around->contains(allowed)) { // not allowed, or put away
        begin.tip = outside(tip_radius_mm);
        begin.answer = at(begin.tip, tip_radius_mm, gate);
    }
    Place reached = as_far_as_free(begin, wanted);
    const int hindrance = refused.hindrance;
    // Along what hinders: without the part of the way that goes on into it.
    const Vec3 rest = wanted - reached.tip;
    const Vec3 along = rest - std::min(rest.dot(refused.away), 0.0) * refused.away;
    if (along.squaredNorm() > 0.0) {
        const Vec3 to = reached.tip + along;
        const Answer tried = at(to, tip_radius_mm, reached.answer.gate, Ways::few);
        reached = tried.fits ? Place { to, tried } : as_far_as_free(reached, to);
    }
    reached.answer.hindrance = hindrance;
    return reached;
}

Surroundings make_surroundings(const std::vector<mesh::NamedSurface>& around, const Opening& opening,
    const TriMesh& structure, double thickest_mm, const Job& job)
{
    // The margin holds a fingertip on the structure; outside, the hand is out of everything.
    constexpr double kStepMm = 1.5, kMostPoints = 4e6, kMarginMm = 12.0, kOutsideMm = 60.0;
    const Vec3 across = opening.normal.cross(opening.along), margin = Vec3::Constant(kMarginMm);
    Eigen::AlignedBox3d box;
    for (const double along : { -0.5, 0.5 })
        for (const double aside : { -0.5, 0.5 })
            for (const double out : { 0.0, kOutsideMm }) {
                const Vec3 corner = opening.centre + along * opening.length_mm * opening.along
                    + aside * opening.width_mm * across + out * opening.normal;
                box.extend(corner - margin);
                box.extend(corner + margin);
            }
    if (structure.vertices.rows() > 0) {
        box.extend(structure.vertices.colwise().minCoeff().transpose() - margin);
        box.extend(structure.vertices.colwise().maxCoeff().transpose() + margin);
    }
    const double step = std::max(kStepMm, std::cbrt(box.volume() / kMostPoints)),
                 farthest = 0.5 * thickest_mm + 2.0 * step;
    return { .around = std::make_shared<const DistanceGrid>(around, box, step, farthest, job),
        .structure = std::make_shared<const DistanceGrid>(
            std::vector<mesh::NamedSurface> { { "structure", structure } }, box, step, farthest, job) };
}

Vec3 FingerAccess::outside(double tip_radius_mm) const noexcept
{
    constexpr double kAboveMm = 20.0, kStepMm = 10.0;
    constexpr int kMostSteps = 30; // then it is outside the grid, where nothing hinders
    Vec3 tip = opening_.centre + (tip_radius_mm + kAboveMm) * opening_.normal;
    for (int n = 0; n < kMostSteps && !at(tip, tip_radius_mm).fits; ++n)
        tip += kStepMm * opening_.normal;
    return tip;
}

} // namespace retractor::haptics
