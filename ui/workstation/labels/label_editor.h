#pragma once
// Corrects the labels of the open case in the window: reads them on its own thread, gives the mouse to the brush, and
// asks for names. The window writes the corrected labels.

#include "mesh/base/error.h"
#include "mesh/base/serial_executor.h"
#include "planner/case/label_session.h"
#include "ui/workstation/labels/label_panel.h"
#include "ui/workstation/labels/label_tool.h"

#include <QObject>
#include <QTimer>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class QWidget;

namespace retractor::ui {

class LabelEditor : public QObject {
public:
    using ReadLabels = std::function<std::shared_ptr<const mesh::LabelVolume>()>;

    /// @pre view and panel outlive the editor; the window, which owns the dialogs, too
    LabelEditor(PictureView& view, LabelPanel& panel, QWidget& window);

    /// Corrections of the case before are dropped. @param read empty: there are no labels to correct
    void set_case(planner::Case planned_case, ReadLabels read);
    /// Gives the mouse to the brush, or back; reads the labels at the first time.
    void set_active(bool active);
    bool active() const { return active_; }
    bool changed() const { return session_ && session_->changed(); }
    bool idle() const { return working_ == 0; }
    /// Null: they are not read yet.
    const planner::LabelSession* session() const { return session_.get(); }
    void undo();
    void redo();
    /// Says so where corrections of an earlier window can be made again.
    void mention_unsaved();
    /// The corrections are lost as the user wants: nothing is offered again.
    void forget_unsaved();

    // Set by the owner.
    std::function<planner::Case()> present_case; ///< the case with its present approaches
    std::function<void()> on_labels; ///< the labels to show are others
    /// The case and its labels are to be written.
    std::function<void(planner::Case, std::shared_ptr<const mesh::LabelVolume>)> on_save;
    std::function<void(const Vec3&)> on_place; ///< a place to show, mm LPS
    std::function<void(const QString&)> on_message;
    std::function<void(const Failure&)> on_failure;

private:
    void act(LabelPanel::Action action);
    /// The labels are others: shows them, and soon keeps what is not saved.
    void note_change();
    /// Writes what is not saved beside the case, so that a crash does not lose it.
    void keep_unsaved();
    void offer_unsaved(const std::vector<planner::LabelStep>& steps);
    void edit_whole(const planner::LabelSession::MakeEdit& make);
    void add_label();
    void save();
    void read_labels();
    LabelBrushState brush_state() const;
    void show_state();
    void show_chosen();
    /// Calls `change`; a refusal is shown.
    void attempt(const std::function<void(planner::LabelSession&)>& change);
    std::optional<std::string> ask_for_label(
        const QString& title, const QString& question, const std::string& not_this);
    std::optional<std::string> ask_for_name(const QString& title, const QString& question, const std::string& proposed);
    /// Runs `make` on the executor and what it returns in the window's thread, unless another case was opened.
    void work(std::function<std::function<void()>()> make);

    PictureView& view_;
    LabelPanel& panel_;
    QWidget& window_;
    LabelTool tool_;
    planner::Case case_;
    ReadLabels read_;
    std::unique_ptr<planner::LabelSession> session_;
    bool active_ = false, reading_ = false;
    bool busy_ = false; ///< a whole label is being edited
    bool asking_ = false; ///< whether to make unsaved corrections again
    QString waiting_; ///< why there is no session
    QTimer keep_timer_;
    std::filesystem::path unsaved_; ///< file of corrections that are not saved; empty: the case is on no disk
    std::uint32_t labels_sum_ = 0; ///< of the labels that the session began with
    int generation_ = 0; ///< number of the case
    int working_ = 0;
    SerialExecutor executor_ { { .when_destroyed = WaitingTasks::run } }; ///< declared last: its tasks use the others
};

} // namespace retractor::ui
