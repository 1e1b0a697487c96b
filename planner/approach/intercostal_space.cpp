#include "planner/approach/intercostal_space.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/label_share.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/smooth_line.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kPlaceDeg = 1.5; ///< distance of places round the chest
    constexpr double kSmoothPlaces = 4.0; ///< 6 degrees: the spacing of the points of the ribs' centre-lines
    constexpr double kLeastOverlapDeg = 10.0;
    /// A narrower gap has no room for a blade between the ribs.
    constexpr double kLeastGapMm = 4.0;
    /// The wall between the ribs is 10 to 25 mm thick; nothing that lies deeper belongs to an intercostal space.
    constexpr double kThickestMm = 40.0;
    constexpr double kThickestRibMm = 20.0;
    /// Half the thickness of a rib whose label does not contain its own centre-line.
    constexpr double kHalfRibMm = 4.0;
    /// Half the distance of two neighbouring ribs' centre-lines.
    constexpr double kFarthestFromMiddleMm = 13.0;

    /// The bones and cartilages of the wall.
    mesh::LabelFlags hard_labels(const mesh::LabelTable& table)
    {
        return mesh::flagged_labels(
            table, [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); });
    }

    struct Gap {
        Vec3 from = Vec3::Zero(), to = Vec3::Zero(); ///< surfaces of the upper and of the lower rib
    };

    /// The longest stretch without bone and cartilage on the way from one rib to the other; where the two join, the
    /// point half way, twice. Surfaces are found between voxels, so that they move with the patient.
    Gap gap_between(const mesh::LabelVolume& labels, const mesh::LabelFlags& hard, const Vec3& above, const Vec3& below)
    {
        constexpr double kSurface = 0.5;
        const double step = 0.25 * labels.grid.spacing.minCoeff();
        const int count = std::max(2, static_cast<int>(std::ceil((below - above).norm() / step)));
        std::vector<double> share;
        for (int n = 0; n <= count; ++n)
            share.push_back(mesh::label_share(labels, hard, above + (below - above) * n / count));
        double start = share.front() < kSurface ? 0.0 : -1.0, best_start = 0.0, best_end = 0.0;
        const auto ends_at = [&](double end) {
            if (start >= 0.0 && end - start > best_end - best_start) {
                best_start = start;
                best_end = end;
            }
        };
        for (std::size_t n = 1; n < share.size(); ++n) {
            const bool was_hard = share[n - 1] >= kSurface, is_hard = share[n] >= kSurface;
            if (was_hard == is_hard)
                continue;
            const double surface = static_cast<double>(n - 1) + (kSurface - share[n - 1]) / (share[n] - share[n - 1]);
            if (is_hard)
                ends_at(surface);
            start = is_hard ? -1.0 : surface;
        }
        ends_at(count);
        if (best_end == best_start)
            best_start = best_end = 0.5 * count;
        return { above + (below - above) * best_start / count, above + (below - above) * best_end / count };
    }

    /// Distance from a rib's centre-line outwards to the rib's surface.
    double outer_side(
        const mesh::LabelVolume& labels, const mesh::LabelFlags& hard, const Vec3& centre, const Vec3& outward)
    {
        const double step = 0.25 * labels.grid.spacing.minCoeff();
        double last = -1.0;
        for (double t = 0.0; t <= kThickestRibMm; t += step) {
            if (hard[mesh::label_at(labels, centre + t * outward)] != 0)
                last = t;
            else if (last >= 0.0)
                break; // a shoulder blade farther outwards is no rib
        }
        return last >= 0.0 ? last : kHalfRibMm;
    }

    /// The two ribs at one angle.
    struct RibPair {
        Vec3 above, below; ///< on the centre-lines
    };

    std::vector<Vec3> outward_vectors(
        const std::vector<Vec3>& middle, const std::vector<Vec3>& across, const AnatomicalFrame& frame)
    {
        const std::vector<Vec3> along = tangents(middle);
        std::vector<Vec3> outward;
        for (std::size_t n = 0; n < middle.size(); ++n) {
            const Vec3 from_origin = middle[n] - frame.origin;
            const Vec3 from_axis = from_origin - frame.superior.dot(from_origin) * frame.superior;
            const Vec3 normal = along[n].cross(across[n]).normalized();
            outward.push_back(normal.dot(from_axis) > 0.0 ? normal : Vec3(-normal));
        }
        outward = smoothed(outward, kSmoothPlaces);
        for (Vec3& direction : outward)
            direction.normalize();
        return outward;
    }

    /// Sets the levels of the places, smoothed along the space, and closes places without a cavity behind the wall.
    void measure_levels(const BodyProbe& probe, const mesh::LabelFlags& hard, const std::vector<RibPair>& pairs,
        std::vector<SpacePlace>& places)
    {
        RETRACTOR_ASSERT(pairs.size() == places.size());
        std::vector<Vec3> levels; // inner, outer, gap
        double last_inner = 0.0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            SpacePlace& place = places[n];
            // From outside the ribs: on the inner side of a thin wall the search would begin behind the wall.
            const auto inner = probe.wall_thickness(
                place.middle + kThickestRibMm * place.outward, -place.outward, kThickestRibMm + kThickestMm);
            place.cavity = inner.has_value();
            place.open = place.cavity && place.gap_mm >= kLeastGapMm;
            last_inner = inner ? *inner - kThickestRibMm : last_inner;
            const auto level = [&](const Vec3& centre) {
                return place.outward.dot(centre - place.middle)
                    + outer_side(probe.labels(), hard, centre, place.outward);
            };
            const double outer = 0.5 * (level(pairs[n].above) + level(pairs[n].below));
            levels.emplace_back(last_inner, std::max(outer, 0.0), place.gap_mm);
        }
        levels = smoothed(levels, kSmoothPlaces);
        for (std::size_t n = 0; n < places.size(); ++n) {
            places[n].inner_mm = std::max(levels[n][0], 0.0);
            places[n].outer_mm = std::max(levels[n][1], 0.0);
            places[n].gap_mm = std::max(levels[n][2], 0.0);
        }
    }

    /// Smallest distance from the blade's ray at an incision point to a line.
    double ray_distance(const Approach& approach, std::size_t n, const std::vector<Vec3>& line)
    {
        constexpr double kStepMm = 2.0;
        double nearest = std::numeric_limits<double>::infinity();
        for (double t = 0.0; t <= approach.depth_mm; t += kStepMm)
            nearest = std::min(nearest, polyline_distance(line, approach.incision[n] + t * approach.directions[n]));
        return nearest;
    }

    /// The shorter of two ribs in words: "rib_right_8 ends after 60 mm, rib_right_7 after 180 mm".
    std::string shorter_rib(const RibLine& upper, const RibLine& lower)
    {
        const auto length = [](const RibLine& rib) {
            double sum = 0.0;
            for (std::size_t n = 1; n < rib.points.size(); ++n)
                sum += (rib.points[n] - rib.points[n - 1]).norm();
            return sum;
        };
        const bool lower_is_shorter = length(lower) < length(upper);
        const RibLine &shorter = lower_is_shorter ? lower : upper, &other = lower_is_shorter ? upper : lower;
        return shorter.name + " ends after " + in_words(length(shorter)) + " mm, " + other.name + " after "
            + in_words(length(other)) + " mm";
    }

    /// The angles that both ribs have; empty (first above second) when they do not overlap.
    std::pair<double, double> common_angles(const RibLine& upper, const RibLine& lower)
    {
        RETRACTOR_ASSERT(!upper.angle_deg.empty() && !lower.angle_deg.empty());
        return { std::max(upper.angle_deg.front(), lower.angle_deg.front()),
            std::min(upper.angle_deg.back(), lower.angle_deg.back()) };
    }

} // namespace

