#include "planner/approach/approach_draft.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/hooks.h"
#include "planner/approach/intercostal_space.h"
#include "planner/approach/retractors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

namespace retractor::planner {

namespace {

    /// The template's kind and the number of its space, which may be missing: "intercostal:4".
    std::pair<std::string, std::string> parts_of(const std::string& template_name)
    {
        const std::size_t colon = template_name.find(':');
        return { template_name.substr(0, colon),
            colon == std::string::npos ? std::string() : template_name.substr(colon + 1) };
    }

    /// "Left" or "Right": that of the lung that is held aside; empty where that is not known.
    std::string operated_side(const Approach& approach)
    {
        const auto aside = [&](std::string_view side) {
            return std::ranges::any_of(approach.retracted, [&](const std::string& organ) {
                return organ.starts_with("lung") && organ.find(side) != std::string::npos;
            });
        };
        const bool left = aside("left"), right = aside("right");
        return left == right ? std::string() : left ? "Left" : "Right";
    }

    Approach drawn_approach(Patient& patient, const ApproachDraft& draft, const ApproachRequest& request)
    {
        const auto labels = patient.labels();
        Approach approach = approach_from_points(*labels, draft.points, request, draft.depth_mm).approach;
        if (draft.divides == Divides::bone)
            approach.uncut_labels.clear();
        if (draft.divides == Divides::space)
            approach.division.extent = DivisionExtent::full;
        name_crossed_skeleton(approach, *labels);
        if (draft.organs_aside)
            approach.retracted = retracted_organs(labels->table, true, true, true);
        return approach;
    }

    /// The hooks of a template that has as many.
    std::string hook_template_of(const Approach& approach)
    {
        const bool wide = approach.hooks.front().patch_width_mm != HookSpec {}.patch_width_mm;
        return approach.hooks.size() == 2 && wide ? "blade" : std::to_string(approach.hooks.size());
    }

    /// The hooks that its template makes for an incision. @throws InputError as make_hooks() does
    std::vector<HookSpec> template_hooks(const Approach& approach, const Approach& incision)
    {
        const HookSpec& first = approach.hooks.front();
        return make_hooks(incision, hook_template_of(approach), 2.0 * first.opening_mm, first.pull);
    }

