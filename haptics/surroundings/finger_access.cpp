#include "haptics/surroundings/finger_access.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr double kEveryMm = 4.0; ///< along the rod: between two questions a point comes 0.26 mm nearer at most

} // namespace

FingerAccess::FingerAccess(
    std::shared_ptr<const DistanceGrid> around, const Opening& opening, const StraightRod& finger)
    : around_(std::move(around))
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
    const double thick = 0.5 * finger_.thickness_mm;
    for (double s = kEveryMm; s <= length_mm; s += kEveryMm) {
        const Vec3 at = tip + s * outward;
        const double share = finger_.taper_mm > 0.0 ? std::min(s / finger_.taper_mm, 1.0) : 1.0;
        const double radius = std::min(tip_radius_mm, thick) + share * (thick - std::min(tip_radius_mm, thick));
        if (around_->distance(at) < std::min(radius, around_->farthest_mm()))
            return Hindrance { s, at };
    }
    return std::nullopt;
}

FingerAccess::Answer FingerAccess::at(const Vec3& tip, double tip_radius_mm, std::size_t gate) const noexcept
{
    if (!around_->contains(tip))
        return { .fits = true, .gate = gate };
    if (around_->distance(tip) < std::min(tip_radius_mm, around_->farthest_mm()))
        return { .hindrance = around_->nearest(tip), .away = around_->away(tip) };
    const double above = (tip - opening_.centre).dot(opening_.normal);
    if (above >= 0.0) {
        const auto stopped = hindrance(tip, tip_radius_mm, opening_.normal, finger_.outside_mm);
        if (!stopped)
            return { .fits = true, .outward = opening_.normal };
        return { .hindrance = around_->nearest(stopped->at), .away = around_->away(stopped->at) };
    }
    std::optional<Hindrance> farthest; // of the way that is free longest
    std::size_t of_farthest = 0;
    bool is_near = false;
    gate = std::min(gate, gates_.size() - 1);
    for (std::size_t n = 0; n <= gates_.size(); ++n) {
        const std::size_t g = n == 0 ? gate : n - 1; // the last way first
        if (n > 0 && g == gate)
            continue;
        const Vec3 way = gates_[g] - tip;
        const double length = way.norm();
        if (!(length > 0.0) || length > finger_.reach_mm)
            continue;
        is_near = true;
        const Vec3 outward = way / length;
        const auto stopped = hindrance(tip, tip_radius_mm, outward, length + finger_.outside_mm);
        if (!stopped)
            return { .fits = true, .outward = outward, .gate = g };
        if (!farthest || stopped->from_tip_mm > farthest->from_tip_mm) {
            farthest = stopped;
            of_farthest = g;
        }
    }
    if (!is_near)
        return { .hindrance = kTooFar, .away = (opening_.centre - tip).normalized(), .gate = gate };
    return { .hindrance = around_->nearest(farthest->at), .away = around_->away(farthest->at), .gate = of_farthest };
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
            const Answer tried = at(tip, tip_radius_mm, best.answer.gate);
            (tried.fits ? low : high) = middle;
            if (tried.fits)
                best = { tip, tried };
            else
                refused = tried;
        }
        return best;
    };
    Place reached = as_far_as_free({ allowed, at(allowed, tip_radius_mm, gate) }, wanted);
    const int hindrance = refused.hindrance;
    // Along what hinders: without the part of the way that goes on into it.
    const Vec3 rest = wanted - reached.tip;
    const Vec3 along = rest - std::min(rest.dot(refused.away), 0.0) * refused.away;
    if (along.squaredNorm() > 0.0) {
        const Vec3 to = reached.tip + along;
        const Answer tried = at(to, tip_radius_mm, reached.answer.gate);
        reached = tried.fits ? Place { to, tried } : as_far_as_free(reached, to);
    }
    reached.answer.hindrance = hindrance;
    return reached;
}

std::shared_ptr<const DistanceGrid> make_surroundings(const std::vector<mesh::NamedSurface>& around,
    const Opening& opening, const Points& structure, double thickest_mm, const Job& job)
{
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
    if (structure.rows() > 0) {
        box.extend(structure.colwise().minCoeff().transpose() - margin);
        box.extend(structure.colwise().maxCoeff().transpose() + margin);
    }
    const double step = std::max(kStepMm, std::cbrt(box.volume() / kMostPoints));
    return std::make_shared<const DistanceGrid>(around, box, step, 0.5 * thickest_mm + 2.0 * step, job);
}

Vec3 FingerAccess::outside(double tip_radius_mm) const noexcept
{
    constexpr double kAboveMm = 20.0;
    return opening_.centre + (tip_radius_mm + kAboveMm) * opening_.normal;
}

} // namespace retractor::haptics
