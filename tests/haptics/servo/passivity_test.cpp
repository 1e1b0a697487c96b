#include "haptics/servo/passivity.h"

#include "haptics/device/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace retractor::haptics {
namespace passivity_test {

    constexpr double kStep = 1e-3;

    TEST(Passivity, TheBoundIsColgatesAndGrowsWithDelay)
    {
        EXPECT_DOUBLE_EQ(damping_for_passivity({ 0.4, 1e-4 }, kStep, 0), 0.4 * kStep / 2 + 1e-4);
        EXPECT_DOUBLE_EQ(damping_for_passivity({ 0.4, -1e-4 }, kStep, 2), 0.4 * kStep * 2.5 + 1e-4);
        DeviceLimits limits { .own_damping = 6e-4, .delay_ticks = 1 };
        EXPECT_DOUBLE_EQ(passive_stiffness(limits, kStep), 0.4);
        EXPECT_DOUBLE_EQ(damping_for_passivity({ passive_stiffness(limits, kStep), 0.0 }, kStep, 1), 6e-4);
    }

    TEST(Passivity, ACouplingIsKeptWithinTheDevicesLimits)
    {
        const DeviceLimits unknown; // its own damping is not known
        Coupling c = within_limits({ 50.0, 50.0 }, unknown, kStep);
        EXPECT_EQ(c.stiffness, unknown.max_stiffness);
        EXPECT_EQ(c.damping, unknown.max_damping);
        const DeviceLimits known { .own_damping = 6e-4, .delay_ticks = 1 };
        c = within_limits({ 0.2, 50.0 }, known, kStep);
        EXPECT_DOUBLE_EQ(c.stiffness, 0.2);
        EXPECT_DOUBLE_EQ(c.damping, 3e-4);
        EXPECT_NEAR(damping_for_passivity(c, kStep, 1), 6e-4, 1e-15);
        c = within_limits({ 50.0, 50.0 }, known, kStep);
        EXPECT_DOUBLE_EQ(c.stiffness, 0.4);
        EXPECT_NEAR(c.damping, 0.0, 1e-15);
        // A scene shown five times smaller than the device moves feels five times stiffer.
        c = within_limits({ 50.0, 0.0 }, known, kStep, 5.0);
        EXPECT_DOUBLE_EQ(c.stiffness, 0.08);
    }

    TEST(Passivity, TheObserverCountsWhatAHeldForceGives)
    {
        // A sampled spring pressed in and let out in steps s gives K s^2 per step and way more than it took.
        constexpr double kSpring = 0.5, kMove = 0.1;
        constexpr int kSteps = 20;
        PassivityController watch(DeviceLimits {}, { .allowance = 1e9, .active_power = 0.0 });
        const auto tick = [&](int i) {
            const Vec3 at(0.0, -kMove * i, 0.0);
            watch.control(Vec3(0.0, kSpring * kMove * i, 0.0), at, Vec3::Zero(), kStep, true);
            watch.written(Vec3(0.0, kSpring * kMove * i, 0.0));
        };
        for (int i = 0; i <= kSteps; ++i)
            tick(i);
        const double pressed = watch.energy();
        EXPECT_NEAR(pressed, kSpring * kMove * kMove * kSteps * (kSteps - 1) / 2.0, 1e-12);
        for (int i = kSteps - 1; i >= 0; --i)
            tick(i);
        EXPECT_NEAR(watch.energy(), -kSpring * kMove * kMove * kSteps, 1e-12);
        EXPECT_EQ(watch.damped_ticks(), 0u);
    }

    TEST(Passivity, WhatWentInBeforeTheTouchPaysForNothing)
    {
        PassivityController watch(DeviceLimits {}, { .active_power = 0.0 });
        watch.control(Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), kStep, true);
        watch.written(Vec3(0.0, 1.0, 0.0));
        watch.control(Vec3::Zero(), Vec3(0.0, -5.0, 0.0), Vec3::Zero(), kStep, true);
        watch.written(Vec3::Zero());
        EXPECT_DOUBLE_EQ(watch.energy(), 5.0);
        watch.control(Vec3::Zero(), Vec3(0.0, -5.0, 0.0), Vec3::Zero(), kStep, false);
        EXPECT_DOUBLE_EQ(watch.energy(), 0.0);
    }

    TEST(Passivity, TheControllerTakesWhatIsOwedAndNoMoreThanItMay)
    {
        DeviceLimits limits;
        PassivityController watch(limits, { .allowance = 0.2, .active_power = 0.0 });
        watch.control(Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), kStep, true);
        watch.written(Vec3(0.0, 1.0, 0.0));
        const Vec3 velocity(0.0, 100.0, 0.0);
        // 1 N along 0.11 mm: 0.01 N mm more than half the allowance; at 100 mm/s that is 0.1 N for a tick.
        Vec3 force = watch.control(Vec3::Zero(), Vec3(0.0, 0.11, 0.0), velocity, kStep, true);
        EXPECT_NEAR(force.y(), -0.1, 1e-12);
        EXPECT_EQ(watch.share(), 1.0);
        watch.written(Vec3(0.0, 3.0, 0.0));
        force = watch.control(Vec3(0.0, 1.0, 0.0), Vec3(0.0, 1.11, 0.0), velocity, kStep, true);
        EXPECT_NEAR(force.y(), 0.9 - limits.max_damping * 100.0, 1e-12) << "damping was not enough: softer";
        EXPECT_EQ(watch.damped_ticks(), 2u);
        for (int i = 0; i < 2000; ++i)
            watch.control(Vec3::Zero(), Vec3(0.0, 1.11, 0.0), Vec3::Zero(), kStep, false);
        EXPECT_EQ(watch.share(), 1.0) << "free space hardens it again";
    }

    TEST(Passivity, TheDevicesOwnLossesAreCredited)
    {
        const DeviceLimits limits { .own_damping = 1e-3, .own_friction = 0.1 };
        PassivityController watch(limits, { .active_power = 0.0 });
        watch.control(Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), kStep, true);
        watch.written(Vec3(0.0, 1.0, 0.0));
        watch.control(Vec3::Zero(), Vec3(0.0, 0.02, 0.0), Vec3::Zero(), kStep, true);
        // -1 N x 0.02 mm + 1e-3 x (20 mm/s)^2 x 1 ms + 0.1 N x 0.02 mm
        EXPECT_NEAR(watch.energy(), -0.02 + 0.0004 + 0.002, 1e-12);
    }

    TEST(Passivity, TheTissuesOwnLifeIsAllowedUpToItsPower)
    {
        PassivityController watch(DeviceLimits {}, { .allowance = 1.0, .active_power = 2.0 });
        watch.control(Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), kStep, true);
        watch.written(Vec3(0.0, 1.0, 0.0));
        watch.control(Vec3::Zero(), Vec3(0.0, 0.01, 0.0), Vec3::Zero(), kStep, true);
        EXPECT_NEAR(watch.energy(), -0.01 + 2.0 * kStep, 1e-12);
        for (int i = 0; i < 20; ++i) {
            watch.written(Vec3::Zero());
            watch.control(Vec3::Zero(), Vec3(0.0, 0.01, 0.0), Vec3::Zero(), kStep, true);
        }
        EXPECT_EQ(watch.energy(), 0.0) << "power that is not used is not saved";
    }

} // namespace passivity_test
} // namespace retractor::haptics
