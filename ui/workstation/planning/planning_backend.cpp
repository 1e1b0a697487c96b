#include "ui/workstation/planning/planning_backend.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wound_surface.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/bearing_points.h"
#include "planner/approach/blade_change.h"
#include "planner/approach/blade_fit.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/find_division.h"
#include "planner/approach/retractors.h"
#include "planner/case/case.h"
#include "planner/case/draft_case.h"
#include "planner/case/patient.h"
#include "planner/measures/comparison.h"
#include "planner/measures/sight/instruments.h"
#include "planner/measures/verdict.h"
#include "planner/palpation/through_wound.h"
#include "planner/plan/plan.h"
#include "planner/plan/saved/saved_plan.h"
#include "planner/session/saved_cuts.h"
#include "planner/wall/parted_bones.h"
#include "planner/wall/supports.h"
#include "planner/wall/wall_cut.h"
#include "ui/plan_scene/field_map.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/planned_cut.h"
#include "ui/plan_scene/search_map.h"
#include "ui/results/field_files.h"
#include "ui/scene/vtk/offscreen.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui {

namespace {

    FieldPictures pictures_of(planner::Patient& patient, const planner::PlannedField& field)
    {
        FieldPictures pictures;
        pictures.metrics = field.metrics;
        pictures.divided_bones = planner::divided_bones(*patient.labels(), field.approach);
        pictures.warning = field.message;
        pictures.surgeon = surgeon_scene(patient, field);
        pictures.overview = overview_scene(patient, field);
        for (const FieldMapName& map : kFieldMaps)
            if (auto drawn = field_map(patient, field, map.kind))
                pictures.maps[map.kind] = *std::move(drawn);
        // The numbers stand beside the picture; on it stands only that the target is estimated.
        pictures.surgeon.legend = estimated_lines(std::move(pictures.surgeon.legend));
        pictures.overview.legend = estimated_lines(std::move(pictures.overview.legend));
        return pictures;
    }

    /// The patient's case with this approach alone, which the case may hold in another state.
    planner::Case case_with(const planner::Patient& patient, const planner::Approach& approach)
    {
        planner::Case planned_case = patient.planned_case();
        planned_case.approaches = { approach };
        return planned_case;
    }

    /// The saved plans of the shown approaches. @throws InputError naming an approach whose plan is not saved
    std::vector<planner::PlannedField> saved_fields(
        const planner::Patient& patient, const PlanningBackend::Shown& shown)
    {
        std::vector<planner::PlannedField> fields;
        for (const planner::Approach& approach : shown.planned_case.approaches) {
            if (std::find(shown.planned.begin(), shown.planned.end(), approach.name) == shown.planned.end())
                continue;
            auto saved = planner::read_saved_plan(case_with(patient, approach), approach.name);
            if (!saved)
                throw InputError(
                    "its plan is not saved beside the case, so it cannot be put into a file: plan it again",
                    "approach " + approach.name);
            fields.push_back(std::move(saved->field));
        }
        return fields;
    }

    /// How the plan ended, without its numbers and pictures.
    PlanOutcome outcome_of(const planner::PlannedField& field)
    {
        switch (field.status) {
        case planner::PlanStatus::done:
        case planner::PlanStatus::not_converged:
        case planner::PlanStatus::inverted:
            return { .status = PlanOutcome::Status::planned, .message = {}, .field = {} };
        case planner::PlanStatus::cancelled:
            return { .status = PlanOutcome::Status::cancelled, .message = {}, .field = {} };
        case planner::PlanStatus::nothing_to_mesh:
        case planner::PlanStatus::cut_missed:
            break;
        }
        return { .status = PlanOutcome::Status::refused, .message = field.message, .field = {} };
    }

    PlanOutcome saved_outcome(
        planner::Patient& patient, const planner::Approach& approach, const planner::PlannedField& field)
    {
        PlanOutcome outcome { .message = {}, .field = pictures_of(patient, field) };
        if (field.ended_by_time) {
            remark(outcome.field.warning,
                "the time for this plan was up: it is not saved, and is lost when the case is closed (retractor plan "
                "--time gives it longer)");
            return outcome;
        }
        try {
            planner::save_plan(case_with(patient, approach), field);
        } catch (const Error&) {
            remark(outcome.field.warning,
                "this plan is not saved, and is lost when the case is closed (" + to_string(current_failure()) + ")");
        }
        return outcome;
    }

