#pragma once
// Velocity from a quantised position by first-order adaptive windowing, end-fit form (Janabi-Sharifi, Hayward, Chen,
// Discrete-time adaptive windowing for velocity estimation, IEEE Trans. Control Systems Technology 8(6), 2000). The
// window is the longest in which a straight line fits all positions within the resolution. The estimate therefore has
// no noise at rest and no lag in a turn.

#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>

namespace retractor::haptics {

/// Each axis has its own window. Allocates nothing.
class VelocityEstimate {
public:
    /// @param resolution of the position, mm
    explicit VelocityEstimate(double resolution)
        : resolution_(resolution)
    {
    }

    /// @param step_s time since the last call; when not positive, the last estimate is returned
    /// @return mm/s
    Vec3 update(const Vec3& position, double step_s) noexcept;
    void restart() noexcept { count_ = 0; }

private:
    static constexpr std::size_t kWindow = 24; ///< ticks; one quantum of 0.055 mm in 24 ms is 2.3 mm/s

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
