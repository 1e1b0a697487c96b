#pragma once
// The knife in the window: mouse strokes on the picture become commands, and the snapshots that come back are
// drawn.

#include "planner/session/knife_worker.h"
#include "planner/session/surgery_command.h"
#include "ui/scene/vtk/live_surface.h"
#include "ui/workstation/cutting/knife_panel.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/view/picture_view.h"

#include <QObject>

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
    take_out, ///< press on a piece that was cut free, or on tissue, takes it out
    hooks, ///< press on a wound's edge sets a hook; press on a hook and draw it
};

class KnifeTool : public QObject, private PictureTool {
public:
    /// View and panel must outlive the tool.
    KnifeTool(PictureView& view, KnifePanel& panel);
    /// Finishes a stroke that is open.
    ~KnifeTool() override;

    /// Lays the table out for an approach, if that was not done yet, and shows it.
    void lay_out(std::size_t approach, std::function<KnifeTable(const Job&)> prepare);
    /// No table is shown; those that were laid out are kept with their cuts.
    void leave();
    /// Another case: all tables go.
    void clear();

    void set_mode(KnifeMode mode);
    KnifeMode mode() const { return mode_; }
    /// Takes the stroke under way back; false when there is none.
    bool abandon();
    /// Gives the table that is shown a command; nothing when none is. While a stroke is drawn nothing is undone or
    /// redone.
    void run(planner::surgery::Command command);

    /// Of the table that is shown; null: none is, or it is not ready.
    std::shared_ptr<const Scene> scene() const;
    /// Of the table that is shown; null: none is. Valid until the window's next event.
    const planner::SessionSnapshot* snapshot() const;
    /// What a table is waited for, in words; empty: nothing.
    QString waiting_for() const;
    /// Nothing is being prepared or cut.
    bool idle() const;

    // Set by the owner.
    std::function<void()> on_change; ///< phase, cuts or what can be undone changed
    /// What the surgeon should know, and whether it is a refusal; nothing: what was said is over.
    std::function<void(const std::string&, bool refused)> on_answer;

private:
    struct Table {
        std::unique_ptr<planner::KnifeWorker> worker;
        std::shared_ptr<const planner::SessionSnapshot> snapshot; ///< the newest that was taken
        /// Filled by the worker's thread before a snapshot says that the table is ready; read only then.
        std::shared_ptr<Scene> surroundings;
    };

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;

    void say(const std::string& text, bool refused) const;
    Table* shown();
    const Table* shown() const;
    void take_snapshot(std::size_t approach);
    void show_picture();
    void show_beyond();
    void show_line();
    /// What the knife touches there; says why when it is nothing that can be cut.
    std::optional<planner::Touch> feel(const QPointF& at, std::string& why_not) const;
    /// The same for a stroke that has begun, whatever hides the wall.
    std::optional<planner::Touch> feel_wall(const QPointF& at) const;
    void draw_between(const QPointF& from, const QPointF& to);
    void set_first(const QPointF& at);
    void cut_straight(const QPointF& to);
    void end_stroke();
    void take_out(const QPointF& at);
    void take_hook(const QPointF& at);
    /// The hook whose steel, or the tissue that it holds, is seen there; null: none.
    const planner::HookState* hook_under(const planner::Ray& ray, const std::optional<planner::Touch>& touched) const;
    Vec3 in_hand(const QPointF& at) const;
    void drag_hook(const QPointF& to);
    void show_steel();

    PictureView& view_;
    KnifePanel& panel_;
    /// What is drawn of a table: the wall, and the body beyond it.
    struct Props : LiveProps {
        LiveSurface wall, beyond;
        [[nodiscard]] std::vector<vtkProp*> props() const override;
    };
    Props drawn_;
    std::shared_ptr<const planner::WallSurface> drawn_surface_; ///< what drawn_.wall was made of
    TriMesh beyond_; ///< as shown
    std::map<std::size_t, Table> tables_;
    std::optional<std::size_t> shown_;
    KnifeMode mode_ = KnifeMode::away;
    bool drawing_ = false; ///< a stroke was begun with the button that is still held
    std::size_t stroke_ = 0; ///< number of the stroke that was begun last
    QPointF last_; ///< where the mouse was
    std::optional<QPointF> first_; ///< line mode: the first click
    struct Grip {
        fem::HookId hook = 0;
        Vec3 centre = Vec3::Zero(); ///< of its patch when it was taken, as shown
        Vec3 asked = Vec3::Zero(); ///< how far it was drawn then, mm from rest
        Vec3 from = Vec3::Zero(); ///< where the hand took it
    };
    std::optional<Grip> grip_; ///< the hook that is being drawn
    std::vector<Vec3> line_; ///< the stroke drawn so far, as shown, mm
    std::size_t answers_ = 0;
    bool case_tension_offered_ = false; ///< by the panel, for the case that is open
};

} // namespace retractor::ui
