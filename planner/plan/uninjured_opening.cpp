#include "planner/plan/uninjured_opening.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/hook_opening.h"
#include "planner/plan/bone_loads.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    /// Between the limits of what is accepted.
    constexpr double kAimedUse = 0.98;
    constexpr int kMostSolves = 4;

    /// Height of a rib over its thickness (13.5 by 7 mm, kTestedRibAreaMm2).
    constexpr double kRibHeightPerThickness = 13.5 / 7.0;

    /// Height of a bone with this section, taken as an ellipse.
    double height_of(double section_mm2)
    {
        return std::sqrt(4.0 / std::numbers::pi * kRibHeightPerThickness * section_mm2);
    }

} // namespace

std::optional<UseAtShare> find_full_use(
    double full, int most_solves, const std::function<std::optional<double>(double share)>& use_at)
{
    RETRACTOR_ASSERT(full > kMostFullUse);
    UseAtShare below { 0.0, 0.0 }, above { 1.0, full };
    for (int n = 0; n < most_solves; ++n) {
        const double share
            = below.share + (above.share - below.share) * (kAimedUse - below.use) / (above.use - below.use);
        const std::optional<double> use = use_at(share);
        if (!use)
            break;
        (*use <= kMostFullUse ? below : above) = { share, *use };
        if (below.use >= kLeastFullUse)
            break;
    }
    return below.share > 0.0 ? std::optional(below) : std::nullopt;
}

void solve_uninjured_opening(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const mesh::LabelTable& table, const AnatomicalFrame& frame, const Job& job)
{
    FieldMetrics& m = field.metrics;
    if (!breaks_bone(m))
        return;
    const Stopwatch watch;
    UninjuredOpening found;
    std::vector<std::pair<double, UninjuredOpening>> solved; // by share
    const auto use_at = [&](double share) -> std::optional<double> {
        const OpenedWall opened = reopen_wall(field, wound, share, choice, job);
        ++found.solves;
        if (!is_usable(opened.opening)) {
            found.message = "the wound has no equilibrium at a smaller opening";
            return std::nullopt;
        }
        const std::vector<BoneMetrics> bones
            = bone_metrics(field.problem, choice, displacement_at_nodes(opened), table, frame);
        const auto worst = std::ranges::max_element(bones, {}, &BoneMetrics::utilisation);
        const std::array<double, 2> sides = side_forces(field, opened.opening.hook_forces_N);
        solved.emplace_back(share,
            UninjuredOpening {
                .bone = worst->name, .utilisation = worst->utilisation, .hook_force_N = std::max(sides[0], sides[1]) });
        return worst->utilisation;
    };
    try {
        const auto full = std::ranges::max(m.bones, {}, &BoneMetrics::utilisation).utilisation;
        if (const std::optional<UseAtShare> answer = find_full_use(full, kMostSolves, use_at)) {
            const auto at = std::ranges::find(solved, answer->share, &std::pair<double, UninjuredOpening>::first);
            found.bone = at->second.bone;
            found.utilisation = at->second.utilisation;
            found.hook_force_N = at->second.hook_force_N;
            found.opening_mm = answer->share * hook_opening(m).reached_mm;
            m.largest_uninjured_opening_mm = found.opening_mm;
            found.message.clear();
        } else if (found.message.empty()) {
            found.message = "no smaller opening without a fracture was found";
        }
    } catch (const SolverError& error) {
        found.message = error.what();
    }
    found.seconds = watch.seconds();
    m.uninjured_opening = std::move(found);
}

std::optional<Approach> with_divided_bone(const Approach& approach, const PlannedField& field)
{
    if (!breaks_bone(field.metrics))
        return std::nullopt;
    const BoneMetrics& bone = field.metrics.bones.front();
    Approach divided = approach;
    divided.title.clear(); // it is of the approach that leaves the bone whole
    divided.name += " (" + bone.name + " divided)";
    divided.sizing = field.approach.sizing;
    divided.ablations.push_back({ .label = bone.name, .centre = bone.place, .radius_mm = height_of(bone.section_mm2) });
    return divided;
}

} // namespace retractor::planner
