#include "ui/plan_scene/search_map.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "ui/scene/color_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr std::size_t kClasses = 5;
    constexpr Color kNotTried { 0.62, 0.58, 0.55 };
    constexpr Color kNearRisk { 0.75, 0.25, 0.20 };
    constexpr Color kShowsLittle { 0.36, 0.34, 0.33 };
    constexpr Label kNoScore = kClasses, kRefused = kClasses + 1, kTooLittle = kClasses + 2;
    constexpr double kReachMm = 12.0; ///< a place colours the skin round it

    Color class_color(std::size_t n) { return scale_color(static_cast<double>(n) / (kClasses - 1)); }

    struct Range {
        double low = 0.0, high = 100.0;
        std::size_t bin(double points) const
        {
            const double share = std::clamp((points - low) / (high - low), 0.0, 0.999);
            return static_cast<std::size_t>(share * kClasses);
        }
    };

    /// Whether an incision there could be proposed, so that its score means something.
    bool is_scored(const planner::TriedPlace& place) { return !place.near_risk && !place.shows_little; }

    /// The scores that were reached, rounded outwards to five points.
    Range range_of(const std::vector<planner::TriedPlace>& tried)
    {
        constexpr double kStep = 5.0;
        double low = 100.0, high = 0.0;
        for (const planner::TriedPlace& place : tried) {
            if (!is_scored(place))
                continue;
            low = std::min(low, place.points_of_100);
            high = std::max(high, place.points_of_100);
        }
        Range range { .low = kStep * std::floor(std::min(low, high) / kStep), .high = kStep * std::ceil(high / kStep) };
        range.high = std::max(range.high, range.low + kStep);
        return range;
    }

    /// The places that were tried. A sternotomy that can be proposed colours its whole length: it has no other place.
    std::vector<planner::TriedPlace> places_of(const planner::IncisionSearch& search)
    {
        std::vector<planner::TriedPlace> places = search.tried;
        for (const planner::FoundIncision& found : search.found)
            if (found.kind == planner::FoundIncision::Kind::sternum)
                for (const Vec3& point : found.points)
                    places.push_back({ .middle = point, .points_of_100 = found.points_of_100 });
        return places;
    }

    /// The best score near every triangle, as labels.
    std::shared_ptr<const TriMesh> scored_skin(
        const TriMesh& body, const std::vector<planner::TriedPlace>& tried, const Range& range)
    {
        using Cell = std::tuple<int, int, int>;
        const auto cell_of = [](const Vec3& at) {
            return Cell { static_cast<int>(std::floor(at.x() / kReachMm)),
                static_cast<int>(std::floor(at.y() / kReachMm)), static_cast<int>(std::floor(at.z() / kReachMm)) };
        };
        std::map<Cell, std::vector<const planner::TriedPlace*>> cells;
        for (const planner::TriedPlace& place : tried)
            cells[cell_of(place.middle)].push_back(&place);
        auto skin = std::make_shared<TriMesh>(body);
        skin->labels.assign(skin->triangles.size(), kNoScore);
        for (std::size_t t = 0; t < skin->triangles.size(); ++t) {
            const auto corners = triangle_corners(skin->vertices, skin->triangles[t]);
            const Vec3 at = (corners[0] + corners[1] + corners[2]) / 3.0;
            const auto [i, j, k] = cell_of(at);
            double best = -1.0;
            bool refused = false, too_little = false;
            for (int n = 0; n < 27; ++n)
                if (const auto found = cells.find({ i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1 });
                    found != cells.end())
                    for (const planner::TriedPlace* place : found->second)
                        if ((place->middle - at).norm() < kReachMm) {
                            refused = refused || place->near_risk;
                            too_little = too_little || (place->shows_little && !place->near_risk);
                            best = is_scored(*place) ? std::max(best, place->points_of_100) : best;
                        }
            if (best >= 0.0)
                skin->labels[t] = static_cast<Label>(range.bin(best));
            else if (refused)
                skin->labels[t] = kRefused;
            else if (too_little)
                skin->labels[t] = kTooLittle;
        }
        return skin;
    }

    /// @param range not set: no place has a score
    std::vector<LegendLine> legend_of(const std::optional<Range>& range, const std::vector<MappedIncision>& incisions)
    {
        std::vector<LegendLine> lines;
        if (range) {
            lines.push_back({ "score by rays, before planning, of an incision whose middle is there", "" });
            const double step = (range->high - range->low) / static_cast<double>(kClasses);
            for (std::size_t n = kClasses; n-- > 0;) {
                const double from = range->low + step * static_cast<double>(n);
                lines.push_back({ in_words(from) + " to " + in_words(from + step), " ", class_color(n) });
            }
        }
        lines.push_back({ "shows too little for a proposal", " ", kShowsLittle });
        lines.push_back({ "too near a structure at risk", " ", kNearRisk });
        lines.push_back({ "not tried", " ", kNotTried });
        if (incisions.empty())
            lines.push_back({ "no incision could be proposed", "" });
        for (const MappedIncision& incision : incisions)
            lines.push_back({ incision.sign, incision.words });
        return lines;
    }

} // namespace

