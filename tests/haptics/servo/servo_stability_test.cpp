// A hand in numbers against virtual walls: passive up to the bound, kept so beyond it, quiet when it presses at rest.

#include "haptics/device/simulated_hand.h"
#include "haptics/servo/servo.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace retractor::haptics {
namespace servo_stability_test {

    constexpr double kStep = 1e-3;

    struct Press {
        HandParameters grip = relaxed_grip();
        double wall = 0.2; ///< N/mm
        double own_damping = 5e-4; ///< N s/mm
        bool watched = true;
        bool limited = true; ///< the coupling knows what the device can do
        double resolution = 0.055;
        double seconds = 4.0;
    };
    struct Feel {
        double vibration_n = 0.0; ///< rms about the mean, in the last second
        double force_n = 0.0; ///< mean, in the last second
        double swing_mm = 0.0; ///< of the true tip, in the last second
        double energy = 0.0; ///< least that the controller saw
        std::uint64_t damped_ticks = 0;
    };

    /// Comes down quickly, presses, holds still.
    Feel feel(const Press& press)
    {
        SimulatedHandOptions options;
        options.hand = press.grip;
        options.stylus_damping = press.own_damping;
        options.path = HandPath({ { 0.0, Vec3(0.0, 5.0, 0.0) }, { 0.15, Vec3(0.0, -5.0, 0.0) } });
        DeviceInfo info { .name = "hand" };
        info.limits.resolution = press.resolution;
        if (!press.limited)
            info.limits.max_stiffness = 1e3;
        SimulatedHand hand(options, info);
        test_support::Wall wall(press.wall);
        ServoOptions servo_options;
        servo_options.watch_passivity = press.watched;
        servo_options.passivity.active_power = 0.0; // a wall has no life of its own
        servo_options.faults.ramp_up_s = kStep;
        servo_options.coupling.within_limits = press.limited;
        if (!press.limited)
            servo_options.coupling.damping_share = 0.0;
        Servo servo({ { .device = &hand } }, wall, servo_options);
        const auto ticks = static_cast<std::uint64_t>(std::lround(press.seconds / kStep));
        const std::uint64_t last_second = ticks - 1000;
        Feel feel;
        double sum = 0.0, sum2 = 0.0, low = 1e9, high = -1e9;
        for (std::uint64_t i = 0; i < ticks; ++i) {
            run_ticks(servo, 1, kStep, i);
            feel.energy = std::min(feel.energy, servo.passivity(0).energy());
            if (i < last_second)
                continue;
            const double force = hand.motor_force().y();
            sum += force;
            sum2 += force * force;
            low = std::min(low, hand.true_position().y());
            high = std::max(high, hand.true_position().y());
        }
        feel.force_n = sum / 1000.0;
        feel.vibration_n = std::sqrt(std::max(0.0, sum2 / 1000.0 - feel.force_n * feel.force_n));
        feel.swing_mm = high - low;
        feel.damped_ticks = servo.passivity(0).damped_ticks();
        return feel;
    }

    TEST(ServoStability, WallsUpToTheBoundStayPassiveWithoutHelp)
    {
        const double bound
            = passive_stiffness({ .own_damping = 5e-4, .delay_ticks = 1 }, kStep); // 0.33 N/mm with one tick of delay
        for (const HandParameters& grip : { relaxed_grip(), firm_grip() })
            for (const double share : { 0.1, 0.5, 0.9, 1.0 }) {
                const Feel f = feel({ .grip = grip, .wall = share * bound });
                EXPECT_EQ(f.damped_ticks, 0u) << share;
                EXPECT_GT(f.energy, -0.05) << share;
                EXPECT_GT(f.force_n, 0.05) << share;
            }
    }

    TEST(ServoStability, BeyondTheBoundTheObserverKeepsThemSo)
    {
        // Rendered as it is, a wall ten times stiffer than the bound shakes the hand off; watched, it comes to rest.
        constexpr double kWall = 3.5;
        for (const HandParameters& grip : { relaxed_grip(), firm_grip() }) {
            const Feel wild = feel({ .grip = grip, .wall = kWall, .watched = false, .limited = false });
            const Feel watched = feel({ .grip = grip, .wall = kWall, .watched = true, .limited = false });
            std::printf(
                "wall %.1f N/mm: unwatched swing %.3f mm, %.3f N rms; watched %.3f mm, %.3f N rms, %llu ticks damped\n",
                kWall, wild.swing_mm, wild.vibration_n, watched.swing_mm, watched.vibration_n,
                static_cast<unsigned long long>(watched.damped_ticks));
            EXPECT_GT(wild.vibration_n, 0.1);
            EXPECT_LT(watched.vibration_n, 0.1 * wild.vibration_n);
            EXPECT_GT(watched.force_n, 0.05) << "it is still a wall";
            EXPECT_GT(watched.damped_ticks, 0u);
        }
    }

    TEST(ServoStability, TheCouplingKeepsEveryWallWithinTheDevicesReach)
    {
        for (const double wall : { 1.0, 10.0, 1000.0 }) {
            const Feel f = feel({ .wall = wall });
            EXPECT_EQ(f.damped_ticks, 0u) << wall;
            EXPECT_GT(f.force_n, 0.2) << wall;
        }
    }

    TEST(ServoStability, PressingAtRestIsQuiet)
    {
        constexpr double kQuiet = 0.01; // N rms
        for (const HandParameters& grip : { relaxed_grip(), firm_grip() })
            for (const double wall : { 0.05, 0.15, 0.3, 1.0, 20.0 }) {
                const Feel f = feel({ .grip = grip, .wall = wall });
                std::printf("wall %6.2f N/mm: %.3f N, %.5f N rms\n", wall, f.force_n, f.vibration_n);
                EXPECT_LE(f.vibration_n, kQuiet) << wall;
                EXPECT_GT(f.force_n, 0.05);
            }
    }

} // namespace servo_stability_test
} // namespace retractor::haptics
