#pragma once
// The knife in the window: turns mouse strokes on the picture into commands of a surgery session, and draws the
// session's snapshots.

#include "planner/session/surgery_command.h"
#include "planner/session/surgery_worker.h"
#include "ui/scene/vtk/live_surface.h"
#include "ui/workstation/cutting/knife_panel.h"
#include "ui/workstation/cutting/sight_watch.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/view/picture_view.h"

#include <QElapsedTimer>
#include <QObject>
#include <QTimer>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace retractor::ui {

enum class KnifeMode {
    away, ///< the mouse turns the camera
    freehand, ///< press, draw, release
    line, ///< a straight cut between two clicks
    take_out, ///< a press removes a loose piece, or tissue round the place
    hooks, ///< a press on a wound's edge sets a hook; a press on a hook drags the hook
};

class KnifeTool : public QObject, private PictureTool {
public:
    /// @pre view and panel outlive the tool
    KnifeTool(PictureView& view, KnifePanel& panel);
    /// Finishes an open stroke.
    ~KnifeTool() override;

    /// Starts the session of an approach, if there is none yet, and shows it.
    /// @param approach SessionModel::id()
    void set_up(std::size_t approach, std::function<SurgeryInput(const Job&)> prepare);
    /// Tells the session of an approach, if there is one, what the plan says of the force of its retractor; nothing: it
    /// says no force.
    void set_planned_force(std::size_t approach, const std::optional<planner::PlannedForce>& force);
    /// Shows no session. Existing sessions stay, with their cuts.
    void leave();
    /// Ends the sessions of all other approaches, whose incisions are no longer there. One that works goes on, because
    /// its end would be waited for.
    void keep_only(const std::vector<std::size_t>& approaches);
    /// Ends all sessions, for another case.
    void clear();

    void set_mode(KnifeMode mode);
    KnifeMode mode() const { return mode_; }
    /// Takes back the present stroke. @return false when there is none
    bool abandon();
    /// Gives the session that is shown a command; nothing without such a session. While a stroke is drawn nothing is
    /// undone or redone.
    void run(planner::surgery::Command command);

    /// The scene of the shown session; null when none is shown or the session is not ready.
    std::shared_ptr<const Scene> scene() const;
    /// The snapshot of the shown session; null when none is shown. Valid until the window's next event.
    const planner::SurgerySnapshot* snapshot() const;
    /// Why cuts of a session are not on the disk; empty: all are.
    std::string cuts_not_saved() const;
    /// Whether there are such cuts, which are lost when the window is closed.
    bool would_lose_cuts() const;
    /// Tries again to save them.
    void save_cuts();
    /// The work for which a session waits, in words; empty: none.
    QString waiting_for() const;
    /// Whether nothing is being prepared or cut.
    bool idle() const;

    // Set by the owner.
    std::function<void()> on_change; ///< called when the phase, the cuts, or undo and redo change
    /// Called with a message for the surgeon, and whether it is a refusal; an empty message clears the last one.
    std::function<void(const std::string&, bool refused)> on_answer;

private:
    struct Session {
        std::unique_ptr<planner::SurgeryWorker> worker;
        std::shared_ptr<const planner::SurgerySnapshot> snapshot; ///< the newest snapshot
        /// Filled by the worker's thread before a snapshot reports the session as ready; read only after that.
        std::shared_ptr<Scene> surroundings;
        std::shared_ptr<SightWatch::Look> look; ///< filled with the surroundings
        /// What the session was told of its plan; the outer one is empty before.
        std::optional<std::optional<planner::PlannedForce>> planned_force;
    };

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;
    bool wheel(const QPointF& at, double notches) override;

    void say(const std::string& text, bool refused) const;
    Session* shown();
    const Session* shown() const;
    void take_snapshot(std::size_t approach);
    void show_picture();
    void show_beyond();
    void show_line();
    bool wall_is_shown() const;
    std::string why_no_wall() const; ///< why it is not shown
    /// The place that the knife touches, or the reason why nothing there can be cut.
    std::optional<planner::Touch> feel(const QPointF& at, std::string& why_not) const;
    /// The place on the wall for the rest of a stroke, even where something hides the wall.
    std::optional<planner::Touch> feel_wall(const QPointF& at) const;
    void draw_between(const QPointF& from, const QPointF& to);
    void set_first(const QPointF& at);
    void cut_straight(const QPointF& to);
    void end_stroke();
    void take_out(const QPointF& at);
    void take_hook(const QPointF& at);
    /// The hook whose steel or tissue is seen along the ray; null: none.
    const planner::HookState* hook_under(const planner::Ray& ray, const std::optional<planner::Touch>& touched) const;
    Vec3 in_hand(const QPointF& at) const;
    void drag_hook(const QPointF& to);
    void show_steel();
    void watch_sight();

    PictureView& view_;
    KnifePanel& panel_;
    /// The drawn parts of a session: the wall, and the body outside it.
    struct Props : LiveProps {
        LiveSurface wall, beyond;
        [[nodiscard]] std::vector<vtkProp*> props() const override;
    };
    Props drawn_;
    std::shared_ptr<const planner::WallSurface> drawn_surface_; ///< surface from which drawn_.wall was made
    TriMesh steel_; ///< hooks, blades and racks as they are drawn
    TriMesh beyond_; ///< the body outside the wall, as shown
    std::map<std::size_t, Session> sessions_;
    std::optional<std::size_t> shown_;
    KnifeMode mode_ = KnifeMode::away;
    bool drawing_ = false; ///< a stroke is open, and its button is down
    std::size_t stroke_ = 0; ///< number of the last stroke
    QPointF last_; ///< last position of the mouse
    std::optional<QPointF> first_; ///< line mode: the first click
    struct Grip {
        fem::HookId hook = 0;
        Vec3 centre = Vec3::Zero(); ///< shown centre of the patch when the hook was taken
        Vec3 asked = Vec3::Zero(); ///< prescribed displacement at this time, mm from rest
        Vec3 from = Vec3::Zero(); ///< place where the mouse took the hook
    };
    std::optional<Grip> grip_; ///< the hook that is being dragged
    struct Cranked {
        fem::HookId blade = 0;
        double opening_mm = 0.0;
        QElapsedTimer since {}; ///< the last notch
    };
    Cranked cranked_; ///< the retractor that the wheel opens
    std::vector<Vec3> line_; ///< shown points of the present stroke, mm
    std::size_t answers_ = 0;
    QTimer age_timer_; ///< what is seen grows older
    SightWatch sight_;
    bool case_tension_offered_ = false; ///< the panel offers the tension of the open case
};

} // namespace retractor::ui
