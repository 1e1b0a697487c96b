#include "planner/approach/hooks.h"

#include "fem/statics/driven_opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/hook_patches.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kSpreaderShare = 0.5, kSpreaderLargestMm = 60.0;
    constexpr double kRimMm = 2.0; ///< distance of a patch from the skin and from the cavity

    /// Direction to the left of the cut, looking down on the skin: side +1, see BladeCoordinates.
    Vec3 left_at(const Approach& approach, double along, double width)
    {
        const auto point = [&](double s) { return incision_place(approach, s).of(approach.incision); };
        const double length = incision_length(approach);
        // The tangent is the chord under the patch, because a rigid patch has one direction.
        const Vec3 tangent = point(std::min(length, along + 0.5 * width)) - point(std::max(0.0, along - 0.5 * width));
        return tangent.cross(incision_place(approach, along).of(approach.directions)).normalized();
    }

    /// Places of the incision over a patch, evenly from one of its ends to the other.
    std::array<IncisionPlace, 5> places_over(const Approach& approach, double along_mm, double width_mm)
    {
        std::array<IncisionPlace, 5> places {};
        const double length = incision_length(approach);
        for (std::size_t n = 0; n < places.size(); ++n) {
            const double share = static_cast<double>(n) / static_cast<double>(places.size() - 1) - 0.5;
            places[n] = incision_place(approach, std::clamp(along_mm + width_mm * share, 0.0, length));
        }
        return places;
    }

    /// Fits a hook to the thinnest wall and the mean hold depth under its patch.
    /// @param largest_depth_mm depth below the skin that the hook reaches at most
    void fit_depth(
        const Approach& approach, HookSpec& hook, double largest_depth_mm = std::numeric_limits<double>::infinity())
    {
        double wall = approach.depth_mm;
        double hold = 0.0;
        const auto places = places_over(approach, hook.along_mm, hook.patch_width_mm);
        for (const IncisionPlace& place : places) {
            if (!approach.wall_thickness_mm.empty())
                wall = std::min(wall, place.of(approach.wall_thickness_mm));
            hold += (approach.hook_depth_mm.empty() ? 0.5 * approach.depth_mm : place.of(approach.hook_depth_mm))
                / static_cast<double>(places.size());
        }
        const double room = wall - 2.0 * kRimMm;
        if (!(room > kRimMm))
            throw InputError("the wall is only " + in_words(wall, 1) + " mm thick under the hook at "
                + in_words(hook.along_mm) + " mm along the incision: no room for a hook");
        // The blade of a retractor reaches from the skin through the wall. If it held only deep tissue, the skin would
        // hang into the field.
        hook.patch_height_mm = std::min(room, largest_depth_mm - kRimMm);
        if (!(hook.patch_height_mm > kRimMm))
            throw InputError("a blade of " + in_words(largest_depth_mm, 1) + " mm does not reach into the wound",
                "retractor", { "blade_depth_mm" });
        const double half = 0.5 * hook.patch_height_mm;
        const double deepest = std::min(wall - kRimMm, largest_depth_mm);
        hook.depth_mm = std::clamp(hold, kRimMm + half, std::max(kRimMm + half, deepest - half));
    }

} // namespace

std::vector<HookSpec> make_hooks(
    const Approach& approach, std::string_view template_name, double opening_mm, const HookPull& pull)
{
    check_approach(approach);
    constexpr double kFarthest = 2.0 * fem::kFarthestHookMm;
    if (!(opening_mm >= 0.0 && opening_mm <= kFarthest))
        throw InputError(
            "the opening must be between 0 and " + in_words(kFarthest) + " mm, got " + std::to_string(opening_mm),
            "opening", { "opening_mm" });
    const double length = incision_length(approach);
    int per_lip = 1;
    HookSpec model;
    if (template_name == "blade")
        model.patch_width_mm = std::min(kSpreaderLargestMm, kSpreaderShare * length);
    else if (template_name == "2" || template_name == "4" || template_name == "8")
        per_lip = (template_name.front() - '0') / 2;
    else
        throw InputError("unknown hook template \"" + std::string(template_name) + "\": use 2, 4, 8 or blade",
            "hook template", { "hook_template" });
    const double spacing = kHeldShare * length / per_lip;
    RETRACTOR_ASSERT(per_lip > 0);
    if (spacing < model.patch_width_mm)
        throw InputError("an incision of " + in_words(length) + " mm is too short for " + std::to_string(per_lip)
                + " hooks of " + in_words(model.patch_width_mm) + " mm on each lip",
            "hook template", { "hook_template" });

    // The blades of a spreader are parallel. Different directions would pull one piece of bone in two.
    const auto along_of = [&](int n) { return 0.5 * (1.0 - kHeldShare) * length + (n + 0.5) * spacing; };
    Vec3 left = Vec3::Zero();
    for (int n = 0; n < per_lip; ++n)
        left += left_at(approach, along_of(n), model.patch_width_mm);
    left.normalize();

    std::vector<HookSpec> hooks;
    for (const int side : { 1, -1 })
        for (int n = 0; n < per_lip; ++n) {
            HookSpec hook = model;
            hook.side = side;
            hook.name = std::string(side > 0 ? "left" : "right") + "_" + std::to_string(n + 1);
            hook.along_mm = along_of(n);
            hook.direction = side * left;
            hook.opening_mm = 0.5 * opening_mm;
            hook.pull = pull;
            fit_depth(approach, hook);
            hooks.push_back(hook);
        }
    return hooks;
}

std::vector<HookSpec> make_blades(const Approach& approach, double along_mm, double width_mm, double largest_depth_mm)
{
    const Vec3 left = left_at(approach, along_mm, width_mm);
    std::vector<HookSpec> blades;
    for (const int side : { 1, -1 }) {
        HookSpec blade { .name = blade_name(side * left),
            .side = side,
            .along_mm = along_mm,
            .patch_width_mm = width_mm,
            .direction = side * left };
        fit_depth(approach, blade, largest_depth_mm);
        blades.push_back(std::move(blade));
    }
    return blades;
}

double depth_through_wall(const Approach& approach, double along_mm, double width_mm)
{
    double thickest = 0.0;
    if (!approach.wall_thickness_mm.empty())
        for (const IncisionPlace& place : places_over(approach, along_mm, width_mm))
            if (const double wall = place.of(approach.wall_thickness_mm); wall < approach.depth_mm)
                thickest = std::max(thickest, wall);
    return thickest > 0.0 ? thickest : approach.depth_mm;
}

void set_hooks(Case& planned_case, std::string_view approach_name, std::string_view template_name, double opening_mm,
    const HookPull& pull)
{
    Approach& approach = find_approach(planned_case, approach_name);
    approach.hooks = make_hooks(approach, template_name, opening_mm, pull);
    approach.retractor.reset();
}

} // namespace retractor::planner
