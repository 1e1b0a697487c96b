#include "haptics/servo/finger_coupling.h"

#include "tests/support/test_help.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

namespace retractor::haptics {
namespace finger_coupling_test {

    constexpr double kStep = 1e-3;

    /// Presses a wall to `depth` and holds still; the force once it has settled.
    Vec3 held_force(FingerCoupling& coupling, double wall_stiffness, const Vec3& at)
    {
        test_support::Wall wall(wall_stiffness);
        Fingertip finger { .position = at };
        FingerContact contact;
        Vec3 force = Vec3::Zero();
        for (int i = 0; i < 50; ++i) {
            const Fingertip asked = coupling.asked(finger);
            wall.tick(i * kStep, kStep, { &asked, 1 }, { &contact, 1 });
            force = coupling.force(finger, contact, kStep);
        }
        return force;
    }

    TEST(FingerCoupling, SoftTissueIsFeltAsItIs)
    {
        FingerCoupling coupling({}, DeviceLimits {}, kStep, 1.0);
        EXPECT_NEAR((held_force(coupling, 0.3, Vec3(5.0, -2.0, 1.0)) - Vec3(0.0, 0.6, 0.0)).norm(), 0.0, 1e-12);
    }

    TEST(FingerCoupling, TissueStifferThanTheDeviceIsFeltAsStiffAsItCan)
    {
        const DeviceLimits limits;
        for (const double stiffness : { 1.5, 20.0, 1e6 }) {
            FingerCoupling coupling({}, limits, kStep, 1.0);
            EXPECT_NEAR(held_force(coupling, stiffness, Vec3(0.0, -2.0, 0.0)).y(), 2.0 * limits.max_stiffness, 1e-6)
                << stiffness;
        }
    }

    TEST(FingerCoupling, OfTheFirstMomentOfATouchToo)
    {
        const DeviceLimits limits;
        FingerCoupling coupling({ .damping_share = 0.0 }, limits, kStep, 1.0);
        test_support::Wall wall(20.0);
        Fingertip finger { .position = Vec3(0.0, -0.5, 0.0) };
        FingerContact contact;
        wall.tick(0.0, kStep, { &finger, 1 }, { &contact, 1 });
        EXPECT_NEAR(coupling.force(finger, contact, kStep).y(), 0.5 * limits.max_stiffness, 1e-12);
    }

    TEST(FingerCoupling, DampsTheWayInAndNeverPullsOnTheWayOut)
    {
        const DeviceLimits limits;
        for (const double speed : { -50.0, 50.0, 5000.0 }) {
            FingerCoupling coupling({}, limits, kStep, 1.0);
            test_support::Wall wall(0.3);
            Fingertip finger { .position = Vec3(0.0, -1.0, 0.0), .velocity = Vec3(0.0, speed, 0.0) };
            FingerContact contact;
            wall.tick(0.0, kStep, { &finger, 1 }, { &contact, 1 });
            const double expected = std::max(0.0, 0.3 - 0.9 * limits.max_damping * speed);
            EXPECT_NEAR(coupling.force(finger, contact, kStep).y(), expected, 1e-12);
        }
    }

    TEST(FingerCoupling, RefusesSharesBeyondTheRange)
    {
        const auto message = [](const CouplingOptions& options) {
            return test_support::message_of([&] { FingerCoupling(options, DeviceLimits {}, kStep, 1.0); });
        };
        EXPECT_EQ(
            message({ .damping_share = 1.5 }), "damping_share: a share of the device's range lies between 0 and 1");
        EXPECT_EQ(
            message({ .damping_share = NAN }), "damping_share: a share of the device's range lies between 0 and 1");
    }

} // namespace finger_coupling_test
} // namespace retractor::haptics
