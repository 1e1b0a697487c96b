#pragma once
// The planner's functions for the window. They run on worker threads, possibly at the same time.

#include "mesh/base/job.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/neighbour_approaches.h"
#include "planner/measures/sight/live_view.h"
#include "planner/search/search_plans.h"
#include "planner/session/surgery_session.h"
#include "ui/movie/plan_movie.h"
#include "ui/scene/vtk/render.h"
#include "ui/workstation/palpation/shown_wound.h"
#include "ui/workstation/planning/session_model.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui {

struct PlanOutcome {
    enum class Status { planned, refused, cancelled };
    Status status = Status::planned;
    std::string message; ///< reason of a refusal
    FieldPictures field; ///< filled only when planned
};

/// The input of a surgery session in the window.
struct SurgeryInput {
    planner::SurgerySetup setup;
    Scene surroundings; ///< drawn but not cut; with the camera of the overview
    /// What is seen of the target through the wall as it is, see planner::LiveView::look(). Not set: it is not
    /// measured.
    std::function<planner::SeenNow(const TriMesh& wall, const TriMesh& around, const Job&)> look {};
};

/// What a search proposes.
struct FoundProposals {
    planner::IncisionSearch rays {};
    std::vector<std::string> refused {}; ///< found incisions that do not fit the patient, with the reason
    planner::SearchPlans drafts {};
    Image map {}; ///< the skin in the colours of the scores, with the proposals
};

struct PlanningBackend {
    /// The patient with the incision drawn on the closed skin, and slices where there is a CT.
    std::function<ClosedPictures(const planner::Approach&, const Job&)> closed_pictures;
    /// The patient without an approach.
    std::function<ClosedPictures(const Job&)> patient_pictures;
    /// See anatomy_surfaces().
    std::function<std::vector<SurfaceItem>(const Job&)> anatomy;
    /// The plan is saved beside the case. Where that fails, its warning says so.
    std::function<PlanOutcome(const planner::Approach&, const Job&)> plan;
    /// A draft: a coarse model without contact and errors (planner/case/draft_case.h), which is not saved. Not set:
    /// there are no drafts.
    std::function<PlanOutcome(const planner::Approach&, const Job&)> draft {};
    /// The plan of an earlier session; nothing: there is none of the approach as it is now. The function throws when
    /// the file is damaged. Not set: nothing is saved.
    std::function<std::optional<FieldPictures>(const planner::Approach&)> saved_plan {};
    /// A new approach for the case, which may have other approaches by now. See planner::approach_from_draft().
    std::function<planner::Approach(const planner::Case&, const planner::ApproachDraft&)> make_approach;
    /// See planner::with_incision_through().
    std::function<planner::Approach(const planner::Approach&, const std::vector<Vec3>&)> move_incision;
    /// See planner::with_blade().
    std::function<planner::Approach(const planner::Approach&, double, const Vec3&)> change_blade;
    /// See planner::neighbours_of().
    std::function<std::vector<planner::NeighbourApproach>(const planner::Approach&)> neighbours;
    /// Searches for incisions and plans the best as drafts. What was cancelled says so in the status of the rays or of
    /// the drafts. @throws InputError as planner::search_incisions() does, and where nothing is found
    std::function<FoundProposals(const planner::Case&, const planner::SearchRequest&, const Job&)> search {};
    /// What files of their own are made from: the case as it is shown, and the names of the approaches that are
    /// planned.
    struct Shown {
        planner::Case planned_case;
        std::vector<std::string> planned;
        planner::Decisions decisions {}; ///< of the team, as they are shown
        TextLanguage language {}; ///< of the texts in pictures
    };
    /// Writes a movie of the case and its plans, see write_movie(). @return false: cancelled
    /// @throws InputError also where a plan is not kept beside the case
    std::function<bool(
        const Shown&, const std::filesystem::path& file, const std::filesystem::path& pictures, const Job&)>
        write_movie {};
    /// Writes the report page of the plans, see write_report_page(). @return false: cancelled
    /// @throws InputError also where a plan is not kept beside the case
    std::function<bool(const Shown&, const std::filesystem::path& file, const Job&)> write_report {};
    /// The structure at the approach's target, to be palpated through the opened wound of its plan.
    /// @throws InputError also where the plan is not kept beside the case
    std::function<ShownWound(const planner::Approach&, const Job&)> palpate_through {};
    /// The labels of the case, to be corrected. Not set: there is no CT on which they could be.
    std::function<std::shared_ptr<const mesh::LabelVolume>()> labels {};
    /// The wall round the approach's incision, uncut, for the knife. The function throws when there is no wall.
    std::function<SurgeryInput(const planner::Approach&, const Job&)> surgery_input;
};

/// What a plan says of the force of its retractor; nothing: it has none, or its error is not known.
std::optional<planner::PlannedForce> planned_force(const planner::FieldMetrics& field);

/// The real planner. The backend reads data on first use and keeps them.
/// @param language of the texts in the map of a search
/// @param movie of the movies that it writes
PlanningBackend make_planning_backend(
    const planner::Case& planned_case, const TextLanguage& language = {}, const MovieSettings& movie = {});

} // namespace retractor::ui
