#include "planner/plan/reduction_error.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/plan/hook_equilibrium_correction.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::planner {

namespace {

    /// Largest distance between the two solutions at the lips, divided by the largest displacement of the whole wall.
    double difference_at_lips(const PlannedField& field, const Points& whole)
    {
        double worst = 0.0;
        for (const mesh::LipFace& lip : field.lips)
            for (const VertexId v : mesh::face_vertices(field.wall, lip.face))
                worst = std::max(worst, (field.opening.displacement.row(v) - whole.row(v)).norm());
        const double largest = whole.rowwise().norm().maxCoeff();
        return largest > 0.0 ? worst / largest : 0.0;
    }

    /// Fills in the first-order change when the condensed region follows its own law.
    void compare_with_far_change(const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
        CondensedRegionMetrics& metrics)
    {
        const fem::LinearCondensedRegion& far = *field.opening.far;
        const Points& corners = wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved;
        const Points at = wound.ten_node.size() == 0
            ? corners
            : Points(Eigen::Map<const Points>(wound.ten_node.data(), wound.ten_node.size() / 3, 3));
        // check_solution() refuses a condensed region with locking-free elements or with contact.
        const HeldHooks held
            = held_hooks(field.approach, field.problem, { choice.elasticity }, at, field.opening.hook_forces_N, {});
        WoundSolution changed { .displacement = field.opening.displacement + far.displacement_change };
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            changed.hook_forces_N.push_back(field.opening.hook_forces_N[i] + far.hook_force_changes_N[i]);
        if (!correct_hook_equilibrium(held, changed)) {
            metrics.message
                = "the equilibrium of the hooks cannot be predicted for the nonlinear law of the condensed region";
            return;
        }
        const WoundMeasures here = measures_of(field),
                            there = measures_of(field, wound.rigid, changed.displacement, changed.hook_forces_N);
        metrics.opening_width_mm = std::abs(there.width_mm - here.width_mm);
        metrics.opening_area_mm2 = std::abs(there.area_mm2 - here.area_mm2);
        metrics.hook_force_N = std::abs(there.larger_side_N() - here.larger_side_N());
    }

} // namespace

CondensedRegionMetrics estimate_condensed_region_error(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice)
{
    RETRACTOR_ASSERT(field.opening.far);
    const fem::LinearCondensedRegion& far = *field.opening.far;
    CondensedRegionMetrics metrics { .linear = far.kept, .linear_share = far.share };
    if (far.kept)
        try {
            compare_with_far_change(field, wound, choice, metrics);
        } catch (const Error& error) { // the plan itself is good
            metrics.message = error.what();
        }
    return metrics;
}

WholeMetrics compare_with_whole(
    const PlannedField& field, const RigidPieces& rigid, const SolverSettings& choice, const Job& job)
{
    const Stopwatch watch;
    WholeMetrics measured;
    try {
        OpenedWall opened = open_wall(
            field, 0.0, drives_of(field.approach), opening_options(choice), as_stage(job, "opening, whole wall"));
        fem::OpeningResult& whole = opened.opening;
        if (is_usable(whole)) {
            const WoundMeasures there = measures_of(field, rigid, whole.displacement, whole.hook_forces_N);
            measured.opening_width_mm = there.width_mm;
            measured.opening_area_mm2 = there.area_mm2;
            measured.hook_force_N = there.larger_side_N();
            measured.lips_difference = difference_at_lips(field, whole.displacement);
        } else
            measured.message = whole.message;
    } catch (const Error& error) { // the plan itself is good
        measured.message = std::string("not solved: ") + error.what();
    }
    measured.seconds = watch.seconds();
    return measured;
}

} // namespace retractor::planner
