#include "planner/plan/reduction_error.h"

#include "mesh/base/error.h"
#include "planner/plan/hook_equilibrium_correction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    /// Of the largest displacement.
    double difference_at_lips(const PlannedField& field, const Points& whole)
    {
        double worst = 0.0;
        for (const mesh::LipFace& lip : field.lips)
            for (const VertexId v : mesh::face_vertices(field.wall, lip.face))
                worst = std::max(worst, (field.opening.displacement.row(v) - whole.row(v)).norm());
        const double largest = whole.rowwise().norm().maxCoeff();
        return largest > 0.0 ? worst / largest : 0.0;
    }

    /// Compares with a smaller part: half the distance, or, where a hook reaches beyond that, three quarters.
    void estimate_local_error(const PlannedField& field, const RigidPieces& rigid, const WoundMeasures& here,
        const fem::OpeningOptions& options, LocalMetrics& local, const Job& job)
    {
        constexpr double kSmaller[] = { 0.5, 0.75 };
        for (const double share : kSmaller) {
            try {
                OpenedPart smaller = open_part(field, { share * local.within_mm }, drives_of(field.approach), options,
                    as_stage(job, "opening, smaller part"));
                local.smaller_mm = share * local.within_mm;
                if (!is_usable(smaller.opening)) {
                    local.message = "the smaller part was not opened as asked";
                    return;
                }
                const WoundMeasures there
                    = measures_of(field, rigid, smaller.opening.displacement, smaller.opening.hook_forces_N);
                const double rest = share / (1.0 - share); // of an error that falls with one over the distance
                local.opening_width_mm = rest * std::abs(here.width_mm - there.width_mm);
                local.opening_area_mm2 = rest * std::abs(here.area_mm2 - there.area_mm2);
                local.hook_force_N = rest * std::abs(here.larger_side_N() - there.larger_side_N());
                local.message.clear();
                return;
            } catch (const InputError& error) { // a hook reaches beyond it: perhaps not beyond a larger part
                local.message = std::string(error.what()) + "; compare with the whole wall instead";
            } catch (const Error& error) { // the plan itself is good
                local.message = std::string("the smaller part was not solved: ") + error.what();
                return;
            }
        }
    }

    void compare_with_far_change(
        const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, FarFieldMetrics& metrics)
    {
        const fem::LinearFarField& far = *field.opening.far;
        const Points& corners = wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved;
        const Points at = wound.ten_node.size() == 0
            ? corners
            : Points(Eigen::Map<const Points>(wound.ten_node.data(), wound.ten_node.size() / 3, 3));
        const HeldHooks held = held_hooks(field.approach, field.problem,
            { choice.elasticity, choice.element == ElementKind::locking_free }, at, field.opening.hook_forces_N,
            wound.contact);
        WoundAnswer changed { .displacement = field.opening.displacement + far.displacement_change };
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            changed.hook_forces_N.push_back(field.opening.hook_forces_N[i] + far.hook_force_changes_N[i]);
        if (!correct_hook_equilibrium(held, {}, changed)) {
            metrics.message = "by its own law the tissue there does not tell where the hooks would rest";
            return;
        }
        const WoundMeasures here = measures_of(field),
                            there = measures_of(field, wound.rigid, changed.displacement, changed.hook_forces_N);
        metrics.opening_width_mm = std::abs(there.width_mm - here.width_mm);
        metrics.opening_area_mm2 = std::abs(there.area_mm2 - here.area_mm2);
        metrics.hook_force_N = std::abs(there.larger_side_N() - here.larger_side_N());
    }

} // namespace

void estimate_far_field_error(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice)
{
    const fem::LinearFarField& far = *field.opening.far;
    FarFieldMetrics& metrics = field.metrics.solution.far.emplace();
    metrics.linear = far.kept;
    metrics.linear_share = far.share;
    if (far.kept)
        try {
            compare_with_far_change(field, wound, choice, metrics);
        } catch (const Error& error) { // the plan itself is good
            metrics.message = error.what();
        }
}

WholeMetrics compare_with_whole(
    const PlannedField& field, const RigidPieces& rigid, const fem::OpeningOptions& options, const Job& job)
{
    const Stopwatch watch;
    WholeMetrics measured;
    try {
        fem::OpeningResult whole
            = open_part(field, {}, drives_of(field.approach), options, as_stage(job, "opening, whole wall")).opening;
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

void estimate_localisation_error(PlannedField& field, const RigidPieces& rigid, const fem::OpeningOptions& options,
    const SubmodelOptions& plan, const Job& job)
{
    LocalMetrics& local = *field.metrics.local;
    if (!is_usable(field.opening)) {
        local.message = "the wound was not opened as asked";
        return;
    }
    const Stopwatch watch;
    if (local.rim_vertices > 0)
        estimate_local_error(field, rigid, measures_of(field), options, local, job);
    local.seconds = watch.seconds();
    if (plan.check && !job.cancelled())
        local.whole = compare_with_whole(field, rigid, options, job);
    if (job.cancelled())
        field.status = PlanStatus::cancelled;
}
} // namespace retractor::planner