    /// What the saved plan of an approach says of the force of its retractor; nothing: there is no such plan.
    std::optional<planner::PlannedForce> saved_force(const planner::Patient& patient, const planner::Approach& approach)
    {
        try {
            const auto plan = planner::read_saved_plan(case_with(patient, approach), approach.name);
            return plan ? planned_force(plan->field.metrics) : std::nullopt;
        } catch (const Error&) { // a damaged plan is told of where it is shown
            return std::nullopt;
        }
    }

    /// Differences between the plan's hooks and those of the surgery session; empty: none.
    /// @param is_planned forces are matched to those of the plan
    std::string not_as_planned(const planner::Case& planned_case, bool is_planned)
    {
        std::string text;
        if (planner::under_pressure(planned_case))
            remark(text, "plans include the pressure on the wall, cutting by hand does not");
        if (planner::has_ten_nodes(planned_case.solution.element)) {
            if (!is_planned)
                remark(text,
                    "forces by hand may be off by two or three times: plan the approach first, and they are matched to "
                    "its plan");
            return text;
        }
        const std::vector<fem::Material> here = planner::materials_as_solved(planned_case, planner::ElementKind::p1),
                                         planned = planner::materials_as_solved(planned_case);
        const auto stiffer = std::find_if(planned.begin(), planned.end(), [&](const fem::Material& material) {
            return material.poissons_ratio > here[static_cast<std::size_t>(&material - planned.data())].poissons_ratio;
        });
        if (stiffer != planned.end())
            remark(text,
                "tissue is more compressible in cutting by hand (Poisson's ratio at most "
                    + in_words(planner::largest_poissons_ratio(planner::ElementKind::p1), 2)
                    + ") than in plans of this case (" + stiffer->name + " " + in_words(stiffer->poissons_ratio, 2)
                    + ")");
        return text;
    }

    /// Ten-node elements may be so large that the skin of their mesh is jagged where a hand cuts it.
    planner::SizingSpec fine_enough_to_cut(planner::SizingSpec sizing)
    {
        constexpr double kEdgeMm = 8.0, kCoarseEdgeMm = 15.0; // as in an import
        sizing.corridor_edge_mm = std::min(sizing.corridor_edge_mm, kEdgeMm);
        sizing.coarse_edge_mm = std::min(sizing.coarse_edge_mm, kCoarseEdgeMm);
        return sizing;
    }

    /// The setup of a surgery session. The wall is meshed in the first region, 50 mm, and as in plan_approach(), unless
    /// the plan's elements are too large to be cut by hand. It is not meshed along a division beyond the incision,
    /// which would nearly double it.
    SurgeryInput make_surgery_input(planner::Patient& patient, planner::Approach approach, const Job& job)
    {
        planner::check_approach(approach);
        const planner::Case& planned_case = patient.planned_case();
        std::optional<planner::PlannedForce> force = saved_force(patient, approach);
        const auto labels = patient.labels();
        if (planner::has_ten_nodes(planned_case.solution.element))
            approach.sizing = fine_enough_to_cut(approach.sizing);
        const mesh::MeshSizing sizing = planner::mesh_sizing_of(approach, planned_case.label_table);
        const planner::Approach meshed = approach; // without the division, along which the mesh need not reach
        planner::find_division(approach, patient);
        mesh::HybridModel model = planner::build_wall(*labels, sizing, job);
        if (model.status != mesh::MeshStatus::done)
            throw InputError(
                model.message.empty() ? "there is no wall to cut" : model.message, "approach " + approach.name);
        SurgeryInput input;
        planner::SurgerySetup& setup = input.setup;
        setup.approach = approach;
        if (approach.retractor) {
            setup.approach.hooks = planner::blades_of(approach);
            planner::fit_blades(setup.approach, *labels);
            for (planner::HookSpec& blade : setup.approach.hooks)
                blade.pull.force_N = approach.retractor->force_N;
        }
        planner::find_bearing_points(setup.approach, *labels);
        planner::insert_bearing_points(model.wall, planned_case.label_table, setup.approach);
        fem::Supports supports = planner::supports_of(model.wall, *labels, planned_case, sizing);
        setup.held = std::move(supports.fixed);
        setup.cut_off = planner::cut_off_vertices(model.wall, *labels);
        setup.bedded = std::move(supports.bedded);
        setup.hinges = std::move(supports.hinges);
        setup.labels = planned_case.label_table;
        setup.journal = planner::cuts_journal(planned_case.file(), approach.name);
        setup.materials = planner::materials_as_solved(patient, planner::ElementKind::p1);
        setup.caution = not_as_planned(planned_case, force.has_value());
        setup.planned_force = std::move(force);
        if (!approach.division.strokes.empty())
            remark(setup.caution, "what is divided beyond the skin ends where the meshed wall does");
        setup.write_wall
            = [](const std::filesystem::path& file, const mesh::TetMesh& wall) { mesh::write_vtu(file, wall); };
        Vec3 inward = Vec3::Zero();
        for (const Vec3& direction : approach.directions)
            inward += direction;
        setup.outward = -inward.normalized();
        input.surroundings = knife_surroundings(patient, approach);
        setup.beyond
            = std::make_shared<const TriMesh>(body_beyond(patient, meshed, model.wall, planner::kFittedRimMm, job));
        setup.region = { .corridor = mesh::region_line(sizing), .meshed_mm = sizing.region_mm };
        setup.wall = std::move(model.wall);
        return input;
    }

