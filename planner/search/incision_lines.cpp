#include "planner/search/incision_lines.h"

#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace retractor::planner {

namespace {

    constexpr double kSectionMm = 8.0; ///< distance of the sections of an incision
    /// Beside the long muscles of the back, as the templates between ribs.
    constexpr double kFromDeg = 35.0;
    constexpr double kThickCover = 2.0; ///< multiple of the median; more lies over the space than a chest wall
    constexpr double kSteepest = 1.5; ///< mm of skin's rise per mm along the space; steeper is the fold to an arm

    /// Whether bone or cartilage lies on the way out from the ribs to the skin.
    bool is_covered(
        const mesh::LabelVolume& labels, const mesh::LabelFlags& hard, const SpacePlace& place, double skin_mm)
    {
        const double step = 0.5 * labels.grid.spacing.minCoeff();
        for (double at = 0.0; at < skin_mm; at += step)
            if (hard[mesh::label_at(labels, place.cut + at * place.outward)] != 0)
                return true;
        return false;
    }

    /// Marks where no incision can lie, by what covers the space.
    void mark_free(std::vector<LinePlace>& places, const std::vector<double>& covers)
    {
        const double thickest = kThickCover * upper_median(std::vector<double>(covers));
        for (std::size_t n = 0; n < places.size(); ++n) {
            places[n].free = places[n].free && places[n].angle_deg >= kFromDeg && covers[n] <= thickest;
            if (n > 0
                && std::abs(covers[n] - covers[n - 1])
                    > kSteepest * (places[n].wall.inner - places[n - 1].wall.inner).norm())
                places[n].free = places[n - 1].free = false;
        }
    }

    ApertureSection section_at(const IncisionLine& line, double along_mm)
    {
        const auto after = std::find_if(line.places.begin() + 1, line.places.end() - 1,
            [&](const LinePlace& place) { return place.along_mm >= along_mm; });
        const LinePlace &a = *(after - 1), &b = *after;
        const double t = std::clamp((along_mm - a.along_mm) / (b.along_mm - a.along_mm), 0.0, 1.0);
        return { .skin = (1.0 - t) * a.wall.skin + t * b.wall.skin,
            .inner = (1.0 - t) * a.wall.inner + t * b.wall.inner };
    }

} // namespace

IncisionLine line_over_space(const BodyProbe& probe, const Anatomy& anatomy, bool left, int number)
{
    const IntercostalSpace space = find_intercostal_space(probe, anatomy, left, number);
    const mesh::LabelFlags hard = mesh::flagged_labels(probe.labels().table,
        [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); });
    IncisionLine line { .space = SpaceNumber { left, number }, .places = {} };
    std::vector<double> covers;
    for (const SpacePlace& at : space.places) {
        const auto skin = probe.first_skin_along(at.cut, at.outward);
        if (!skin)
            throw InputError("no skin outside the " + space_name(left, number) + " near " + in_words(at.cut));
        LinePlace place;
        place.wall = { .skin = at.cut + *skin * at.outward, .inner = at.cut - at.inner_mm * at.outward };
        place.angle_deg = at.angle_deg;
        place.free = at.open && at.cavity && !is_covered(probe.labels(), hard, at, *skin);
        if (!line.places.empty())
            place.along_mm = line.places.back().along_mm + (place.wall.skin - line.places.back().wall.skin).norm();
        line.places.push_back(place);
        covers.push_back(*skin);
    }
    mark_free(line.places, covers);
    return line;
}

std::optional<IncisionLine> line_on_skin(
    const BodyProbe& probe, const Vec3& middle, const Vec3& inward, const Vec3& along, double length_mm)
{
    constexpr double kReachMm = 40.0; // from a flat line to the skin of a round body
    const int steps = std::max(2, static_cast<int>(std::ceil(length_mm / kSectionMm)));
    IncisionLine line;
    for (int n = 0; n <= steps; ++n) {
        const Vec3 outside = middle + length_mm * (static_cast<double>(n) / steps - 0.5) * along - kReachMm * inward;
        const std::optional<Vec3> skin = probe.skin_seen(outside, inward);
        if (!skin || (*skin - outside).norm() > 2.0 * kReachMm)
            return std::nullopt;
        const auto wall = probe.wall_thickness(*skin, inward);
        if (!wall)
            return std::nullopt;
        LinePlace place;
        place.wall = { .skin = *skin, .inner = *skin + *wall * inward };
        if (n > 0)
            place.along_mm = line.places.back().along_mm + (*skin - line.places.back().wall.skin).norm();
        line.places.push_back(place);
    }
    return line;
}

std::optional<std::vector<ApertureSection>> sections_between(const IncisionLine& line, double from_mm, double to_mm)
{
    constexpr double kRoundOffMm = 1e-6;
    if (from_mm < line.places.front().along_mm - kRoundOffMm || to_mm > line.places.back().along_mm + kRoundOffMm)
        return std::nullopt;
    for (std::size_t n = 0; n + 1 < line.places.size(); ++n) // every stretch that the incision touches
        if (line.places[n + 1].along_mm > from_mm && line.places[n].along_mm < to_mm
            && !(line.places[n].free && line.places[n + 1].free))
            return std::nullopt;
    const int steps = std::max(2, static_cast<int>(std::ceil((to_mm - from_mm) / kSectionMm)));
    std::vector<ApertureSection> sections;
    for (int n = 0; n <= steps; ++n)
        sections.push_back(section_at(line, from_mm + (to_mm - from_mm) * n / steps));
    return sections;
}

} // namespace retractor::planner
