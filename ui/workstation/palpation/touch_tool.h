#pragma once
// The mouse as a hand. Over the tissue the mouse carries a fingertip just above the surface. The left button presses
// the fingertip straight into the tissue, dragging slides it, and the wheel changes the depth. Another finger can be
// taken at any time: the last finger stays in its place, pressed or not, so that two fingers pinch.

#include "planner/session/palpation_worker.h"
#include "planner/session/touched_surface.h"
#include "ui/workstation/view/picture_view.h"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace retractor::ui {

class TouchTool : private PictureTool {
public:
    /// @pre the view outlives the tool
    explicit TouchTool(PictureView& view);
    ~TouchTool() override;

    /// Connects the tool to a worker; null: nothing is touched. Disconnect a worker before it ends.
    void touch(planner::PalpationWorker* worker, std::size_t fingers, double radius);
    /// The surface that the rays of the eye meet: the tissue at rest.
    void set_surface(std::shared_ptr<const TriMesh> surface);

    void set_depth(double mm); ///< sets the depth of the finger in hand
    double depth() const { return depth_; }
    double deepest() const { return 3.0 * radius_; }
    void take_finger(std::size_t finger); ///< does nothing when there is no such finger
    std::size_t finger() const { return finger_; }
    /// All fingers leave the tissue.
    void lift_all();
    /// Whether the finger lies on or above the tissue.
    bool is_out(std::size_t finger) const { return hands_[finger].at.has_value(); }
    const std::optional<planner::SurfacePlace>& place(std::size_t finger) const { return hands_[finger].at; }

    /// The next press reports its place instead of touching.
    void ask_for_place(std::function<void(const planner::SurfacePlace&)> answer) { asked_ = std::move(answer); }

    // Set by the owner.
    std::function<void()> on_change; ///< called when the depth, the finger in hand or the presence of a finger changes
    std::function<void(const std::string&)> on_refused;

private:
    struct Hand {
        std::optional<planner::SurfacePlace> at; ///< place on the surface at rest at which the finger is aimed
        bool pressed = false;
        double depth = 0.0; ///< depth of the last press, mm
    };

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;
    bool wheel(const QPointF& at, double notches) override;

    std::optional<planner::SurfacePlace> under(const QPointF& at) const;
    void put(std::size_t finger, bool hops);
    void changed() const;

    PictureView& view_;
    planner::PalpationWorker* worker_ = nullptr;
    std::shared_ptr<const TriMesh> surface_;
    Points normals_;
    Vec3 away_ = Vec3::Zero(); ///< place of fingers that touch nothing
    std::array<Hand, planner::kMostFingers> hands_;
    std::size_t fingers_ = 0, finger_ = 0;
    double radius_ = 4.0, depth_ = 1.5;
    bool held_ = false; ///< the left button is down
    std::function<void(const planner::SurfacePlace&)> asked_;
};

} // namespace retractor::ui
