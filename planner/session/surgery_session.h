#pragma once
// Surgery on a patient's wall, without a window. Strokes on the skin become cuts, which can be undone and redone. Under
// tension the wound gapes: springs on the edges of the mesh pull the wound open while the knife moves. Hooks open
// wounds further and hold them open during later cuts; with hooks the wall is solved by WoundHooks, including the
// tension, without springs. Used from one thread. Units mm; frame patient LPS.

#include "fem/material/material.h"
#include "mesh/cutting/ablated_values.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/pieces.h"
#include "mesh/cutting/surface_follower.h"
#include "mesh/image/volume.h"
#include "planner/approach/retractors.h"
#include "planner/case/approach.h"
#include "planner/session/cut_history.h"
#include "planner/session/retractor/force_match.h"
#include "planner/session/wall_picture.h"
#include "planner/session/wall_region.h"
#include "planner/session/wound_hooks.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
class SpringNetwork;
}

namespace retractor::planner {

/// The input of a session: the wall of one approach.
struct SurgerySetup {
    mesh::TetMesh wall; ///< four nodes per element, at rest
    /// Vertices of the wall that do not move. Springs have no softer support: in the spring model a bed
    /// (Supports::bedded) is free.
    std::vector<VertexId> held;
    /// Vertices of faces where the wall was cut off (cut_off_vertices() of planner/wall/supports.h), whether they move
    /// or not. The tension model counts no such face as skin.
    std::vector<VertexId> cut_off {};
    std::vector<fem::BeddedVertex> bedded {}; ///< bed of springs that hooks also pull against; not in the spring model
    std::vector<fem::Hinge> hinges {}; ///< of the bones on such a bed
    Approach approach {}; ///< its hooks are the planned hooks
    mesh::LabelTable labels;
    /// Materials by label; labels outside the wall may be missing. Hooks need materials that four-node elements can
    /// solve (as_solved() of planner/case/solver_settings.h), because nearly incompressible tissue locks.
    std::vector<fem::Material> materials;
    Vec3 outward = -Vec3::UnitY(); ///< direction out of the body, for tissue without skin above
    WallRegion region {}; ///< region of the wall that can be cut
    /// Wall outside the mesh, drawn but not cut, which follows the rim; null: none.
    std::shared_ptr<const TriMesh> beyond {};
    std::filesystem::path journal; ///< file that keeps the cuts; empty: cuts are not kept
    std::string caution {}; ///< message for the surgeon when the session is ready; may be empty
    std::optional<PlannedForce> planned_force {}; ///< of the approach's plan; nothing: there is none
    /// Finds the strokes of an approach's division, as find_division() of planner/approach/find_division.h; empty:
    /// nothing is divided beyond a cut that was drawn by hand.
    std::function<void(Approach&)> find_division {};
    /// Writes the cut wall at rest to a file (ExportWall), on the session's thread; empty: the wall cannot be saved.
    std::function<void(const std::filesystem::path&, const mesh::TetMesh&)> write_wall {};
};

struct KnifeSettings {
    double depth_mm = 15.0;
    bool through_wall = false; ///< cuts as deep as the wall is thick near the first point; depth_mm is not used
    bool cuts_bone = false; ///< a scalpel does not cut bone and cartilage; a saw does
};

/// The result of a request.
struct [[nodiscard]] KnifeAnswer {
    bool done = false; ///< false: nothing was changed
    std::string reason; ///< not done: the reason; done: a message for the surgeon, or empty
};

class SurgerySession {
public:
    /// Starts without a journal, whatever setup.journal says. The constructor is reported as part "cutting session".
    /// @throws InputError as CutSession
    explicit SurgerySession(SurgerySetup setup, const Job& job = {});
    /// Starts from a session of the setup's wall that has these cuts. Those that the approach plans are recognised.
    /// @param cuts one delta per cut, in order.
    /// @pre no stroke is open
    SurgerySession(
        SurgerySetup setup, mesh::CutSession session, const std::vector<mesh::MeshDelta>& cuts, const Job& job = {});
    ~SurgerySession();
    SurgerySession(SurgerySession&&) noexcept;