    /// The skin in the colours of the scores, with the best proposals.
    Image map_of(planner::Patient& patient, const FoundProposals& found, const TextLanguage& language)
    {
        constexpr int kWidth = 2000, kHeight = 1000; // as retractor search: the legend needs the room
        std::vector<MappedIncision> incisions;
        for (const planner::PlannedProposal& planned : found.drafts.best_first)
            incisions.push_back({ .sign = planner::compared_letter(incisions.size()),
                .words = planned.proposal.words,
                .points = planned.proposal.approach.incision });
        OffscreenRenderer renderer(make_offscreen_context());
        renderer.set_language(language);
        return renderer.render(search_map(patient, found.rays, incisions, kWidth, kHeight));
    }

    FoundProposals found_proposals(planner::Patient& patient, const planner::Case& planned_case,
        const planner::SearchRequest& request, const TextLanguage& language, const Job& job)
    {
        constexpr std::size_t kDrafts = 5;
        FoundProposals found { .rays = planner::search_incisions(patient, request, job) };
        if (found.rays.status == planner::SearchStatus::cancelled)
            return found;
        if (found.rays.found.empty())
            throw InputError(planner::why_nothing_found(found.rays, request));
        const std::vector<planner::Proposal> proposals
            = planner::proposals_of(patient, found.rays, request, kDrafts, found.refused);
        found.drafts = planner::draft_plans(planned_case, proposals, kDrafts, found.rays, request, job);
        if (found.drafts.status != planner::SearchStatus::done)
            return found;
        try {
            found.map = map_of(patient, found, language);
        } catch (const Error& error) { // the proposals are there all the same
            found.refused.push_back(std::string("the map could not be drawn: ") + error.what());
        }
        return found;
    }

    ShownWound wound_to_palpate(planner::Patient& patient, const planner::PlannedField& field, const Job& job)
    {
        planner::PalpableThroughWound made
            = planner::make_palpable_through(field, patient, planner::palpated_structure(field.approach, patient), job);
        const haptics::Opening opening { .centre = field.geometry.centre,
            .normal = field.geometry.normal,
            .along = field.geometry.along,
            .length_mm = field.geometry.length_mm,
            .width_mm = field.geometry.width_mm };
        const haptics::StraightRod finger { .thickness_mm = planner::kFingerMm, .reach_mm = planner::kFingerReachMm },
            instrument { .thickness_mm = planner::kShaftMm, .taper_mm = 0.0, .reach_mm = planner::kShaftLengthMm };
        const auto around = haptics::make_surroundings(
            made.around, opening, mesh::deformed_boundary(made.palpable.scene.body.mesh, {}), planner::kFingerMm, job);
        ShownWound wound { .palpable = std::move(made.palpable),
            .scene = surgeon_scene_without(patient, field, made.structure),
            .ways = { { "finger", std::make_shared<const haptics::FingerAccess>(around, opening, finger) },
                { "instrument", std::make_shared<const haptics::FingerAccess>(around, opening, instrument) } } };
        wound.scene.title = planner::spoken_name(field.approach) + ": palpation through the wound";
        wound.scene.legend = estimated_lines(std::move(wound.scene.legend)); // without the numbers of the plan
        return wound;
    }

