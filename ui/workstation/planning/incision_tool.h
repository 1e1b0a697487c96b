#pragma once
// Draws an incision on the picture of the closed patient, and moves its points, with the mouse. A click adds a point, a
// drag over the skin adds a line, a drag of a point moves it.

#include "ui/scene/vtk/live_surface.h"
#include "ui/workstation/view/picture_view.h"

#include <QElapsedTimer>

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace retractor::ui {

class IncisionTool : private PictureTool {
public:
    using SkinUnder = std::function<std::optional<Vec3>(const Vec3&, const Vec3&)>;

    /// @pre the view outlives the tool
    explicit IncisionTool(PictureView& view);
    ~IncisionTool() override;

    /// Takes the mouse. @param points of an incision to move, on the skin; empty: an incision is drawn
    /// @param skin_under see ClosedPictures::skin_under @pre one scene in space is shown
    void begin(std::vector<Vec3> points, SkinUnder skin_under);
    /// Gives the mouse back and removes what was drawn.
    void end();
    bool active() const { return skin_under_ != nullptr; }
    /// The points so far, in cutting order, mm LPS.
    const std::vector<Vec3>& points() const { return points_; }
    /// Takes the last change of the points back. @return false when there is none
    bool undo();
    bool can_undo() const { return !undo_.empty(); }
    /// While frozen, points neither come nor move.
    void freeze(bool frozen) { frozen_ = frozen; }
    bool frozen() const { return frozen_; }

    // Set by the owner.
    std::function<void()> on_change; ///< the points have changed
    std::function<void()> on_finish; ///< a double click ends the drawing
    std::function<void(const QString&)> on_refusal; ///< why a click did nothing

private:
    struct Props : LiveProps {
        LiveSurface handles, line;
        [[nodiscard]] std::vector<vtkProp*> props() const override;
    };

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;

    std::optional<Vec3> skin_at(const QPointF& at) const;
    std::optional<std::size_t> handle_at(const QPointF& at) const;
    void keep_for_undo();
    void follow(const QPointF& at);
    void end_freehand();
    /// The line over the skin from one point to the next, as the eye sees it now.
    std::vector<Vec3> over_skin(const Vec3& from, const Vec3& to) const;
    void lay_line(std::size_t first, std::size_t last);
    void show();

    PictureView& view_;
    SkinUnder skin_under_;
    Props drawn_;
    std::vector<Vec3> points_;
    std::vector<std::vector<Vec3>> lines_; ///< over the skin, between neighbouring points
    std::vector<std::vector<Vec3>> undo_; ///< the points before each change
    bool frozen_ = false;
    bool moving_ = false; ///< the points of an existing incision are moved; clicks add none
    std::optional<std::size_t> held_; ///< the point that is dragged
    std::vector<Vec3> freehand_; ///< the skin under the mouse since the button went down
    QPointF pressed_at_;
    QElapsedTimer pressed_; ///< since the last press
};

} // namespace retractor::ui