    /// Sets the knife on the skin. Refused outside the region that can be cut (WallRegion), in a wound, on bare bone
    /// that the knife does not cut, and when the wall has no far side to cut through to.
    /// @throws InputError when the depth is not positive and finite, or a stroke is open
    KnifeAnswer begin_stroke(const Touch& at, const KnifeSettings& settings);
    /// Draws the stroke on, and cuts every kStepMm. A point that cannot be cut (the line turns back on itself or
    /// crosses itself) is left out of the line, with a message; the same holds for a step that the session refuses
    /// (SolverError).
    /// @throws InputError when no stroke is open; exceptions of the session's witness, and nothing was drawn then
    KnifeAnswer draw_to(const Touch& at);
    /// Tells that the knife moves where there is no wall. The stroke continues when the knife comes back to the wall,
    /// or ends here, with a message from finish_stroke().
    /// @throws InputError when no stroke is open
    void leave_wall();
    /// Cuts up to the last point, or to the last point that can be cut. Refused when nothing was cut, and when the
    /// session cannot finish the stroke, which is then undone.
    /// @throws InputError when no stroke is open; exceptions of the session's witness: the stroke is still open, and
    /// may be finished again or abandoned
    KnifeAnswer finish_stroke();
    /// Undoes an open stroke without a trace; does nothing without an open stroke.
    /// @throws exceptions of the session's witness: the stroke is still open
    void abandon_stroke();
    bool stroke_open() const { return stroke_ != nullptr; }

    /// Cuts the planned incision, and what the approach divides beyond the skin; each can be undone. What the plan
    /// removes stays. Refused after another cut, and while a stroke is open. The incision stays when a stroke of the
    /// division fails, with a message.
    /// @throws exceptions of the session's witness
    KnifeAnswer cut_as_planned();
    /// Divides beyond the ends of the last cut from the skin what the approach divides beyond its own: intercostal
    /// muscle and pleura, or the sternum. Each stroke can be undone. Refused when the approach divides nothing beyond
    /// the skin, when the cut does not go through the wall, and when all ways are divided already.
    /// @throws exceptions of the session's witness
    KnifeAnswer divide_beyond_cut();
    /// What divide_beyond_cut() divides.
    DivisionExtent division() const { return approach_.division.extent; }

    /// Removes tissue as one cut that can be undone. Radius 0 removes the piece that was cut free at the place. A
    /// positive radius removes the tissue of the touched label within a ball, element by element, so that its border is
    /// as fine as the mesh. Elements of a ball that are held, or lie where the knife cannot cut (WallRegion), stay,
    /// with a message; a piece with such elements is refused. Also refused: an open stroke, no piece cut free at the
    /// place, and a removal of nothing or of everything.
    /// @throws InputError when the radius is negative or not finite; exceptions of the session's witness
    KnifeAnswer take_out(const Touch& at, double radius_mm);

    bool can_undo() const { return !stroke_open() && session_.can_undo(); }
    bool can_redo() const { return !stroke_open() && session_.can_redo(); }
    /// Undoes (redoes) a cut; hooks stay as long as they hold, and their later (earlier) steps count as undone (made).
    /// @throws InputError when there is nothing to undo (redo), or a stroke is open
    void undo();
    void redo();
    /// The last step, of a hook or a cut, that can be undone (redone), in words: "setting the retractor", "cut".
    /// Successive moves of one hook are one step. Empty: none.
    std::string step_to_undo() const;
    std::string step_to_redo() const;
    /// Undoes (redoes) that step. With a cut the hooks come back that it took off.
    /// @throws as undo() and redo()
    void undo_step();
    void redo_step();

    /// Sets the strain of the wall's tissue. When the materials have pre-strains (the case's tension), these are scaled
    /// so that the largest has this value. Else all soft tissue gets this strain in all directions of the skin's plane,
    /// and bone and cartilage none. With 0 wounds stay closed, and there are no springs. Springs are made when they are
    /// first needed (part "springs"). The springs are not calibrated on the wall: spring_calibration()
    /// (tests/verification/framework/tension.h) would factor the wall as a plan does, for a factor of 1.01 to 1.03 on
    /// the stiffness. Wounds therefore gape 1 to 3 % too wide.
    /// @throws InputError when the strain is negative, NaN or beyond kLargestPreStrain, or when springs cannot be made;
    /// the tension is unchanged then
    void set_tension(double strain);
    double tension() const { return tension_; }
    /// The largest pre-strain of the materials, at which a wound gapes as in a plan. 0: the materials have no
    /// pre-strain.
    double case_tension() const;
    /// Lets the wound open for about this time; the next calls continue. With hooks, returns when the wound is at rest
    /// or the job is cancelled. Does nothing when !moving().
    void relax(double milliseconds, const Job& job = {});
    /// Whether the wound still moves visibly.
    bool moving() const { return moving_; }
    /// Gape of the widest wound, measured between separated vertices, mm; 0: closed.
    double gape_mm() const;

