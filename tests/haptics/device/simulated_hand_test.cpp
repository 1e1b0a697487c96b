#include "haptics/device/simulated_hand.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::haptics {
namespace simulated_hand_test {

    constexpr double kStep = 1e-3;

    SimulatedHandOptions pressing_down(double by_mm)
    {
        SimulatedHandOptions options;
        options.path = HandPath({ { 0.0, Vec3::Zero() }, { 0.2, Vec3(0.0, -by_mm, 0.0) } });
        return options;
    }

    /// Runs for `seconds` against a constant force.
    DeviceReading run(SimulatedHand& hand, double seconds, const Vec3& force, int first_tick = 0)
    {
        DeviceReading reading;
        const int ticks = static_cast<int>(std::lround(seconds / kStep));
        for (int i = first_tick; i < first_tick + ticks; ++i) {
            reading = hand.read(i * kStep, kStep);
            hand.write(force);
        }
        return reading;
    }

    TEST(SimulatedHand, GoesWhereItsPersonMeansToBe)
    {
        constexpr double kSettled = 0.01; // mm, after three seconds
        for (const HandParameters& grip : { relaxed_grip(), firm_grip() }) {
            SimulatedHandOptions options = pressing_down(12.3);
            options.hand = grip;
            SimulatedHand hand(options);
            const DeviceReading reading = run(hand, 3.0, Vec3::Zero());
            EXPECT_NEAR((hand.true_position() - Vec3(0.0, -12.3, 0.0)).norm(), 0.0, kSettled);
            EXPECT_EQ(reading.position, quantised(hand.true_position(), 0.055));
            EXPECT_LT(reading.velocity.norm(), 1e-9);
        }
    }

    TEST(SimulatedHand, GoesOnThroughAPauseBetweenTicks)
    {
        constexpr double kSettled = 0.05; // mm
        for (const double pause : { 1.5, 60.0 }) {
            SimulatedHand hand(pressing_down(12.3));
            hand.read(0.0, kStep);
            hand.write(Vec3::Zero());
            hand.read(pause, pause);
            EXPECT_NEAR((hand.true_position() - Vec3(0.0, -12.3, 0.0)).norm(), 0.0, kSettled) << pause << " s";
        }
        // A path that begins late in the pause is followed as well.
        SimulatedHandOptions late;
        late.path = HandPath({ { 58.0, Vec3::Zero() }, { 58.2, Vec3(0.0, -12.3, 0.0) } });
        SimulatedHand hand(late);
        hand.read(60.0, 60.0);
        EXPECT_NEAR(hand.true_position().y(), -12.3, kSettled);
    }

    TEST(SimulatedHand, YieldsToAForceLikeItsSpringsInARow)
    {
        constexpr double kSettled = 0.01; // mm
        const Vec3 force(0.3, 0.5, -0.4);
        for (const HandParameters& grip : { relaxed_grip(), firm_grip() }) {
            SimulatedHandOptions options;
            options.hand = grip;
            SimulatedHand hand(options);
            run(hand, 4.0, force);
            const Vec3 expected = force.cwiseQuotient(grip.grip_stiffness) + force.cwiseQuotient(grip.arm_stiffness);
            EXPECT_NEAR((hand.true_position() - expected).norm(), 0.0, kSettled);
        }
        EXPECT_GT(firm_grip().grip_stiffness.minCoeff(), relaxed_grip().grip_stiffness.maxCoeff());
    }

    TEST(SimulatedHand, ItsStylusFallsFreelyAtFirst)
    {
        // One tick: x = f t^2 / 2 m, before the grip has felt anything.
        SimulatedHandOptions options;
        options.delay_ticks = 0;
        SimulatedHand hand(options);
        hand.read(0.0, kStep);
        const double force = 1.0;
        hand.write(Vec3(force, 0.0, 0.0));
        hand.read(kStep, kStep);
        const double expected = 0.5 * force * kStep * kStep / options.stylus_mass;
        constexpr double kSubsteps = 0.08; // of the semi-implicit step, 1/20, and of the grip's damping
        EXPECT_NEAR(hand.true_position().x(), expected, kSubsteps * expected);
    }