Picture search_map(planner::Patient& patient, const planner::IncisionSearch& search,
    const std::vector<MappedIncision>& incisions, int width, int height)
{
    if (search.tried.empty())
        throw InputError("no incision was tried: there is nothing to draw");
    const std::vector<planner::TriedPlace> places = places_of(search);
    const Range range = range_of(places);
    SurfaceItem skin { .name = "skin", .mesh = scored_skin(*patient.body(), places, range) };
    for (std::size_t n = 0; n < kClasses; ++n)
        skin.look_of_label[static_cast<Label>(n)] = Look { .color = class_color(n) };
    skin.look_of_label[kNoScore] = Look { .color = kNotTried };
    skin.look_of_label[kTooLittle] = Look { .color = kShowsLittle };
    skin.look_of_label[kRefused] = Look { .color = kNearRisk };

    const planner::AnatomicalFrame frame = patient.frame();
    struct View {
        const char* title;
        Vec3 towards; ///< from the patient to the reader
    };
    constexpr double kTurn = 0.9, kAbove = 0.1; // tangents of the angles from straight ahead
    const std::array<View, 3> views { {
        { "from the patient's right", frame.anterior - kTurn * frame.left + kAbove * frame.superior },
        { "from the patient's left", frame.anterior + kTurn * frame.left + kAbove * frame.superior },
        { "from behind", -frame.anterior + kAbove * frame.superior },
    } };
    Picture picture { .width = width, .height = height, .viewports = {} };
    for (std::size_t n = 0; n < views.size(); ++n) {
        Scene scene;
        scene.title = views[n].title;
        scene.surfaces = { skin };
        for (const MappedIncision& incision : incisions) {
            const Vec3& middle = incision.points[incision.points.size() / 2];
            Vec3 outward = middle - frame.origin;
            outward -= frame.superior.dot(outward) * frame.superior;
            constexpr double kFacing = 0.3; // cosine; an incision that turns away is left to another view
            if (outward.normalized().dot(views[n].towards.normalized()) < kFacing)
                continue;
            scene.lines.push_back({ .name = incision.words,
                .points = incision.points,
                .color = { 0.85, 0.10, 0.10 },
                .width_px = 5.0,
                .on_top = true });
            scene.words.push_back({ .text = incision.sign, .position = middle, .color = { 1.0, 1.0, 1.0 } });
        }
        if (n + 1 == views.size()) {
            scene.legend
                = legend_of(std::ranges::any_of(places, is_scored) ? std::optional(range) : std::nullopt, incisions);
            scene.legend_share = 0.7;
        }
        const std::optional<Box> bounds = scene_bounds(scene);
        if (!bounds)
            throw InputError("the patient has no skin to draw");
        scene.camera = camera_for_box(*bounds, -views[n].towards, frame.superior);
        const double share = 1.0 / static_cast<double>(views.size()), left = share * static_cast<double>(n);
        picture.viewports.push_back({ .left = left, .right = left + share, .scene = std::move(scene) });
    }
    return picture;
}

} // namespace retractor::ui
