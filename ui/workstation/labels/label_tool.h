#pragma once
// Paints, erases and fills labels on the slices with the mouse. A drag is one step of the history.

#include "planner/case/label_session.h"
#include "ui/workstation/view/picture_view.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace retractor::ui {

enum class LabelBrush { paint, erase, fill };

/// What the mouse does.
struct LabelBrushState {
    LabelBrush brush = LabelBrush::paint;
    Label label = 0; ///< that is painted, erased or filled in
    double radius_mm = 4.0;
    bool ball = false; ///< a ball in place of a disc in the slice
    bool keeps_bone = true; ///< bone and cartilage are not painted over, unless bone is painted
};

/// Labels that the brush does not paint over.
mesh::LabelFlags kept_by(const LabelBrushState& state, const mesh::LabelTable& table);

class LabelTool : public PictureTool {
public:
    /// @pre the view outlives the tool
    explicit LabelTool(PictureView& view)
        : view_(view)
    {
    }
    /// Edits this session from now on; null: none. @pre the session outlives the tool or the next call
    void set_session(planner::LabelSession* session) { session_ = session; }
    void set_state(const LabelBrushState& state) { state_ = state; }

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;

    // Set by the owner.
    std::function<void()> on_edit; ///< the labels changed
    std::function<void(const QString&)> on_refusal;
    std::function<void(std::size_t)> on_unlabelled; ///< number of voxels that an erased stroke left without a label
    std::function<void(double)> on_size; ///< the brush is to look this large (pixels across) where the mouse is

private:
    datasets::LabelEdit edit_of(const mesh::LabelVolume& labels) const;
    void stroke_to(const Vec3& place);
    void show_size(const QPointF& at);

    PictureView& view_;
    planner::LabelSession* session_ = nullptr;
    LabelBrushState state_;
    std::vector<Vec3> path_; ///< of the stroke that the left button draws
    Vec3 normal_ = Vec3::UnitZ(); ///< of the slice on which it was begun
    bool began_ = false; ///< the stroke has changed a voxel
};

} // namespace retractor::ui
