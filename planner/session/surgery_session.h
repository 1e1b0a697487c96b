#pragma once
// The knife on a patient's wall, without a window: strokes drawn on the skin become cuts, cuts are taken back and made
// again, and under tension the wound gapes: springs on the edges pull it open while the knife moves. Hooks open wounds
// further, and hold them open while the knife goes on: the wall is then solved (WoundHooks), tension and all, and there
// are no springs. Used from one thread. Units mm; frame patient LPS.

#include "fem/material/material.h"
#include "mesh/cutting/ablated_values.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/pieces.h"
#include "mesh/cutting/surface_follower.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/session/wall_picture.h"
#include "planner/session/wall_region.h"
#include "planner/session/wound_hooks.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
class SpringNetwork;
}

namespace retractor::planner {

/// What the knife is laid out for: one approach's wall.
struct SurgerySetup {
    mesh::TetMesh wall; ///< four nodes per element, at rest
    /// Vertices of the wall that do not move. Springs know no softer support: a bed (Supports::bedded) is left free.
    std::vector<VertexId> held;
    /// Of faces where the wall was cut off (cut_off_vertices() of planner/supports.h), whether they move or not:
    /// tension takes no skin there.
    std::vector<VertexId> cut_off {};
    std::vector<fem::BeddedVertex> bedded {}; ///< what hooks pull against besides; springs leave it out
    Approach approach {}; ///< its hooks are the planned ones
    mesh::LabelTable labels;
    /// By label; what is not of the wall may be left out. Hooks solve four-node elements: as those can have them
    /// (as_solved() of planner/opened_wound.h), or nearly incompressible tissue locks.
    std::vector<fem::Material> materials;
    Vec3 outward = -Vec3::UnitY(); ///< out of the body, for tissue that lies under no skin
    WallRegion region {}; ///< where there is a wall to cut
    std::shared_ptr<const TriMesh> beyond {}; ///< drawn, not cut, and goes along with the wall's rim; null: nothing
    std::filesystem::path journal; ///< where cuts are kept on disk; empty: they are not
    std::string caution {}; ///< what the surgeon should know of it, said once it is laid out; may be empty
};

struct KnifeSettings {
    double depth_mm = 15.0;
    bool through_wall = false; ///< as deep as the wall is thick near the first point; depth_mm is then not used
    bool cuts_bone = false; ///< a scalpel does not cut bone and cartilage; a saw does
};

/// What became of one thing that was asked for.
struct [[nodiscard]] KnifeAnswer {
    bool done = false; ///< else nothing was changed
    std::string reason; ///< why not; or, when done, what the surgeon should know; may be empty
};

/// A finished cut, or tissue that was taken out; in force or taken back.
struct CutEntry {
    int number = 0; ///< from 1, in the order of cutting
    std::string taken_out {}; ///< the name of the tissue that was taken out (of several, most of it); empty: a cut
    bool several_tissues = false; ///< taken out with it
    double length_mm = 0.0, depth_mm = 0.0;
    mesh::CutReport report {};
    bool in_force = true;
    std::string
        reduction_error {}; ///< why a part of the line (of the ball) is not cut (taken out); empty: all of it is
    /// From disk, where lengths and reports are not kept: of the report only lip_area_mm2 and removed_volume_mm3 are
    /// known.
    bool restored = false;
};

struct LipsOfCut;

class SurgerySession {
public:
    /// Without a journal, whatever the table says. Records the part "cutting session".
    /// @throws InputError as CutSession does.
    explicit SurgerySession(SurgerySetup table, const Job& job = {});
    /// On a session of the table's wall that has these cuts already: one delta per cut, in order; no stroke is open.
    SurgerySession(
        SurgerySetup table, mesh::CutSession session, const std::vector<mesh::MeshDelta>& cuts, const Job& job = {});
    ~SurgerySession();
    SurgerySession(SurgerySession&&) noexcept;
    SurgerySession& operator=(SurgerySession&&) noexcept;