    /// @throws InputError where the hooks were placed one by one, and no template would make them again
    void check_placed_by_template(const Approach& approach)
    {
        constexpr double kSameMm = 0.1;
        const auto refuse = [&] {
            throw InputError("the hooks of this approach were placed one by one and would not follow the incision: "
                             "choose another opening first",
                "approach " + approach.name);
        };
        const std::size_t count = approach.hooks.size();
        if (count != 2 && count != 4 && count != 8)
            refuse();
        const std::vector<HookSpec> made = template_hooks(approach, approach);
        for (std::size_t n = 0; n < count; ++n)
            if (made.size() != count || std::abs(made[n].along_mm - approach.hooks[n].along_mm) > kSameMm
                || std::abs(made[n].opening_mm - approach.hooks[n].opening_mm) > kSameMm
                || made[n].side != approach.hooks[n].side || made[n].hold != approach.hooks[n].hold)
                refuse();
    }

} // namespace

Approach opened_by(Approach approach, const OpenedBy& opening)
{
    approach.hooks.clear();
    approach.retractor.reset();
    if (!(opening.opening_mm > 0.0))
        return approach;
    if (opening.retractor.empty()) {
        approach.hooks = make_hooks(approach, opening.hooks, opening.opening_mm);
        return approach;
    }
    approach.retractor = make_retractor(
        approach, find_retractor(built_in_retractors(), opening.retractor), { .opening_mm = opening.opening_mm });
    check_approach(approach);
    static_cast<void>(blades_of(approach)); // refuses a wall that is too thin
    return approach;
}

double asked_opening_mm(const Approach& approach)
{
    if (approach.retractor)
        return approach.retractor->force_N ? 0.0 : approach.retractor->opening_mm;
    double opening = 0.0;
    for (const int side : { 1, -1 }) {
        double sum = 0.0;
        int count = 0;
        for (const HookSpec& hook : approach.hooks)
            if (hook.side == side && !hook.pull.force_N) {
                sum += hook.opening_mm;
                ++count;
            }
        opening += count == 0 ? 0.0 : sum / count;
    }
    return opening;
}

Approach with_opening(Approach approach, double opening_mm)
{
    const double present = asked_opening_mm(approach);
    RETRACTOR_ASSERT(present > 0.0 && opening_mm > 0.0);
    if (approach.retractor)
        approach.retractor->opening_mm = opening_mm;
    for (HookSpec& hook : approach.hooks)
        if (!hook.pull.force_N)
            hook.opening_mm *= opening_mm / present;
    check_approach(approach);
    return approach;
}

Approach approach_from_draft(Patient& patient, const Case& planned_case, const ApproachDraft& draft)
{
    ApproachRequest request;
    request.template_name = draft.template_name;
    request.name = draft.name;
    request.target.label = draft.target;
    request.left = draft.left;
    request.sizing = planned_case.sizing;
    Approach approach = draft.template_name.empty()
        ? drawn_approach(patient, draft, request)
        : approach_from_template(*patient.labels(), *patient.anatomy(), request);
    if (draft.name.empty())
        approach.name = free_approach_name(planned_case, draft.template_name.empty() ? "drawn" : approach.name);
    return opened_by(std::move(approach), draft.opened_by);
}

Approach with_incision_through(Patient& patient, const Approach& approach, const std::vector<Vec3>& points)
{
    ApproachRequest request;
    request.name = approach.name;
    request.target = approach.target;
    request.sizing = approach.sizing;
    request.view = approach.view;
    Approach moved = with_incision_of(approach, approach_from_points(*patient.labels(), points, request).approach);
    name_crossed_skeleton(moved, *patient.labels());
    moved.rationale = std::string(kMovedByHand) + moved.rationale;
    return moved;
}

Approach with_incision_of(const Approach& approach, const Approach& placed)
{
    Approach moved = approach;
    moved.incision = placed.incision;
    moved.directions = placed.directions;
    moved.depth_mm = placed.depth_mm;
    moved.wall_thickness_mm = placed.wall_thickness_mm;
    moved.hook_depth_mm = placed.hook_depth_mm;
    moved.rationale = placed.rationale;
    if (moved.retractor) {
        moved.retractor->along_mm = 0.5 * incision_length(moved);
        deepen_blades(moved);
        static_cast<void>(blades_of(moved)); // refuses a wall that is too thin
    } else if (!moved.hooks.empty()) {
        check_placed_by_template(approach);
        moved.hooks = template_hooks(approach, moved);
    }
    check_approach(moved);
    return moved;
}

Approach with_target(Approach approach, TargetSpec target)
{
    if (const std::size_t at = approach.rationale.find(kTargetWords); at != std::string::npos)
        approach.rationale.erase(at, approach.rationale.find('.', at) - at + 1);
    std::erase(approach.retracted, target.label);
    approach.target = std::move(target);
    return approach;
}

std::vector<Vec3> incision_handles(const Approach& approach, double spacing_mm)
{
    const double length = incision_length(approach);
    const int steps = std::max(1, static_cast<int>(std::lround(length / spacing_mm)));
    std::vector<Vec3> handles;
    for (int n = 0; n <= steps; ++n)
        handles.push_back(incision_place(approach, length * n / steps).of(approach.incision));
    return handles;
}

std::string free_approach_name(const Case& planned_case, const std::string& name)
{
    const auto taken = [&](const std::string& wanted) {
        return std::ranges::any_of(
            planned_case.approaches, [&](const Approach& approach) { return approach.name == wanted; });
    };
    std::string wanted = name;
    for (int number = 2; taken(wanted); ++number)
        wanted = name + "-" + std::to_string(number);
    return wanted;
}

std::string surgical_name(const Approach& approach)
{
    const auto [kind, space] = parts_of(approach.template_name);
    const std::string in_space = space.empty() ? std::string() : ", " + ordinal(space) + " space";
    if (kind == "median")
        return "Median sternotomy";
    if (kind == "hemisternotomy-j")
        return "J hemisternotomy" + in_space;
    if (kind == "hemisternotomy-j-left")
        return "Left J hemisternotomy" + in_space;
    if (kind == "hemisternotomy-t")
        return "T hemisternotomy" + in_space;
    if (kind == "intercostal") {
        const std::string side = operated_side(approach);
        return (side.empty() ? "Thoracotomy" : side + " thoracotomy") + in_space;
    }
    if (kind == "distal")
        return "Left posterolateral thoracotomy" + in_space;
    if (kind == "midcab")
        return "Left anterior mini-thoracotomy" + in_space;
    if (kind == "right-anterior")
        return "Right anterior mini-thoracotomy" + in_space;
    if (kind == "right-lateral")
        return "Right lateral mini-thoracotomy" + in_space;
    return "Drawn incision";
}

std::string spoken_name(const Approach& approach)
{
    if (!approach.title.empty())
        return approach.title;
    std::string usual = approach.template_name == "points" ? "drawn" : approach.template_name;
    std::replace(usual.begin(), usual.end(), ':', '_');
    const std::string kind = parts_of(approach.template_name).first;
    for (const std::string& given : { usual, kind }) {
        if (approach.name == given)
            return surgical_name(approach);
        const std::string numbered = given + "-"; // as free_approach_name() makes it
        if (approach.name.starts_with(numbered) && approach.name.size() > numbered.size()
            && std::all_of(approach.name.begin() + static_cast<std::ptrdiff_t>(numbered.size()), approach.name.end(),
                [](char c) { return c >= '0' && c <= '9'; }))
            return surgical_name(approach) + ", no. " + approach.name.substr(numbered.size());
    }
    return approach.name;
}

void set_title(Case& planned_case, std::string_view name, const std::string& title)
{
    Approach& approach = find_approach(planned_case, name);
    const std::string where = "/approaches/" + std::to_string(&approach - planned_case.approaches.data());
    Approach titled = approach;
    titled.title = title;
    for (const Approach& other : planned_case.approaches)
        if (&other != &approach && spoken_name(other) == spoken_name(titled) && !title.empty())
            throw InputError("another approach is called \"" + title + "\": give another title", where + "/title");
    check_approach(titled, where);
    approach = std::move(titled);
}

} // namespace retractor::planner
