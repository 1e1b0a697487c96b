#pragma once
// Adds, changes and removes the approaches of the open case: asks what is wanted, draws and moves incisions, has the
// approach made on its own thread, and puts it into the model.

#include "mesh/base/error.h"
#include "mesh/base/serial_executor.h"
#include "ui/workstation/planning/incision_tool.h"
#include "ui/workstation/planning/planning_backend.h"

#include <QObject>
#include <QPointer>

#include <functional>
#include <memory>
#include <vector>

class QWidget;

namespace retractor::ui {

class ApproachDialog;

class ApproachEditor : public QObject {
public:
    /// @pre the view outlives the editor; the window, which owns the dialogs, too
    ApproachEditor(PictureView& view, QWidget& window);

    /// Edits this model from now on. Null: no case is open. @pre the model outlives the editor or the next call
    void set_case(SessionModel* model, PlanningBackend backend);

    void add_from_template();
    /// Takes the mouse for a new incision, or gives it back. @pre draw_possible()
    void draw();
    /// Takes the mouse for the points of the selected approach. @pre draw_possible(), an approach is selected
    void move_points();
    /// Ends the drawing: asks for the rest of a new approach, or puts the moved incision into the model.
    void finish();
    /// Gives the mouse back; the points are lost. @return false when nothing was being drawn
    bool abandon();
    /// Takes the last point back. @return false when there is none
    bool undo_point() { return tool_.undo(); }
    void change_opening();
    /// Gives the selected approach a blade of another depth and direction at the middle of the incision.
    void change_blade(double depth_mm, const Vec3& inward);
    /// Asks what is done where the slices meet, and makes this site the target. @pre slices are shown
    void choose_site();
    void duplicate();
    /// Adds a copy of the selected approach that is opened by a retractor as it was cranked by hand.
    /// @param at between its blades, at rest
    void add_with_retractor(const std::string& kind, double opening_mm, const Vec3& at);
    /// Adds the same approach one space higher and lower, and 20 mm along (planner::neighbours_of()).
    void add_neighbours();
    void remove();

    bool drawing() const { return tool_.active(); }
    bool moving() const { return tool_.active() && moving_; }
    /// Whether the closed patient is known well enough to be drawn on.
    bool draw_possible() const;
    bool idle() const { return working_ == 0; }
    IncisionTool& tool() { return tool_; }

    // Set by the owner.
    std::function<void()> on_edit; ///< the model has other approaches
    std::function<void()> on_state; ///< drawing began or ended, or work did
    std::function<void(const QString&)> on_message; ///< what to do next, or what was done
    std::function<void(const Failure&)> on_failure;
    std::function<void(WallLook)> on_wall_look; ///< shows the patient's wall so

private:
    using Make = std::function<planner::Approach()>;

    void ask(ApproachDialog* dialog, std::function<Make(const planner::ApproachDraft&)> make,
        std::function<void(planner::Approach)> take);
    /// Calls `make` on the executor; then one of the other two is called in the window's thread.
    template <class Result>
    void work(
        std::function<Result()> make, std::function<void(Result)> take, std::function<void(const Failure&)> refuse);
    void begin(std::vector<Vec3> points, const QString& message);
    void end_drawing();
    void finish_moving();
    void changed(const QString& message);
    void say_what_to_do();

    PictureView& view_;
    QWidget& window_;
    SessionModel* model_ = nullptr;
    PlanningBackend backend_;
    IncisionTool tool_;
    bool moving_ = false; ///< the tool moves the points of an existing incision
    std::size_t moved_id_ = 0; ///< id of the approach whose points are moved
    std::vector<Vec3> moved_from_ {}; ///< the points before they were moved
    int drawings_ = 0; ///< number of drawings begun and ended; what was made for an older one is dropped
    bool opened_before_ = true; ///< whether the opened field was shown before the drawing
    bool made_see_through_ = false; ///< the wall was solid before the drawing, and shows the ribs during it
    QPointer<ApproachDialog> dialog_; ///< the open dialog
    int generation_ = 0; ///< number of the case; approaches for an older case are dropped
    int working_ = 0;
    SerialExecutor executor_; ///< declared last: its tasks use the other members
};

} // namespace retractor::ui