    /// Sets the knife on the skin. Refused: beyond what can be cut (WallRegion), in a wound, on bare bone that the
    /// knife does not cut, no far side of the wall to cut through to.
    /// @throws InputError when the depth is not positive and finite; a stroke is open.
    KnifeAnswer begin_stroke(const Touch& at, const KnifeSettings& settings);
    /// Draws on; cuts once per kStepMm. What cannot be cut (a line that turns back on itself, crosses itself) is left
    /// out of the line and said; so is a step that the session refuses (SolverError).
    /// @throws InputError when no stroke is open; what the session's witness throws: nothing was drawn.
    KnifeAnswer draw_to(const Touch& at);
    /// The knife is drawn where there is no wall: the stroke goes on where it comes back, or ends here, which
    /// finish_stroke() says. @throws InputError when no stroke is open.
    void leave_wall();
    /// Cuts up to the last point, or to the last that could be cut. Refused when nothing was cut, and when the session
    /// cannot finish the stroke: it is then taken back.
    /// @throws InputError when no stroke is open; what the session's witness throws: the stroke is still open, and may
    /// be finished again or abandoned.
    KnifeAnswer finish_stroke();
    /// Takes an open stroke back as if it had never been; does nothing when there is none.
    /// @throws what the session's witness throws: the stroke is still open.
    void abandon_stroke();
    bool stroke_open() const { return stroke_ != nullptr; }

    /// Takes tissue out for good, as one cut to undo: the piece that was cut free where the place lies (radius 0), or
    /// the tissue of that kind within a ball round it (element by element: its border is as fine as the mesh). Elements
    /// of a ball that are held, or lie where the knife cannot cut (WallRegion), are left out, which is said; a piece
    /// with such elements is refused. Refused too: a stroke is open, nothing was cut free there, nothing or everything
    /// would be taken.
    /// @throws InputError when the radius is negative or not finite; what the session's witness throws.
    KnifeAnswer take_out(const Touch& at, double radius_mm);

    bool can_undo() const { return !stroke_open() && session_.can_undo(); }
    bool can_redo() const { return !stroke_open() && session_.can_redo(); }
    /// @throws InputError when there is nothing to undo (redo) or a stroke is open.
    void undo();
    void redo();

    /// The strain that the wall's tissue is under. Where its materials have pre-strains (the case's tension), those in
    /// proportion, so that the largest has this size; else all soft tissue, alike in all directions of the skin's
    /// plane, and bone and cartilage are under none. 0: wounds stay closed, and there are no springs. The springs are
    /// made when they are first needed (part "springs"). They are not calibrated on the wall: spring_calibration()
    /// would factorise it as a plan does, for a factor of 1.01 to 1.03 on their stiffness, so that wounds gape 1 to 3 %
    /// too wide.
    /// @throws InputError when it is negative, NaN or beyond kLargestPreStrain, or when springs cannot be made: the
    /// tension is then as it was.
    void set_tension(double strain);
    double tension() const { return tension_; }
    /// The largest pre-strain of the materials: the tension at which a wound gapes as in a plan. 0: they have none.
    double case_tension() const;
    /// Lets the wound open for about this long (under hooks: until it is at rest, or the job is cancelled); the rest
    /// comes with the next calls. Does nothing when !moving().
    void relax(double milliseconds, const Job& job = {});
    /// The wound has not come to rest: it still moves by what an eye sees.
    bool moving() const { return moving_; }
    /// The widest wound, between places that were one, mm; 0: closed.
    double gape_mm() const;

    /// Sets a hook on the edge of the wound near by; it holds the lip where it lies. The first makes the solver (part
    /// "online opening"). Refused in words where there is no hold, while a stroke is open, and when the wall is not
    /// held.
    KnifeAnswer place_hook(const Touch& at);
    /// The approach's hooks, driven as it says: so far, by a force, up to a limit, with a soft grip. Those that find no
    /// lip to hold are left out and named.
    KnifeAnswer take_planned_hooks();
    std::size_t planned_hooks() const { return approach_.hooks.size(); }
    /// Where the hand draws a hook to, mm from rest; nothing when it is no longer there.
    void pull_hook(fem::HookId hook, const Vec3& asked);
    void pull_all_hooks(double mm); ///< each away from the other lip
    void pull_hooks_by_share(double share); ///< of their plan, as WoundHooks::pull_share()
    /// Hooks slip rather than pull harder (N); infinite: only at their own limits. @throws InputError when it is not
    /// positive.
    void set_yield(double force_N);
    /// Whether wounds that hooks open are nonlinear near by (WoundHooks); not at first.
    void set_nonlinear(bool wanted);
    void take_off_hook(fem::HookId hook); ///< nothing when it is no longer there
    void take_off_hooks();
    /// Empty without hooks.
    HookReport hooks() const { return hooks_ != nullptr ? hooks_->report() : HookReport {}; }
    /// A hook was moved and its numbers are not settled, or the nonlinear answer is to come; relax() does that.
    bool hooks_unsettled() const { return hooks_ != nullptr && !hooks_->settled(); }
    /// relax() would change nothing yet: the nonlinear answer is being made.
    bool waiting() const { return hooks_ != nullptr && hooks_->waits(stroke_open()); }
    /// What the surgeon should know of the springs since the last call, e.g. that they failed and the tension is off;
    /// empty: nothing.
    std::string take_remark() { return std::exchange(remark_, {}); }

