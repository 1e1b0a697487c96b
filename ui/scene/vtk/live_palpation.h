#pragma once
// The moving parts of a palpation: the tissue's surface or the spheres inside it, fingertips, hands, and the box or
// sphere that marks an edit of elasticity. Units mm.

#include "ui/scene/vtk/live_surface.h"

#include <array>
#include <span>

namespace retractor::ui {

struct ShownBall {
    Vec3 centre = Vec3::Zero();
    double radius = 1.0;
    Color color {};
};

/// A round rod that begins at its tip and tapers towards it.
struct ShownRod {
    Vec3 tip = Vec3::Zero(), outward = Vec3::UnitZ(); ///< outward: unit
    double tip_radius = 1.0, radius = 1.0, taper = 1.0, length = 1.0; ///< mm
    Color color {};
};

class LivePalpation : public LiveProps {
public:
    LivePalpation();
    ~LivePalpation() override;
    LivePalpation(const LivePalpation&) = delete;
    LivePalpation& operator=(const LivePalpation&) = delete;

    [[nodiscard]] LiveSurface& surface() noexcept;
    /// Balls inside the tissue; none: nothing is shown.
    void set_spheres(std::span<const ShownBall> spheres);
    void set_fingertips(std::span<const ShownBall> tips);
    static constexpr std::size_t kHands = 2;
    /// The hand in its own frame; place_hand() shows it. @pre hand < kHands, here and below
    void set_hand(std::size_t hand, const TriMesh& mesh);
    void place_hand(std::size_t hand, const Mat3& turn, const Vec3& shift);
    void hide_hand(std::size_t hand);
    /// Straight fingers behind the fingertips; none: nothing is shown.
    void set_fingers(std::span<const ShownRod> fingers);
    /// Separate pieces of line over everything; none: nothing is shown.
    void set_marks(const std::vector<std::array<Vec3, 2>>& pieces, const Color& color);

    [[nodiscard]] std::vector<vtkProp*> props() const override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