    /// Finds the skin under a pointer. Made once for all pictures of a patient.
    class SkinPointer {
    public:
        /// @throws InputError, IoError as Patient::labels() and BodyProbe() do
        std::function<std::optional<Vec3>(const Vec3&, const Vec3&)> of(planner::Patient& patient)
        {
            const std::lock_guard lock(mutex_);
            if (labels_ == nullptr) {
                labels_ = patient.labels();
                probe_ = std::make_shared<const planner::BodyProbe>(*labels_);
            }
            return [labels = labels_, probe = probe_](
                       const Vec3& from, const Vec3& direction) { return probe->skin_seen(from, direction); };
        }

    private:
        std::mutex mutex_;
        std::shared_ptr<const mesh::LabelVolume> labels_; ///< the probe refers to them
        std::shared_ptr<const planner::BodyProbe> probe_;
    };

    /// What pictures with and without an approach have in common.
    void complete(ClosedPictures& pictures, planner::Patient& patient, SkinPointer& pointer)
    {
        pictures.label_names = label_names(patient.planned_case());
        pictures.skin_under = pointer.of(patient);
    }

} // namespace

std::optional<planner::PlannedForce> planned_force(const planner::FieldMetrics& field)
{
    if (!field.retractor || !field.error || !field.error->message.empty() || !std::isfinite(field.error->hook_force_N))
        return std::nullopt;
    if (planner::verdict_of(field).light == planner::Light::unknown)
        return std::nullopt; // nobody is to rely on this plan
    const planner::ForceInterval interval = planner::force_interval(field);
    return planner::PlannedForce { .retractor = field.retractor->kind,
        .opening_mm = field.retractor->opening_mm,
        .force_N = field.hook_force_N,
        .low_N = interval.low_N,
        .high_N = interval.high_N,
        .seen_share = field.seen_best_eye,
        .objections = planner::objections_of(field) };
}