    /// All cuts that can be undone or redone, in order.
    const std::vector<CutEntry>& cuts() const { return cuts_; }
    /// The surface as it is now; shared between calls while nothing changes.
    std::shared_ptr<const WallPicture> picture();
    const mesh::CutSession& session() const { return session_; }
    /// How long the last step of the knife took (ms): the cut itself, without the picture.
    double step_ms() const { return step_ms_; }

    static constexpr double kStepMm = 5.0;

private:
    struct Stroke;
    std::optional<mesh::Piece> free_piece_at(const Touch& at, std::string& why_not) const;
    std::string leave_out_what_stays(std::vector<TetId>& marked) const;
    KnifeAnswer cut_to(std::vector<Vec3> points, std::vector<Vec3> directions);
    bool is_skeleton_label(Label label) const;
    /// Supports that an undone ablation brought back.
    struct Returned {
        std::vector<VertexId> held;
        bool unknown_to_hooks = false; ///< they were gone before the hooks' solver was made
    };
    void follow(const mesh::MeshDelta& delta);
    Returned take_in(const mesh::MeshDelta& delta);
    CutEntry restored_entry(
        int number, const mesh::MeshDelta& delta, const LipsOfCut& lips, const std::function<void()>& take) const;
    std::unique_ptr<fem::SpringNetwork> make_springs(double strain) const;
    void renew_springs(const std::string& why);
    void drop_tension(const std::string& why);
    void lie_as(const Points& displacement);
    void start_moving();
    std::vector<Mat3> tension_stresses(double strain) const;
    void make_hooks(std::span<const HookPlacement> seats);
    void renew_hooks();
    void drop_hooks(const std::string& why);
    void hooks_taken_off();
    KnifeAnswer attach(std::vector<HookPlacement> seats, const std::vector<std::string>& names,
        const std::vector<fem::HookDrive>& drives, bool planned, std::string reduction_error);
    template <class Call> void with_hooks(const Call& call);
    std::shared_ptr<const WallSurface> make_surface() const;

    mesh::LabelTable labels_;
    std::vector<fem::Material> materials_;
    Vec3 outward_;
    std::shared_ptr<const mesh::TetMesh> first_; ///< the wall before any cut: what the tension is told by
    Job job_;
    std::vector<Label> skeleton_;
    mesh::CutSession session_;
    std::vector<CutEntry> cuts_;
    std::shared_ptr<Stroke> stroke_; ///< null: none is open
    mesh::SurfaceFollower follower_;
    Points rest_; ///< of the session's vertices, by id
    std::shared_ptr<const WallSurface> surface_; ///< null: to be made
    std::shared_ptr<const WallPicture> picture_; ///< null: to be made
    WallRegion region_;
    std::vector<VertexId> cut_off_; ///< of the wall before any cut: held, or of its rim
    std::vector<char> held_; ///< per vertex of the session
    std::vector<std::pair<VertexId, VertexId>> parted_; ///< vertices that were one
    struct Ablated {
        char held = 0;
        double bed = 0.0;
        int hooks_made = 0; ///< when it was taken
        std::vector<std::pair<VertexId, VertexId>> parted;
    };
    mesh::AblatedValues<Ablated> ablated_;
    double tension_ = 0.0;
    std::unique_ptr<fem::SpringNetwork> springs_; ///< null: not needed yet, or there are hooks
    std::vector<double> bed_; ///< per vertex of the session, N/mm; 0: it lies on none
    Approach approach_;
    std::unique_ptr<WoundHooks> hooks_; ///< null: there are none
    bool nonlinear_ = false;
    int hooks_made_ = 0; ///< how often a solver was made for them
    double yield_N_ = std::numeric_limits<double>::infinity();
    int hooks_placed_ = 0; ///< for their names
    double iterations_per_ms_ = 1.0; ///< of the relaxation, as measured
    double reach_mm_ = 0.0; ///< round the wound, of what moves now
    int still_frames_ = 0;
    bool moving_ = false;
    double step_ms_ = 0.0;
    std::string remark_;
};

} // namespace retractor::planner