std::string ordinal(const std::string& number)
{
    if (number == "1")
        return "1st";
    if (number == "2")
        return "2nd";
    return number + (number == "3" ? "rd" : "th");
}

std::string space_name(bool left, int number)
{
    return std::string(left ? "left" : "right") + " intercostal space " + std::to_string(number);
}

double height_of_cut(double gap_mm)
{
    return std::min(0.5 * gap_mm, std::max(kAboveLowerRibMm, gap_mm - kMostBelowUpperRibMm));
}

IntercostalSpace find_intercostal_space(const BodyProbe& probe, const Anatomy& anatomy, bool left, int number)
{
    const RibLine& upper = find_rib(anatomy, left, number);
    const RibLine& lower = find_rib(anatomy, left, number + 1);
    const auto [from, to] = common_angles(upper, lower);
    if (!(to - from > kLeastOverlapDeg))
        throw InputError("the ribs beside the " + space_name(left, number)
                + " hardly overlap: " + shorter_rib(upper, lower) + "; check its label",
            lower.name);
    const int count = std::max(2, static_cast<int>(std::ceil((to - from) / kPlaceDeg - 0.0123)));
    const mesh::LabelFlags hard = hard_labels(probe.labels().table);
    IntercostalSpace space { .left = left, .number = number, .places = {} };
    space.places.resize(static_cast<std::size_t>(count) + 1);
    std::vector<RibPair> pairs;
    std::vector<Vec3> middle, cut, across;
    for (std::size_t n = 0; n < space.places.size(); ++n) {
        SpacePlace& place = space.places[n];
        place.angle_deg = from + (to - from) * static_cast<double>(n) / count;
        pairs.push_back({ point_at_angle(upper, place.angle_deg), point_at_angle(lower, place.angle_deg) });
        const Gap gap = gap_between(probe.labels(), hard, pairs.back().above, pairs.back().below);
        place.gap_mm = (gap.to - gap.from).norm();
        middle.push_back(0.5 * (gap.from + gap.to));
        const double above_lower = height_of_cut(place.gap_mm);
        cut.push_back(place.gap_mm > 0.0 ? Vec3(gap.to + above_lower / place.gap_mm * (gap.from - gap.to)) : gap.to);
        across.push_back((pairs.back().above - pairs.back().below).normalized());
    }
    middle = smoothed(middle, kSmoothPlaces);
    cut = smoothed(cut, kSmoothPlaces);
    across = smoothed(across, kSmoothPlaces);
    const std::vector<Vec3> outward = outward_vectors(middle, across, anatomy.frame);
    for (std::size_t n = 0; n < space.places.size(); ++n) {
        space.places[n].middle = middle[n];
        space.places[n].cut = cut[n];
        space.places[n].outward = outward[n];
        if (n > 0)
            space.places[n].along_mm = space.places[n - 1].along_mm + (middle[n] - middle[n - 1]).norm();
    }
    measure_levels(probe, hard, pairs, space.places);
    return space;
}