    /// Places a hook on the wound's edge near the touched place, where the lip is now. The first hook creates the
    /// solver (part "online opening"). Refused with a message when there is no lip to hold, while a stroke is open, and
    /// when the wall has no support.
    KnifeAnswer place_hook(const Touch& at);
    /// Places a retractor: one blade on the wound's edge near the touched place, the other on the lip opposite. It
    /// holds the lips where they are now. Refused as place_hook().
    KnifeAnswer place_retractor(const Touch& at, const RetractorKind& kind);
    /// Opens a retractor to a distance of its arms, as WoundHooks::crank(); does nothing when the blade is gone.
    void crank(fem::HookId blade, double opening_mm);
    /// Places the approach's hooks or retractor, with their planned displacement, force, limit and soft grip. Hooks
    /// without a lip to hold are left out and named in the message. Hooks that are there already, and were moved by
    /// hand, go back to their plan.
    KnifeAnswer take_planned_hooks();
    std::size_t planned_hooks() const { return approach_.hooks.size(); }
    /// Takes what a new plan of the approach says, instead of SurgerySetup::planned_force; nothing: no force.
    /// @return false: it says the same
    bool set_planned_force(const std::optional<PlannedForce>& force);
    /// Pulls a hook to a displacement, mm from rest; does nothing when the hook is gone.
    void pull_hook(fem::HookId hook, const Vec3& asked);
    void pull_all_hooks(double mm); ///< pulls each hook away from the other lip
    void pull_hooks_by_share(double share); ///< to this share of their plan, as WoundHooks::pull_share()
    /// Sets the force at which hooks slip, N; infinite: only at their own limits.
    /// @throws InputError when the force is not positive
    void set_yield(double force_N);
    /// Whether wounds with hooks are solved nonlinearly near the wound (WoundHooks); off at the start.
    void set_nonlinear(bool wanted);
    void take_off_hook(fem::HookId hook); ///< does nothing when the hook is gone
    void take_off_hooks();
    /// Report of the hooks; empty without hooks. Once the planned cut was opened by the planned retractor as far as
    /// planned, the forces of this retractor are those of the plan there, and in proportion at other openings and after
    /// further cuts. Hooks that slip from a force on (set_yield()) are not matched.
    HookReport hooks() const;
    /// Whether relax() has work left for the hooks: unsettled numbers of a moved hook, or a missing nonlinear solution.
    bool hooks_unsettled() const { return hooks_ != nullptr && !hooks_->settled(); }
    /// Whether relax() would change nothing yet, because the nonlinear solution is still being made.
    bool waiting() const { return hooks_ != nullptr && hooks_->waits(stroke_open()); }
    /// Message about the springs since the last call, e.g. that they failed and the tension is off; empty: none.
    std::string take_remark() { return std::exchange(remark_, {}); }

    /// All cuts that can be undone or redone, in order.
    const std::vector<CutEntry>& cuts() const { return history_.entries(); }
    /// The present surface; shared between calls while nothing changes.
    std::shared_ptr<const WallPicture> picture();
    const mesh::CutSession& session() const { return session_; }
    /// Time of the last step of the knife (ms): the cut alone, without the picture.
    double step_ms() const { return step_ms_; }

