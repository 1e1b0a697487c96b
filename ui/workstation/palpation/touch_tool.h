#pragma once
// The mouse as a hand. Over the tissue it carries a fingertip just above it; the left button presses it in, straight
// into the tissue where it is, and dragging slides it along; the wheel presses deeper or less. Another finger can be
// taken at any time: the one before stays where it is, pressing if it pressed, so that two of them pinch.

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
    /// The view must outlive the tool.
    explicit TouchTool(PictureView& view);
    ~TouchTool() override;

    /// Null: nothing is touched. The worker must be taken away before it ends.
    void touch(planner::PalpationWorker* worker, std::size_t fingers, double radius);
    /// What the eye's rays meet: the tissue at rest.
    void set_surface(std::shared_ptr<const TriMesh> surface);

    void set_depth(double mm); ///< of the finger in hand
    double depth() const { return depth_; }
    double deepest() const { return 3.0 * radius_; }
    void take_finger(std::size_t finger); ///< nothing when there are not so many
    std::size_t finger() const { return finger_; }
    /// All fingers leave the tissue.
    void lift_all();
    /// The finger lies on the tissue or above it.
    bool is_out(std::size_t finger) const { return hands_[finger].at.has_value(); }
    const std::optional<planner::SurfacePlace>& place(std::size_t finger) const { return hands_[finger].at; }

    /// The next press says where instead of touching.
    void ask_for_place(std::function<void(const planner::SurfacePlace&)> answer) { asked_ = std::move(answer); }

    // Set by the owner.
    std::function<void()> on_change; ///< depth, finger in hand, or a finger came or went
    std::function<void(const std::string&)> on_refused;

private:
    struct Hand {
        std::optional<planner::SurfacePlace> at; ///< where it is aimed, on the surface at rest
        bool pressed = false;
        double depth = 0.0; ///< mm, when it was pressed last
    };

    void press(const QPointF& at) override;
    void move(const QPointF& at, bool held) override;
    void release(const QPointF& at) override;
    bool wheel(double notches) override;

    std::optional<planner::SurfacePlace> under(const QPointF& at) const;
    void put(std::size_t finger, bool hops);
    void changed() const;

    PictureView& view_;
    planner::PalpationWorker* worker_ = nullptr;
    std::shared_ptr<const TriMesh> surface_;
    Points normals_;
    Vec3 away_ = Vec3::Zero(); ///< where fingers are that touch nothing
    std::array<Hand, planner::kMostFingers> hands_;
    std::size_t fingers_ = 0, finger_ = 0;
    double radius_ = 4.0, depth_ = 1.5;
    bool held_ = false; ///< the left button is down
    std::function<void(const planner::SurfacePlace&)> asked_;
};

} // namespace retractor::ui
