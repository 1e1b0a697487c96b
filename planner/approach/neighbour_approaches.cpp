#include "planner/approach/neighbour_approaches.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/anatomy.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/intercostal_space.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kSamePlaceMm = 1.0; ///< an incision made again from its template is the same up to this distance
    constexpr double kLeastStepMm = 10.0; ///< a neighbour that is nearer is the same approach
    constexpr int kHighestSpace = 1, kLowestSpace = 11;

    /// What neighbours are made from.
    struct Surroundings {
        std::shared_ptr<const mesh::LabelVolume> labels;
        std::shared_ptr<const Anatomy> anatomy; ///< empty: the labels have no landmarks
        std::optional<SpaceNumber> space; ///< that the incision follows
    };

    Vec3 middle_of(const Approach& approach)
    {
        return incision_place(approach, 0.5 * incision_length(approach)).of(approach.incision);
    }

    /// "forwards", "towards the head", "to the left": the patient's axis that is nearest to a motion.
    std::string direction_words(const AnatomicalFrame& frame, const Vec3& motion)
    {
        const std::array<std::pair<double, std::array<const char*, 2>>, 3> axes { {
            { frame.anterior.dot(motion), { "forwards", "backwards" } },
            { frame.superior.dot(motion), { "towards the head", "towards the feet" } },
            { frame.left.dot(motion), { "to the patient's left", "to the patient's right" } },
        } };
        const auto nearest = std::max_element(axes.begin(), axes.end(),
            [](const auto& a, const auto& b) { return std::abs(a.first) < std::abs(b.first); });
        return nearest->second.at(nearest->first < 0.0 ? 1 : 0);
    }

    /// "20mm_forwards".
    std::string name_suffix(std::string words)
    {
        words.erase(std::remove_if(words.begin(), words.end(), [](char c) { return c == '\''; }), words.end());
        std::replace(words.begin(), words.end(), ' ', '_');
        return words;
    }

    std::string kind_of(const Approach& approach)
    {
        return approach.template_name.substr(0, approach.template_name.find(':'));
    }

    /// The template's approach in a space, moved along it.
    Approach from_template(
        const Surroundings& around, const Approach& approach, const SpaceNumber& space, double shift_mm)
    {
        ApproachRequest request;
        request.template_name = kind_of(approach) + ":" + std::to_string(space.number);
        request.name = approach.name;
        request.target = approach.target;
        request.left = space.left;
        request.length_mm = incision_length(approach);
        request.shift_mm = shift_mm;
        request.division = approach.division.extent;
        request.sizing = approach.sizing;
        request.view = approach.view;
        return approach_from_template(*around.labels, *around.anatomy, request);
    }

    /// Whether the incision is still where its template puts it, so that its neighbours come from the template, too.
    bool is_where_its_template_puts_it(const Surroundings& around, const Approach& approach)
    {
        if (approach.template_name == "points" || !around.space)
            return false;
        try {
            const Approach again = from_template(around, approach, *around.space, 0.0);
            return (again.incision.front() - approach.incision.front()).norm() < kSamePlaceMm
                && (again.incision.back() - approach.incision.back()).norm() < kSamePlaceMm;
        } catch (const InputError&) {
            return false;
        }
    }

    /// The place at which a space is cut, at an angle round the chest; beyond an end, the end.
    Vec3 cut_at_angle(const IntercostalSpace& space, double angle_deg)
    {
        const auto after = std::find_if(space.places.begin() + 1, space.places.end() - 1,
            [&](const SpacePlace& place) { return place.angle_deg >= angle_deg; });
        const SpacePlace &a = *(after - 1), &b = *after;
        const double t = std::clamp((angle_deg - a.angle_deg) / (b.angle_deg - a.angle_deg), 0.0, 1.0);
        return (1.0 - t) * a.cut + t * b.cut;
    }

    /// A drawn incision at the same angles of another space, as far from where it is cut as it is in its own.
    Approach drawn_in_space(Patient& patient, const Surroundings& around, const Approach& approach, int number)
    {
        const BodyProbe probe(*around.labels);
        const bool left = around.space->left;
        const IntercostalSpace own = find_intercostal_space(probe, *around.anatomy, left, around.space->number),
                               other = find_intercostal_space(probe, *around.anatomy, left, number);
        std::vector<Vec3> points;
        for (const Vec3& point : incision_handles(approach)) {
            const auto nearest
                = std::min_element(own.places.begin(), own.places.end(), [&](const SpacePlace& a, const SpacePlace& b) {
                      return (a.cut - point).squaredNorm() < (b.cut - point).squaredNorm();
                  });
            points.push_back(point + cut_at_angle(other, nearest->angle_deg) - nearest->cut);
        }
        return with_incision_through(patient, approach, points);
    }

    /// A drawn incision moved along its own line, and on in the direction of its end.
    Approach drawn_along(Patient& patient, const Approach& approach, double shift_mm)
    {
        const double length = incision_length(approach);
        const auto place = [&](double along) -> Vec3 {
            const double inside = std::clamp(along, 0.0, length);
            const IncisionPlace at = incision_place(approach, inside);
            const Vec3 ahead = (approach.incision[at.segment + 1] - approach.incision[at.segment]).normalized();
            return at.of(approach.incision) + (along - inside) * ahead;
        };
        const std::size_t steps = incision_handles(approach).size() - 1;
        std::vector<Vec3> points;
        for (std::size_t n = 0; n <= steps; ++n)
            points.push_back(place(length * static_cast<double>(n) / static_cast<double>(steps) + shift_mm));
        return with_incision_through(patient, approach, points);
    }

    /// Says in the rationale where the incision comes from.
    void say_origin(Approach& neighbour, const Approach& approach, const std::string& where)
    {
        neighbour.title.clear(); // it is of the approach beside it
        std::string& why = neighbour.rationale;
        if (why.starts_with(kMovedByHand))
            why.erase(0, kMovedByHand.size());
        why = "As " + approach.name + ", " + where + ". " + why;
    }

    /// A neighbour, or the reason why there is none.
    NeighbourApproach tried(std::string where, const std::function<Approach()>& make)
    {
        NeighbourApproach neighbour { .where = std::move(where) };
        try {
            neighbour.approach = make();
        } catch (const InputError& error) {
            neighbour.refused = error.what();
        }
        return neighbour;
    }

    /// The approach with incision and template of another one.
    Approach at_place_of(const Approach& approach, const Approach& placed)
    {
        Approach moved = with_incision_of(approach, placed);
        moved.template_name = placed.template_name;
        return moved;
    }

    NeighbourApproach named_after_space(NeighbourApproach neighbour, const Approach& approach, int number)
    {
        if (neighbour.approach) {
            neighbour.approach->name = approach.name + "_space_" + std::to_string(number);
            say_origin(*neighbour.approach, approach, neighbour.where);
        }
        return neighbour;
    }

    NeighbourApproach in_space(
        Patient& patient, const Surroundings& around, const Approach& approach, bool by_template, int number)
    {
        const bool higher = number < around.space->number;
        NeighbourApproach neighbour = tried(higher ? "one space higher" : "one space lower", [&] {
            if (number < kHighestSpace || number > kLowestSpace)
                throw InputError(space_name(around.space->left, around.space->number) + " is the "
                    + (higher ? "highest" : "lowest"));
            const bool removes_bone = std::ranges::any_of(
                approach.ablations, [](const AblationSpec& ablation) { return !ablation.label.empty(); });
            if (removes_bone)
                throw InputError("the approach removes tissue of its own space");
            if (!by_template) {
                Approach moved = drawn_in_space(patient, around, approach, number);
                moved.template_name = "points"; // the space of a template is another one
                return moved;
            }
            const Approach placed = from_template(around, approach, { around.space->left, number }, 0.0);
            return at_place_of(approach, placed);
        });
        return named_after_space(std::move(neighbour), approach, number);
    }

    /// The hemisternotomy of the approach's template in a space.
    Approach hemisternotomy(const Surroundings& around, const Approach& approach, int number)
    {
        ApproachRequest request;
        request.template_name = kind_of(approach) + ":" + std::to_string(number);
        request.target = approach.target;
        request.sizing = approach.sizing;
        request.view = approach.view;
        return approach_from_template(*around.labels, *around.anatomy, request);
    }

    /// The space in which a hemisternotomy turns; nothing where its incision was moved, or its template names none.
    std::optional<int> hemisternotomy_space(const Surroundings& around, const Approach& approach)
    {
        const std::string text
            = approach.template_name.substr(std::min(approach.template_name.size(), kind_of(approach).size() + 1));
        int number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (!around.anatomy || error != std::errc {} || end != text.data() + text.size())
            return std::nullopt;
        try {
            const Approach again = hemisternotomy(around, approach, number);
            const bool same = (again.incision.front() - approach.incision.front()).norm() < kSamePlaceMm
                && (again.incision.back() - approach.incision.back()).norm() < kSamePlaceMm;
            return same ? std::optional(number) : std::nullopt;
        } catch (const InputError&) {
            return std::nullopt;
        }
    }

    /// A hemisternotomy whose saw turns in another space.
    NeighbourApproach hemisternotomy_at(const Surroundings& around, const Approach& approach, int own, int number)
    {
        const bool higher = number < own;
        NeighbourApproach neighbour = tried(higher ? "one space higher" : "one space lower", [&] {
            const Approach placed = hemisternotomy(around, approach, number);
            return at_place_of(approach, placed);
        });
        return named_after_space(std::move(neighbour), approach, number);
    }

    NeighbourApproach along_incision(
        Patient& patient, const Surroundings& around, const Approach& approach, bool by_template, double shift_mm)
    {
        const AnatomicalFrame frame = around.anatomy ? around.anatomy->frame : patient.frame();
        const double length = incision_length(approach);
        const Vec3 towards = (shift_mm > 0.0 ? 1.0 : -1.0)
            * (incision_place(approach, 0.75 * length).of(approach.incision)
                - incision_place(approach, 0.25 * length).of(approach.incision));
        const std::string direction = direction_words(frame, towards);
        NeighbourApproach neighbour = tried(in_words(std::abs(shift_mm)) + " mm " + direction, [&] {
            return by_template ? with_incision_of(approach, from_template(around, approach, *around.space, shift_mm))
                               : drawn_along(patient, approach, shift_mm);
        });
        if (!neighbour.approach)
            return neighbour;
        const double moved = (middle_of(*neighbour.approach) - middle_of(approach)).norm();
        if (moved < kLeastStepMm) {
            neighbour.approach.reset();
            neighbour.refused = std::round(moved) < 1.0 ? "the space leaves no room that way"
                                                        : "the space leaves room for " + in_words(moved) + " mm only";
        } else {
            neighbour.where = in_words(std::round(moved)) + " mm " + direction;
            neighbour.approach->name
                = approach.name + "_" + in_words(std::round(moved)) + "mm_" + name_suffix(direction);
            say_origin(*neighbour.approach, approach, neighbour.where);
        }
        return neighbour;
    }

} // namespace

