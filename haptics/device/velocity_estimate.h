#pragma once
// Velocity from a quantised position: first-order adaptive windowing, end-fit form [Janabi-Sharifi, Hayward, Chen 2000,
// Discrete-time adaptive windowing for velocity estimation, IEEE Trans. Control Systems Technology 8(6)]. The longest
// window in which a straight line explains all positions to within the resolution: no noise at rest, no lag in a turn.

#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>

namespace retractor::haptics {

/// Each axis for itself. Allocates nothing.
class VelocityEstimate {
public:
    /// @param resolution of the position, mm
    explicit VelocityEstimate(double resolution)
        : resolution_(resolution)
    {
    }

    /// @param step_s since the call before; not positive counts as no time: the last answer is repeated
    /// @return mm/s
    Vec3 update(const Vec3& position, double step_s) noexcept;
    void restart() noexcept { count_ = 0; }

private:
    static constexpr std::size_t kWindow = 24; ///< ticks: 1 quantum in 24 ms is 2.3 mm/s at 0.055 mm

    struct Sample {
        Vec3 position;
        double time;
    };
    [[nodiscard]] const Sample& back(std::size_t i) const noexcept { return ring_[(newest_ + kWindow - i) % kWindow]; }
    [[nodiscard]] double axis_velocity(int axis) const noexcept;

    double resolution_;
    double time_ = 0.0;
    std::array<Sample, kWindow> ring_ {};
    std::size_t newest_ = 0, count_ = 0;
    Vec3 velocity_ = Vec3::Zero();
};

} // namespace retractor::haptics
