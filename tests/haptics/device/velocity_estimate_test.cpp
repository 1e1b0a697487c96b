#include "haptics/device/velocity_estimate.h"

#include "haptics/device/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::haptics {
namespace velocity_estimate_test {

    constexpr double kStep = 1e-3, kResolution = 0.055;

    TEST(VelocityEstimate, IsExactOnAStraightLineAndZeroAtRest)
    {
        constexpr double kRounding = 1e-9;
        VelocityEstimate estimate(kResolution);
        const Vec3 speed(120.0, -3.0, 0.0);
        Vec3 answer = Vec3::Zero();
        for (int i = 0; i < 200; ++i)
            answer = estimate.update(i * kStep * speed, kStep);
        EXPECT_NEAR((answer - speed).norm(), 0.0, kRounding);
    }

    TEST(VelocityEstimate, DoesNotHearTheNoiseOfOneQuantum)
    {
        VelocityEstimate estimate(kResolution);
        double loudest = 0.0, of_differences = 0.0;
        Vec3 last = Vec3::Zero();
        for (int i = 0; i < 500; ++i) {
            const Vec3 position(kResolution * ((i * 7919) % 2), 0.0, 0.0); // to and fro between two quanta
            const double speed = estimate.update(position, kStep).norm();
            if (i > 50) {
                loudest = std::max(loudest, speed);
                of_differences = std::max(of_differences, (position - last).norm() / kStep);
            }
            last = position;
        }
        EXPECT_DOUBLE_EQ(of_differences, kResolution / kStep);
        EXPECT_LT(loudest, kResolution / (20 * kStep)) << "the longest window averages over more than twenty ticks";
    }

    TEST(VelocityEstimate, FollowsAQuantisedSwing)
    {
        VelocityEstimate estimate(kResolution);
        constexpr double kAmplitude = 10.0, kOmega = 2.0 * std::numbers::pi * 3.0;
        double worst = 0.0;
        for (int i = 0; i < 2000; ++i) {
            const double t = i * kStep;
            const Vec3 truth(kAmplitude * std::sin(kOmega * t), 0.0, 0.0);
            const double speed = estimate.update(quantised(truth, kResolution), kStep).x();
            if (i > 50)
                worst = std::max(worst, std::abs(speed - kAmplitude * kOmega * std::cos(kOmega * t)));
        }
        // Plain differences are wrong by up to 55 mm/s of 188.
        EXPECT_LT(worst, 0.15 * kAmplitude * kOmega);
    }

    TEST(VelocityEstimate, NoTimeChangesNothing)
    {
        VelocityEstimate estimate(kResolution);
        estimate.update(Vec3::Zero(), kStep);
        const Vec3 before = estimate.update(Vec3(1.0, 0.0, 0.0), kStep);
        EXPECT_EQ(estimate.update(Vec3(9.0, 0.0, 0.0), 0.0), before);
        EXPECT_EQ(estimate.update(Vec3(9.0, 0.0, 0.0), NAN), before);
    }

} // namespace velocity_estimate_test
} // namespace retractor::haptics