    TEST(SimulatedHand, TheForceArrivesLateAndLimited)
    {
        for (const std::size_t delay : { 0u, 1u, 3u }) {
            SimulatedHandOptions options;
            options.delay_ticks = delay;
            SimulatedHand hand(options);
            hand.read(0.0, kStep);
            EXPECT_NEAR(hand.write(Vec3(0.0, 9.0, 0.0)).norm(), 3.3, 1e-12);
            for (std::size_t i = 1; i <= delay + 1; ++i) {
                EXPECT_EQ(hand.motor_force().norm(), 0.0) << "delay " << delay;
                hand.read(static_cast<double>(i) * kStep, kStep);
                hand.write(Vec3::Zero());
            }
            EXPECT_NEAR(hand.motor_force().y(), 3.3, 1e-12) << "delay " << delay;
        }
    }

    TEST(SimulatedHand, DoesTheSameEveryTime)
    {
        const auto positions = [] {
            SimulatedHand hand(pressing_down(5.0));
            std::vector<Vec3> all;
            for (int i = 0; i < 1000; ++i) {
                all.push_back(hand.read(i * kStep, kStep).position);
                hand.write(Vec3(0.0, std::max(0.0, -0.4 * all.back().y()), 0.0));
            }
            return all;
        };
        EXPECT_EQ(positions(), positions());
    }

    TEST(SimulatedHand, LeftAloneItComesToRest)
    {
        // Nobody pushes: whatever it started with, stylus and arm only lose energy.
        SimulatedHandOptions options;
        options.path = HandPath({ { 0.0, Vec3::Zero() } });
        SimulatedHand hand(options);
        run(hand, 0.05, Vec3(2.0, 0.0, 0.0));
        double swing = 0.0, later = 0.0;
        for (int i = 50; i < 3050; ++i) {
            hand.read(i * kStep, kStep);
            hand.write(Vec3::Zero());
            (i < 1550 ? swing : later) = std::max(i < 1550 ? swing : later, hand.true_velocity().norm());
        }
        EXPECT_GT(swing, 10.0);
        EXPECT_LT(later, 1e-2 * swing);
    }

    TEST(SimulatedHand, DryFrictionHoldsItWhereAWeakForceCannotMoveIt)
    {
        SimulatedHandOptions options;
        options.friction = 0.26;
        SimulatedHand hand(options);
        run(hand, 0.5, Vec3(0.2, 0.0, 0.0));
        EXPECT_EQ(hand.true_position(), Vec3::Zero());
        run(hand, 0.5, Vec3(0.4, 0.0, 0.0), 500);
        EXPECT_GT(hand.true_position().x(), 0.1);
    }

    TEST(SimulatedHand, ANotANumberNeverReachesItsMotors)
    {
        SimulatedHand hand(SimulatedHandOptions {});
        EXPECT_EQ(hand.write(Vec3(NAN, 0.0, 0.0)), Vec3::Zero());
    }

    TEST(SimulatedHand, RefusesImpossibleParameters)
    {
        const auto message = [](auto change) {
            SimulatedHandOptions options;
            change(options);
            return test_support::message_of([&] { SimulatedHand hand(options); });
        };
        EXPECT_EQ(message([](auto& o) { o.hand.mass.y() = 0.0; }), "mass: a hand's parameters must be positive");
        EXPECT_EQ(message([](auto& o) { o.stylus_mass = NAN; }), "stylus_mass: a hand's parameters must be positive");
        EXPECT_EQ(message([](auto& o) { o.friction = -1.0; }), "friction: must not be negative");
        EXPECT_EQ(message([](auto& o) { o.delay_ticks = 9; }), "delay_ticks: the delay is longer than 8 ticks");
        EXPECT_EQ(message([](auto& o) { o.substeps = 0; }), "substeps: at least one step a tick is needed");
    }

} // namespace simulated_hand_test
} // namespace retractor::haptics
