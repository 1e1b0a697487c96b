#include "haptics/device/velocity_estimate.h"

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

double VelocityEstimate::axis_velocity(int axis) const noexcept
{
    double velocity = 0.0;
    const double end = back(0).position[axis];
    for (std::size_t length = 1; length < count_; ++length) {
        const double span = back(0).time - back(length).time;
        const double slope = (end - back(length).position[axis]) / span;
        for (std::size_t i = 1; i < length; ++i) {
            const double line = end - slope * (back(0).time - back(i).time);
            if (std::abs(back(i).position[axis] - line) > resolution_)
                return velocity;
        }
        velocity = slope;
    }
    return velocity;
}

Vec3 VelocityEstimate::update(const Vec3& position, double step_s) noexcept
{
    if (count_ > 0 && !(step_s > 0.0))
        return velocity_;
    time_ = count_ == 0 ? 0.0 : time_ + step_s;
    newest_ = (newest_ + 1) % kWindow;
    ring_[newest_] = { position, time_ };
    count_ = std::min(count_ + 1, kWindow);
    for (int axis = 0; axis < 3; ++axis)
        velocity_[axis] = axis_velocity(axis);
    return velocity_;
}

} // namespace retractor::haptics