std::vector<NeighbourApproach> neighbours_of(Patient& patient, const Approach& asked)
{
    Approach approach = asked;
    if (approach.retractor) // of a planned field, whose hooks are the blades
        approach.hooks.clear();
    std::vector<NeighbourApproach> neighbours;
    if (kind_of(approach) == "median")
        return neighbours;
    Surroundings around { .labels = patient.labels(), .anatomy = nullptr, .space = {} };
    try {
        around.anatomy = patient.anatomy();
        around.space = space_under_incision(*around.anatomy, approach);
    } catch (const InputError&) { // no landmarks: an incision has neighbours along itself
    }
    if (const std::string kind = kind_of(approach); kind.starts_with("hemisternotomy")) {
        if (const std::optional<int> own = hemisternotomy_space(around, approach))
            for (const int step : { -1, 1 })
                neighbours.push_back(hemisternotomy_at(around, approach, *own, *own + step));
        return neighbours;
    }
    const bool by_template = is_where_its_template_puts_it(around, approach);
    if (around.space)
        for (const int step : { -1, 1 })
            neighbours.push_back(in_space(patient, around, approach, by_template, around.space->number + step));
    for (const double shift : { kNeighbourStepMm, -kNeighbourStepMm })
        neighbours.push_back(along_incision(patient, around, approach, by_template, shift));
    return neighbours;
}

} // namespace retractor::planner