PlanningBackend make_planning_backend(
    const planner::Case& planned_case, const TextLanguage& language, const MovieSettings& movie)
{
    const auto patient = std::make_shared<planner::Patient>(planned_case);
    const auto pointer = std::make_shared<SkinPointer>();
    PlanningBackend backend;
    backend.closed_pictures = [patient, pointer](const planner::Approach& approach, const Job&) {
        ClosedPictures pictures { .patient = planning_scene(*patient, approach) };
        if (patient->has_ct()) {
            pictures.slices = slice_scenes(*patient, approach);
            pictures.incision_slices = incision_slice_scenes(*patient, approach);
        }
        pictures.cut = planned_cut(*patient, approach);
        complete(pictures, *patient, *pointer);
        return pictures;
    };
    backend.patient_pictures = [patient, pointer](const Job&) {
        ClosedPictures pictures { .patient = patient_scene(*patient) };
        if (patient->has_ct())
            pictures.slices = patient_slices(*patient);
        complete(pictures, *patient, *pointer);
        return pictures;
    };
    backend.anatomy = [patient](const Job& job) { return anatomy_surfaces(*patient, job); };
    backend.make_approach = [patient](const planner::Case& present, const planner::ApproachDraft& draft) {
        return planner::approach_from_draft(*patient, present, draft);
    };
    backend.move_incision = [patient](const planner::Approach& approach, const std::vector<Vec3>& points) {
        return planner::with_incision_through(*patient, approach, points);
    };
    backend.change_blade = [patient](const planner::Approach& approach, double depth_mm, const Vec3& inward) {
        return planner::with_blade(*patient, approach, depth_mm, inward);
    };
    backend.neighbours
        = [patient](const planner::Approach& approach) { return planner::neighbours_of(*patient, approach); };
    backend.search = [patient, language](const planner::Case& present, const planner::SearchRequest& request,
                         const Job& job) { return found_proposals(*patient, present, request, language, job); };
    if (patient->has_ct())
        backend.labels = [patient] { return patient->labels(); };
    backend.surgery_input = [patient](const planner::Approach& approach, const Job& job) {
        SurgeryInput input = make_surgery_input(*patient, approach, job);
        // The knife does not wait for what only the first look needs.
        input.setup.find_division
            = [patient](planner::Approach& by_hand) { planner::find_division(by_hand, *patient); };
        input.look = [patient, approach, view = std::make_shared<std::unique_ptr<const planner::LiveView>>()](
                         const TriMesh& wall, const TriMesh& around, const Job& looking) {
            if (*view == nullptr)
                *view = std::make_unique<const planner::LiveView>(*patient, approach);
            return (*view)->look(wall, around, looking);
        };
        return input;
    };
    backend.plan = [patient](const planner::Approach& approach, const Job& job) -> PlanOutcome {
        try { // what was planned before in the same way has the same result
            if (const auto saved = planner::read_saved_plan(case_with(*patient, approach), approach.name))
                return { .message = {}, .field = pictures_of(*patient, saved->field) };
        } catch (const Error&) { // damaged: the new plan takes its place
        }
        planner::PlanChecks checks { .find_region = true };
        if (const auto& accuracy = patient->planned_case().solution.accuracy)
            checks.opening_time_s = std::max(checks.opening_time_s, accuracy->time_s);
        const planner::PlannedField field = planner::plan_in_region(*patient, approach, job, checks);
        PlanOutcome outcome = outcome_of(field);
        if (outcome.status != PlanOutcome::Status::planned)
            return outcome;
        job.report("pictures", 0.0);
        return saved_outcome(*patient, approach, field);
    };
    backend.draft = [patient](const planner::Approach& approach, const Job& job) -> PlanOutcome {
        planner::Case quick = case_with(*patient, approach);
        planner::make_draft(quick);
        const planner::PlanChecks checks { .error_bars = false, .draft = true };
        planner::check_plan(quick, checks);
        planner::Patient drafted(quick, job);
        const planner::PlannedField field = planner::plan_approach(drafted, quick.approaches.front(), job, checks);
        PlanOutcome outcome = outcome_of(field);
        if (outcome.status != PlanOutcome::Status::planned)
            return outcome;
        job.report("pictures", 0.0);
        outcome.field = pictures_of(drafted, field);
        for (Scene* scene : { &outcome.field.surgeon, &outcome.field.overview })
            scene->title += " (draft)";
        return outcome;
    };
    backend.saved_plan = [patient](const planner::Approach& approach) -> std::optional<FieldPictures> {
        const std::optional<planner::SavedPlan> saved
            = planner::read_saved_plan(case_with(*patient, approach), approach.name);
        return saved ? std::optional(pictures_of(*patient, saved->field)) : std::nullopt;
    };
    backend.write_movie = [patient, movie](const PlanningBackend::Shown& shown, const std::filesystem::path& file,
                              const std::filesystem::path& pictures, const Job& job) {
        const MovieContent content { .planned_case = shown.planned_case,
            .fields = saved_fields(*patient, shown),
            .decisions = shown.decisions,
            .language = shown.language };
        return write_movie(file, pictures, *patient, content, movie, make_offscreen_context(), job);
    };
    backend.write_report
        = [patient](const PlanningBackend::Shown& shown, const std::filesystem::path& file, const Job& job) {
              std::vector<planner::PlannedField> fields = saved_fields(*patient, shown);
              return write_report_page(
                  file, *patient, fields, { .views = shown.planned_case.views, .language = shown.language }, job);
          };
    backend.palpate_through = [patient](const planner::Approach& approach, const Job& job) {
        const auto saved = planner::read_saved_plan(case_with(*patient, approach), approach.name);
        if (!saved)
            throw InputError("its plan is not saved beside the case: plan it again", "approach " + approach.name);
        return wound_to_palpate(*patient, saved->field, job);
    };
    return backend;
}

} // namespace retractor::ui
