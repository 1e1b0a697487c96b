#include "planner/approach/space_division.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/assumed_vessels.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/intercostal_space.h"
#include "planner/case/division.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kSearchStepMm = 1.0; ///< step in which the division's end is looked for
    constexpr double kPointSpacingMm = 6.0; ///< between points of a stroke's line
    /// The stroke begins at the incision's end and comes to the lower rib's upper edge within this distance.
    constexpr double kBlendMm = 20.0;
    /// Distance of the blade's line from the inner side of the wall. The line must lie in the chest.
    constexpr double kInsideMm = 4.0;
    /// Distance of the blade's end beyond the ribs' outer side where the intercostal muscle has a label of its own, so
    /// that none of its voxels stays undivided.
    constexpr double kBeyondRibsMm = 2.0;
    /// A shorter stroke is no division: the incision reaches the end of the space already.
    constexpr double kShortestMm = 5.0;
    constexpr double kSpineBinMm = 5.0;
    constexpr int kSpineBins = 3; ///< bins above and below a place in which the spine's midline is averaged

    constexpr double kVesselStepMm = 1.0; ///< between places along an assumed mammary artery

    bool names_mammary(const mesh::LabelInfo& info) { return is_mammary(info.name); }

    /// Centres of the voxels of some labels.
    std::vector<Vec3> voxel_centres(const mesh::LabelVolume& labels, const mesh::LabelFlags& counts)
    {
        std::vector<Vec3> centres;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            if (counts[label] != 0)
                centres.push_back(labels.grid.world(Vec3(i, j, k)));
        });
        return centres;
    }

    const char* closed_words(const SpacePlace& place)
    {
        return place.cavity ? "the ribs join" : "no cavity lies behind the wall";
    }

    /// The structures that end the division.
    class Limits {
    public:
        Limits(const mesh::LabelVolume& labels, const AnatomicalFrame& frame, std::span<const AssumedVessel> assumed)
            : frame_(frame)
            , half_voxel_mm_(0.5 * labels.grid.spacing.maxCoeff())
            , sternum_(voxel_centres(labels,
                  mesh::flagged_labels(
                      labels.table, [](const mesh::LabelInfo& info) { return info.name == "sternum"; })))
            , mammary_(voxel_centres(labels, mesh::flagged_labels(labels.table, names_mammary)))
        {
            for (const AssumedVessel& vessel : assumed)
                if (is_mammary(vessel.name))
                    assumed_mammary_.emplace_back(places_along(vessel, kVesselStepMm), vessel.radius_mm);
            for (const mesh::LabelInfo& info : labels.table)
                if (info.role == mesh::Role::at_risk && !names_mammary(info))
                    at_risk_.emplace_back(info.name,
                        voxel_centres(labels, mesh::flagged_labels(labels.table, [&](const mesh::LabelInfo& other) {
                            return other.id == info.id;
                        })));
            const auto is_spine = [](const mesh::LabelInfo& info) {
                return info.name == "spine" || info.name.starts_with("vertebrae");
            };
            for (const Vec3& p : voxel_centres(labels, mesh::flagged_labels(labels.table, is_spine))) {
                auto& [sum, count] = spine_[bin(p)];
                sum += frame_.left.dot(p - frame_.origin);
                count += 1.0;
            }
        }

        /// The reason why the division must not go as far forwards as this place; empty when it may.
        std::string forward_limit(const SpacePlace& place) const
        {
            if (!place.open)
                return closed_words(place);
            if (nearest(place, mammary_) < kFromMammaryMm)
                return formatted("%.0f mm from the mammary artery", kFromMammaryMm);
            for (const auto& [places, radius_mm] : assumed_mammary_)
                if (nearest_centre(place, places) - radius_mm < kFromMammaryMm)
                    return formatted("%.0f mm from where the mammary artery is assumed", kFromMammaryMm);
            if (nearest(place, sternum_) < kFromSternumMm)
                return formatted("%.0f mm from the sternum", kFromSternumMm);
            return risk_behind(place);
        }
        /// The same for the way backwards.
        std::string backward_limit(const SpacePlace& place) const
        {
            if (!place.open)
                return closed_words(place);
            const double lateral = std::abs(frame_.left.dot(place.cut - frame_.origin) - midline(place.cut));
            if (lateral < kFromSpineMm)
                return formatted("%.0f mm from the spine's midline", kFromSpineMm);
            return risk_behind(place);
        }

    private:
        /// The structure at risk that lies so close behind the wall that the stroke, which begins inside the chest,
        /// would go through it; empty: none.
        std::string risk_behind(const SpacePlace& place) const
        {
            for (const auto& [name, voxels] : at_risk_)
                if (nearest(place, voxels) < kInsideMm + 1.0)
                    return "the " + readable(name) + " lies behind the wall";
            return {};
        }
        int bin(const Vec3& p) const
        {
            return static_cast<int>(std::floor(frame_.superior.dot(p - frame_.origin) / kSpineBinMm));
        }
        /// Smallest distance of the cut between the inner and the outer side of the wall from the voxels' surfaces.
        double nearest(const SpacePlace& place, const std::vector<Vec3>& voxels) const
        {
            return nearest_centre(place, voxels) - half_voxel_mm_;
        }
        static double nearest_centre(const SpacePlace& place, const std::vector<Vec3>& points)
        {
            const Vec3 inner = place.cut - place.inner_mm * place.outward;
            const double depth = place.inner_mm + place.outer_mm;
            double least = std::numeric_limits<double>::infinity();
            for (const Vec3& p : points) {
                const double t = std::clamp(place.outward.dot(p - inner), 0.0, depth);
                least = std::min(least, (p - inner - t * place.outward).squaredNorm());
            }
            return std::sqrt(least);
        }
        /// Lateral place of the spine's midline at the height of a point; the middle of the chest where no spine is
        /// labelled at this height.
        double midline(const Vec3& p) const
        {
            double sum = 0.0, count = 0.0;
            for (int b = bin(p) - kSpineBins; b <= bin(p) + kSpineBins; ++b)
                if (const auto found = spine_.find(b); found != spine_.end()) {
                    sum += found->second.first;
                    count += found->second.second;
                }
            return count > 0.0 ? sum / count : 0.0;
        }

        AnatomicalFrame frame_;
        double half_voxel_mm_;
        std::vector<Vec3> sternum_, mammary_;
        std::vector<std::pair<std::vector<Vec3>, double>> assumed_mammary_; ///< places along each, and its radius
        std::vector<std::pair<std::string, std::vector<Vec3>>> at_risk_; ///< names and voxels
        std::map<int, std::pair<double, double>> spine_; ///< per bin of height: sum of lateral places, and count
    };

    /// An end of the incision beside the space.
    struct IncisionEnd {
        double along_mm = 0.0; ///< place along the space
        Vec3 offset = Vec3::Zero(); ///< from the space's line of cutting to the blade's ray
        Vec3 outward = Vec3::Zero(); ///< against the blade's direction, unit
    };

    IncisionEnd incision_end(const IntercostalSpace& space, const Vec3& skin, const Vec3& inward, double depth)
    {
        IncisionEnd end { .outward = -inward.normalized() };
        double least = std::numeric_limits<double>::infinity();
        const double last = space.places.back().along_mm;
        for (double along = 0.0; along <= last; along += kSearchStepMm) {
            const Vec3 cut = place_along(space, along).cut;
            const double t = std::clamp((cut - skin).dot(-end.outward), 0.0, depth);
            const Vec3 offset = skin - t * end.outward - cut;
            if (offset.norm() < least) {
                least = offset.norm();
                end.along_mm = along;
                end.offset = offset;
            }
        }
        return end;
    }

    /// The place of the division at a distance beyond the incision's end. The division begins on the blade's ray.
    SpacePlace place_beyond(const IntercostalSpace& space, const IncisionEnd& end, double beyond, bool forwards)
    {
        SpacePlace place = place_along(space, end.along_mm + (forwards ? beyond : -beyond));
        const double share = std::clamp(1.0 - beyond / kBlendMm, 0.0, 1.0);
        place.cut += share * end.offset;
        place.outward = ((1.0 - share) * place.outward + share * end.outward).normalized();
        return place;
    }

    /// Where the division ends, and the reason in words.
    struct DivisionEnd {
        double length_mm = 0.0;
        std::string reason;
    };

    DivisionEnd find_end(const IntercostalSpace& space, const IncisionEnd& end, const Limits& limits, bool forwards,
        const std::optional<double>& asked)
    {
        const double room = forwards ? space.places.back().along_mm - end.along_mm : end.along_mm;
        DivisionEnd found { .reason = "the end of the ribs" };
        for (double beyond = 0.0; beyond <= room; beyond += kSearchStepMm) {
            if (asked && beyond > *asked)
                return { *asked, "as given" };
            const SpacePlace place = place_beyond(space, end, beyond, forwards);
            const std::string limit = forwards ? limits.forward_limit(place) : limits.backward_limit(place);
            if (!limit.empty()) {
                found.reason = limit;
                break;
            }
            found.length_mm = beyond;
        }
        if (asked)
            found.reason += formatted(" (%.0f mm were given)", *asked);
        return found;
    }

    DivisionStroke make_stroke(
        const IntercostalSpace& space, const IncisionEnd& end, double length, bool forwards, double beyond_ribs)
    {
        RETRACTOR_ASSERT(length > 0.0);
        const int count = std::max(1, static_cast<int>(std::ceil(length / kPointSpacingMm - 0.0123)));
        std::vector<SpacePlace> places;
        DivisionStroke stroke { .way = forwards ? StrokeWay::forwards : StrokeWay::backwards };
        for (int n = 0; n <= count; ++n) {
            places.push_back(place_beyond(space, end, length * n / count, forwards));
            if (n > 0)
                stroke.length_mm
                    += (places[static_cast<std::size_t>(n)].cut - places[static_cast<std::size_t>(n) - 1].cut).norm();
            stroke.depth_mm
                = std::max(stroke.depth_mm, places.back().inner_mm + places.back().outer_mm + beyond_ribs + kInsideMm);
        }
        for (const SpacePlace& place : places) { // the blade ends at the ribs' outer side everywhere
            stroke.line.push_back(place.cut + (place.outer_mm + beyond_ribs - stroke.depth_mm) * place.outward);
            stroke.directions.push_back(place.outward);
        }
        return stroke;
    }

    std::string way_words(const DivisionEnd& end, bool forwards)
    {
        const std::string way = forwards ? "forwards" : "backwards";
        if (end.length_mm < kShortestMm)
            return "not " + way + " (" + end.reason + ")";
        return formatted("%.0f mm %s (%s)", end.length_mm, way.c_str(), end.reason.c_str());
    }

    void divide_along(Approach& approach, const mesh::LabelVolume& labels, const Anatomy& anatomy,
        std::span<const AssumedVessel> assumed)
    {
        Division& division = approach.division;
        const auto number = space_under_incision(anatomy, approach);
        if (!number) {
            division.words = "the incision follows no intercostal space: nothing is divided beyond the skin";
            return;
        }
        const BodyProbe probe(labels);
        const IntercostalSpace space = find_intercostal_space(probe, anatomy, number->left, number->number);
        const DividedLabels divided = divided_labels(labels.table);
        const double beyond_ribs = divided.has_own ? kBeyondRibsMm : 0.0;
        IncisionEnd back
            = incision_end(space, approach.incision.front(), approach.directions.front(), approach.depth_mm);
        IncisionEnd front
            = incision_end(space, approach.incision.back(), approach.directions.back(), approach.depth_mm);
        if (front.along_mm < back.along_mm)
            std::swap(front, back);
        const Limits limits(labels, anatomy.frame, assumed);
        const DivisionEnd backwards = find_end(space, back, limits, false, division.backwards_mm),
                          forwards = find_end(space, front, limits, true, division.forwards_mm);
        if (backwards.length_mm >= kShortestMm)
            division.strokes.push_back(make_stroke(space, back, backwards.length_mm, false, beyond_ribs));
        if (forwards.length_mm >= kShortestMm)
            division.strokes.push_back(make_stroke(space, front, forwards.length_mm, true, beyond_ribs));
        for (DivisionStroke& stroke : division.strokes)
            stroke.severs = divided.names;
        division.words = "in the " + space_name(space.left, space.number)
            + " intercostal muscle and pleura are divided beyond the skin " + way_words(backwards, false) + " and "
            + way_words(forwards, true);
        if (!divided.has_own)
            division.words
                += "; the labels do not tell intercostal muscle apart, so the wall is divided from its inner "
                   "side to the ribs' outer side";
    }

} // namespace

void find_space_division(
    Approach& approach, const mesh::LabelVolume& labels, const Anatomy& anatomy, std::span<const AssumedVessel> assumed)
{
    approach.division.strokes.clear();
    approach.division.words.clear();
    if (approach.division.extent != DivisionExtent::full)
        return;
    try {
        divide_along(approach, labels, anatomy, assumed);
    } catch (const InputError& error) {
        approach.division.words
            = std::string("the intercostal space was not found, and nothing is divided beyond the skin: ")
            + error.what();
    }
}

} // namespace retractor::planner