    static constexpr double kStepMm = 5.0;

private:
    struct Stroke;
    struct HookStep {
        std::size_t cuts = 0; ///< number of cuts in force at the step
        std::string what; ///< for the surgeon
        std::string moved; ///< what was moved; empty: hooks were set or taken off
        HookSet before, after;
    };
    void add_cut(CutEntry entry);
    HookSet hook_set() const { return hooks_ != nullptr ? hooks_->hook_set() : HookSet {}; }
    template <class Change> auto hook_step(const std::string& what, const std::string& moved, const Change& change);
    void return_hooks_to(const HookSet& then);
    void give_hooks_back(const HookSet& before);
    const HookStep* hook_step_to_undo() const;
    const HookStep* hook_step_to_redo() const;
    std::string hook_name(fem::HookId hook) const;
    std::string moved_name(fem::HookId hook) const;
    KnifeAnswer attach_retractor(const Touch& at, const RetractorKind& kind);
    KnifeAnswer attach_hook(const Touch& at);
    KnifeAnswer attach_planned_hooks();
    std::optional<mesh::Piece> free_piece_at(const Touch& at, std::string& why_not) const;
    std::string leave_out_what_stays(std::vector<TetId>& marked) const;
    KnifeAnswer cut_to(std::vector<Vec3> points, std::vector<Vec3> directions);
    KnifeAnswer make_strokes(const Approach& divided, const std::set<StrokeWay>& made);
    bool is_skeleton_label(Label label) const;
    /// Supports that returned with undone removal of tissue.
    struct Returned {
        std::vector<VertexId> held;
        bool unknown_to_hooks = false; ///< the supports were absent when the hooks' solver was made
    };
    void follow(const mesh::MeshDelta& delta);
    Returned take_in(const mesh::MeshDelta& delta);
    std::vector<VertexId> held_vertices() const;
    std::unique_ptr<fem::SpringNetwork> make_springs(double strain) const;
    void renew_springs(const std::string& why);
    void drop_tension(const std::string& why);
    void lie_as(const Points& displacement);
    void start_moving();
    std::vector<Mat3> tension_stresses(double strain) const;
    std::vector<fem::Hinge> present_hinges() const;
    void make_hooks(std::span<const HookPlacement> placements);
    void renew_hooks();
    bool is_held(const HookPlacement& placement) const;
    Vec3 present_place(const HookPlacement& placement);
    void join_planned_blades();
    void drop_hooks(const std::string& why);
    void hooks_taken_off();
    void take_hooks_off();
    KnifeAnswer attach(std::vector<HookPlacement> placements, const std::vector<std::string>& names,
        const std::vector<fem::HookDrive>& drives, bool planned, std::string omitted);
    template <class Call> void with_hooks(const Call& call);
    template <class Call> void change_hooks(const Call& change);
    void show_hooks();
    bool has_planned_cut() const;
    bool is_cut_as_planned() const;
    void match_forces();
    bool has_hook(fem::HookId hook) const;
    std::shared_ptr<const WallSurface> make_surface() const;

    mesh::LabelTable labels_;
    std::vector<fem::Material> materials_;
    Vec3 outward_;
    std::shared_ptr<const mesh::TetMesh> first_; ///< the wall before any cut, which the tension is defined on
    Job job_;
    std::vector<Label> skeleton_;
    mesh::CutSession session_;
    CutHistory history_;
    std::shared_ptr<Stroke> stroke_; ///< null: no open stroke
    mesh::SurfaceFollower follower_;
    Points rest_; ///< of the session's vertices, by id
    std::shared_ptr<const WallSurface> surface_; ///< null: must be made
    std::shared_ptr<const WallPicture> picture_; ///< null: must be made
    WallRegion region_;
    std::vector<VertexId> cut_off_; ///< of the wall before any cut: held vertices, or vertices of its rim
    std::vector<char> held_; ///< per vertex of the session
    std::vector<std::pair<VertexId, VertexId>> parted_; ///< pairs of vertices that a cut separated
    struct Ablated {
        char held = 0;
        double bed = 0.0;
        int hooks_made = 0; ///< value of hooks_made_ at the removal
        std::vector<std::pair<VertexId, VertexId>> parted;
    };
    mesh::AblatedValues<Ablated> ablated_;
    double tension_ = 0.0;
    std::unique_ptr<fem::SpringNetwork> springs_; ///< null: not needed yet, or there are hooks
    std::vector<double> bed_; ///< per vertex of the session, N/mm; 0: no bed
    std::vector<fem::Hinge> hinges_; ///< of the wall before any cut
    std::set<VertexId> hinge_nodes_; ///< all nodes of hinges_
    Approach approach_;
    std::function<void(Approach&)> find_division_; ///< empty: none
    std::unique_ptr<WoundHooks> hooks_; ///< null: no hooks
    std::optional<PlannedForce> planned_force_;
    /// By force_match(), of the last time that the wound was as planned: of the linear and of the nonlinear answer.
    std::array<std::optional<double>, 2> force_factors_ {};
    bool nonlinear_ = false;
    int hooks_made_ = 0; ///< number of solvers made for hooks
    double yield_N_ = std::numeric_limits<double>::infinity();
    int hooks_placed_ = 0, retractors_placed_ = 0; ///< by hand, for their names
    std::vector<HookStep> hook_steps_; ///< the oldest first
    std::size_t hook_steps_made_ = 0; ///< the others are undone
    HookSet before_cut_; ///< hooks before the cut that is being made
    std::vector<HookSet> hooks_before_cut_; ///< of each cut that was made here, by its place in the history
    double iterations_per_ms_ = 1.0; ///< measured speed of the relaxation
    double reach_mm_ = 0.0; ///< distance from the wound within which tissue moves now
    int still_frames_ = 0;
    bool moving_ = false;
    double step_ms_ = 0.0;
    std::string remark_;
};

} // namespace retractor::planner
