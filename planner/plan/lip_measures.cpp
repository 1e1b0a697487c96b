#include "planner/plan/lip_measures.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/cutting/store/blade.h"
#include "planner/approach/hooks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kStepMm = 2.0; ///< largest step of the curve

    void check(const LipLine& lip, double from_mm, double to_mm)
    {
        if (lip.points.size() < 2 || lip.points.size() != lip.along_mm.size())
            throw InputError(formatted("a lip needs at least two points with one place each, got %zu and %zu",
                lip.points.size(), lip.along_mm.size()));
        if (!std::ranges::is_sorted(lip.along_mm))
            throw InputError("the places of a lip's points decrease");
        if (!std::ranges::all_of(lip.points, [](const Vec3& point) { return point.allFinite(); }))
            throw InputError("a point of a lip is not finite");
        if (!(std::min(to_mm, lip.along_mm.back()) > std::max(from_mm, lip.along_mm.front())))
            throw InputError(formatted("nothing of the lip, from %.1f to %.1f mm, lies between %.1f and %.1f mm",
                lip.along_mm.front(), lip.along_mm.back(), from_mm, to_mm));
    }

    /// The point of the lip at a place, between two of its points.
    Vec3 point_at_place(const LipLine& lip, double along)
    {
        const auto after = std::ranges::upper_bound(lip.along_mm, along);
        if (after == lip.along_mm.begin())
            return lip.points.front();
        if (after == lip.along_mm.end())
            return lip.points.back();
        const auto i = static_cast<std::size_t>(after - lip.along_mm.begin());
        const double share = (along - lip.along_mm[i - 1]) / (lip.along_mm[i] - lip.along_mm[i - 1]);
        return (1.0 - share) * lip.points[i - 1] + share * lip.points[i];
    }

    /// Distance of a point behind the line of the hooks. @pre the hooks are in the order of their places
    double behind(std::span<const LipHook> hooks, double along, const Vec3& point)
    {
        const auto after = std::ranges::upper_bound(hooks, along, {}, &LipHook::along_mm);
        if (after == hooks.begin() || after == hooks.end()) {
            const LipHook& end = after == hooks.begin() ? hooks.front() : hooks.back();
            return (end.place - point).dot(end.outward);
        }
        const LipHook &a = *(after - 1), &b = *after;
        const double share = (along - a.along_mm) / (b.along_mm - a.along_mm);
        const Vec3 on_line = (1.0 - share) * a.place + share * b.place;
        const Vec3 outward = ((1.0 - share) * a.outward + share * b.outward).normalized();
        return (on_line - point).dot(outward);
    }

    /// The lip's edge after the opening.
    LipLine opened_edge(const PlannedField& field, const WoundEdge& edge)
    {
        LipLine lip;
        lip.along_mm = edge.along_mm;
        for (const VertexId v : edge.vertices)
            lip.points.emplace_back((field.wall.vertices.row(v) + field.opening.displacement.row(v)).transpose());
        return lip;
    }

    LipHook lip_hook(const PlannedField& field, std::size_t h)
    {
        const HookSpec& spec = field.approach.hooks[h];
        const fem::HookPatch& hook = field.hooks[h];
        const Vec3 at_rest = incision_place(field.approach, spec.along_mm).of(field.approach.incision);
        Vec3 outward = spec.direction.normalized();
        if (field.retractor) // the frame may have turned as a whole
            outward = field.retractor->state.rotation * outward;
        return { spec.along_mm, at_rest + hook.displacement_of(at_rest), outward };
    }

} // namespace

LipDeviation lip_deviation(const LipLine& lip, std::span<const LipHook> hooks, int side, double from_mm, double to_mm)
{
    RETRACTOR_ASSERT(!hooks.empty());
    check(lip, from_mm, to_mm);
    std::vector<LipHook> in_order(hooks.begin(), hooks.end());
    std::ranges::stable_sort(in_order, {}, &LipHook::along_mm);
    LipDeviation found {
        .side = side, .from_mm = std::max(from_mm, lip.along_mm.front()), .to_mm = std::min(to_mm, lip.along_mm.back())
    };
    const auto deviation = [&](double along) { return behind(in_order, along, point_at_place(lip, along)); };
    const double length = lip.along_mm.back() - lip.along_mm.front();
    const int steps = std::max(1, static_cast<int>(std::ceil(length / kStepMm)));
    for (int i = 0; i <= steps; ++i) {
        const double along = lip.along_mm.front() + length * i / steps;
        found.curve.emplace_back(along, deviation(along));
    }
    const double part = found.to_mm - found.from_mm;
    const int parts = std::max(1, static_cast<int>(std::ceil(part / kStepMm)));
    for (int i = 0; i <= parts; ++i) { // the trapezoidal rule
        const double along = found.from_mm + part * i / parts, here = std::abs(deviation(along));
        found.mean_mm += (i == 0 || i == parts ? 0.5 : 1.0) * here / parts;
        if (i == 0 || here > found.largest_mm) {
            found.largest_mm = here;
            found.at_mm = along;
        }
    }
    return found;
}

std::vector<LipDeviation> lip_deviations(const PlannedField& field)
{
    RETRACTOR_ASSERT(field.hooks.size() == field.approach.hooks.size());
    const WoundEdges edges = wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach)));
    const double length = incision_length(field.approach);
    const double rim = 0.5 * (1.0 - kHeldShare) * length;
    std::vector<LipDeviation> deviations;
    for (const int side : { 1, -1 }) {
        std::vector<LipHook> hooks;
        for (std::size_t h = 0; h < field.hooks.size(); ++h)
            if (field.approach.hooks[h].side == side)
                hooks.push_back(lip_hook(field, h));
        const WoundEdge& edge = side > 0 ? edges.left : edges.right;
        const bool is_held = !hooks.empty() && edge.along_mm.size() > 1 && edge.along_mm.front() < length - rim
            && edge.along_mm.back() > rim;
        if (is_held)
            deviations.push_back(lip_deviation(opened_edge(field, edge), hooks, side, rim, length - rim));
    }
    return deviations;
}

} // namespace retractor::planner
