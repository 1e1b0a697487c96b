#include "planner/session/retractor/rack_balance.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    constexpr double kProbeMm = 0.5; ///< first step, while nothing is known of the tissue
    constexpr double kFarthestStepMm = 10.0;
    constexpr double kNoForceN = 0.05; ///< below, there is nothing to balance
    constexpr double kSmallestMm = 1e-6; ///< of a step that tells something of the tissue

} // namespace

void RackBalance::open(double from_mm, double to_mm)
{
    constexpr double kLeastMm = 1.0; // narrower, the proportion says nothing
    if (from_mm > kLeastMm)
        shift_mm_ *= to_mm / from_mm;
    last_.reset();
}

bool RackBalance::step(double first_N, double second_N)
{
    const double difference = first_N - second_N;
    const double larger = std::max(std::abs(first_N), std::abs(second_N));
    if (!std::isfinite(difference) || larger < kNoForceN || std::abs(difference) <= kTolerance * larger)
        return false;
    if (last_ && std::abs(shift_mm_ - last_->first) > kSmallestMm) {
        const double slope = (difference - last_->second) / (shift_mm_ - last_->first);
        if (slope > 0.0) // pushed towards one lip, the rack meets more of its force
            slope_N_per_mm_ = slope;
    }
    last_ = { shift_mm_, difference };
    const double towards_balance = difference > 0.0 ? -1.0 : 1.0;
    shift_mm_ += slope_N_per_mm_ > 0.0 ? std::clamp(-difference / slope_N_per_mm_, -kFarthestStepMm, kFarthestStepMm)
                                       : towards_balance * kProbeMm;
    return true;
}

} // namespace retractor::planner