std::optional<SpaceNumber> space_at(const Anatomy& anatomy, const Vec3& place)
{
    constexpr double kBeyondEndDeg = 10.0; // a rib's label may end where the next rib and their muscle go on
    const bool left = anatomy.frame.left.dot(place - anatomy.frame.origin) > 0.0;
    const double angle = angle_round_chest(anatomy.frame, left, place);
    std::optional<int> above; // the lowest rib above the place
    bool rib_below = false;
    for (const RibLine& rib : anatomy.ribs) {
        if (rib.left != left || angle < rib.angle_deg.front() - kBeyondEndDeg
            || angle > rib.angle_deg.back() + kBeyondEndDeg)
            continue;
        if (anatomy.frame.superior.dot(point_at_angle(rib, angle) - place) >= 0.0)
            above = std::max(above.value_or(0), rib.number);
        else
            rib_below = true;
    }
    return above && rib_below ? std::optional(SpaceNumber { left, *above }) : std::nullopt;
}

std::optional<SpaceNumber> space_under_incision(const Anatomy& anatomy, const Approach& approach)
{
    RETRACTOR_ASSERT(!approach.incision.empty() && approach.directions.size() == approach.incision.size());
    std::optional<SpaceNumber> nearest;
    double least = kFarthestFromMiddleMm;
    for (const RibLine& upper : anatomy.ribs)
        for (const RibLine& lower : anatomy.ribs) {
            if (lower.left != upper.left || lower.number != upper.number + 1)
                continue;
            const auto [from, to] = common_angles(upper, lower);
            if (!(to - from > kLeastOverlapDeg))
                continue;
            std::vector<Vec3> line;
            for (double angle = from; angle <= to; angle += kPlaceDeg)
                line.push_back(0.5 * (point_at_angle(upper, angle) + point_at_angle(lower, angle)));
            double mean = 0.0;
            for (std::size_t n = 0; n < approach.incision.size(); ++n)
                mean += ray_distance(approach, n, line) / static_cast<double>(approach.incision.size());
            if (mean < least) {
                least = mean;
                nearest = { upper.left, upper.number };
            }
        }
    return nearest;
}

SpacePlace place_along(const IntercostalSpace& space, double along_mm)
{
    const std::vector<SpacePlace>& places = space.places;
    RETRACTOR_ASSERT(places.size() >= 2);
    std::size_t n = 0;
    while (n + 2 < places.size() && places[n + 1].along_mm < along_mm)
        ++n;
    const SpacePlace &a = places[n], &b = places[n + 1];
    const double t = std::clamp((along_mm - a.along_mm) / (b.along_mm - a.along_mm), 0.0, 1.0);
    const auto between = [&](double first, double second) { return (1.0 - t) * first + t * second; };
    return { .angle_deg = between(a.angle_deg, b.angle_deg),
        .middle = (1.0 - t) * a.middle + t * b.middle,
        .cut = (1.0 - t) * a.cut + t * b.cut,
        .outward = ((1.0 - t) * a.outward + t * b.outward).normalized(),
        .gap_mm = between(a.gap_mm, b.gap_mm),
        .inner_mm = between(a.inner_mm, b.inner_mm),
        .outer_mm = between(a.outer_mm, b.outer_mm),
        .open = a.open && b.open,
        .cavity = a.cavity && b.cavity,
        .along_mm = between(a.along_mm, b.along_mm) };
}

} // namespace retractor::planner
