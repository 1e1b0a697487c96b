#include "ui/workstation/view/moving_resolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::ui {

namespace {

    constexpr double kStep = std::numbers::sqrt2; ///< half or twice the pixels
    constexpr double kLeastScale = 0.5; ///< below, one cannot see what turns
    /// Handing the picture to the screen takes about as long again: with 40 ms, 15 pictures a second are left.
    constexpr double kSlowMs = 40.0;
    constexpr double kWantedMs = 25.0;
    constexpr double kQuickMs = 15.0; ///< twice the pixels would still not be slow
    constexpr int kFirst = 2;
    constexpr std::size_t kEnough = 4; ///< drawings whose median counts: one that was held up by others does not

    double median(std::vector<double> values)
    {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    }

} // namespace

void MovingResolution::set_scale(double scale)
{
    scale_ = scale;
    first_ = 0;
    drawings_ms_.clear();
}

bool MovingResolution::begin(double ms)
{
    if (ms <= kSlowMs)
        return false;
    set_scale(std::max(kLeastScale, std::sqrt(kWantedMs / ms)));
    return true;
}

bool MovingResolution::drawn(double ms)
{
    if (first_ < kFirst) {
        ++first_;
        return false;
    }
    drawings_ms_.push_back(ms);
    if (drawings_ms_.size() > kEnough)
        drawings_ms_.erase(drawings_ms_.begin());
    if (drawings_ms_.size() < kEnough || median(drawings_ms_) <= kSlowMs || scale_ <= kLeastScale)
        return false;
    // All of the time is not in the pixels, so this may take another step.
    set_scale(std::max(kLeastScale, scale_ * std::min(1.0 / kStep, std::sqrt(kWantedMs / median(drawings_ms_)))));
    return true;
}

bool MovingResolution::rested()
{
    if (drawings_ms_.size() < kEnough || median(drawings_ms_) >= kQuickMs || scale_ >= 1.0) {
        drawings_ms_.clear();
        return false;
    }
    set_scale(std::min(1.0, scale_ * kStep));
    return true;
}

} // namespace retractor::ui
