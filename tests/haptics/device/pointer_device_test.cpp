#include "haptics/device/pointer_device.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace retractor::haptics {
namespace pointer_device_test {

    constexpr double kStep = 1e-3;

    TEST(PointerDevice, GlidesToThePointer)
    {
        PointerDevice device;
        const Vec3 target(30.0, -40.0, -5.0);
        device.point_at(target);
        DeviceReading reading;
        double fastest = 0.0;
        for (int i = 0; i < 20; ++i) {
            reading = device.read(i * kStep, kStep);
            fastest = std::max(fastest, reading.velocity.norm());
        }
        // A time constant later it has gone 1 - 1/e of the way.
        EXPECT_NEAR((reading.position - (1.0 - std::exp(-1.0)) * target).norm(), 0.0, 1e-9);
        EXPECT_LE(fastest, target.norm() / 0.02);
        for (int i = 0; i < 1000; ++i)
            reading = device.read(i * kStep, kStep);
        EXPECT_NEAR((reading.position - target).norm(), 0.0, 1e-9);
        EXPECT_EQ(device.write(Vec3(0.0, 3.0, 0.0)), Vec3::Zero());
    }

    TEST(PointerDevice, GoesToAPlaceInSpaceAndHopsThereAtRest)
    {
        PointerDevice device({ .workspace = { Vec3::Constant(-500.0), Vec3::Constant(500.0) } });
        const Vec3 place(300.0, -200.0, 100.0);
        device.hop_to(place);
        Vec3 last = Vec3::Zero();
        int ticks = 0;
        for (DeviceReading reading; (last - place).norm() > 1e-9 && ticks < 100; ++ticks) {
            reading = device.read(ticks * kStep, kStep);
            EXPECT_LE((reading.position - last).norm(), PointerDevice::kHop + 1e-9);
            EXPECT_EQ(reading.velocity, Vec3::Zero());
            last = reading.position;
        }
        EXPECT_EQ(ticks, static_cast<int>(std::ceil(place.norm() / PointerDevice::kHop)));
        device.point_at(Vec3(0.0, NAN, 0.0));
        EXPECT_EQ(device.read(0.0, kStep).position, place);
        device.point_at(Vec3(299.0, -200.0, 100.0));
        EXPECT_LT(device.read(0.0, kStep).velocity.x(), 0.0) << "it glides";
    }

    TEST(PointerDevice, HopsBeforeItGlidesToWhatComesAfterTheHop)
    {
        PointerDevice device;
        const Vec3 above(190.0, 0.0, 10.0), pressed(190.0, 0.0, -2.0);
        device.hop_to(above); // all in one event, before a tick
        device.point_at(pressed);
        int hops = 0;
        DeviceReading reading;
        do {
            reading = device.read(hops * kStep, kStep);
            EXPECT_EQ(reading.velocity, Vec3::Zero());
        } while (++hops < 100 && reading.position != above);
        EXPECT_EQ(hops, 3) << "190 mm, 80 mm in a tick";
        for (int i = 0; i < 500; ++i) {
            reading = device.read(i * kStep, kStep);
            EXPECT_EQ(reading.position.x(), above.x()) << "straight down, nothing is swept";
            EXPECT_LE(reading.position.z(), above.z());
        }
        EXPECT_NEAR((reading.position - pressed).norm(), 0.0, 1e-9);
    }

    TEST(PointerDevice, StaysInItsWorkspaceAndHearsNoNonsense)
    {
        PointerDevice device({ .workspace = { Vec3::Constant(-10.0), Vec3::Constant(10.0) } });
        device.point_at(Vec3(1e9, 3.0, 0.0));
        device.point_at(Vec3(NAN, 0.0, 0.0));
        device.point_at(Vec3(0.0, 0.0, -INFINITY));
        DeviceReading reading;
        for (int i = 0; i < 1000; ++i)
            reading = device.read(i * kStep, kStep);
        EXPECT_NEAR((reading.position - Vec3(10.0, 3.0, 0.0)).norm(), 0.0, 1e-9);
        EXPECT_EQ(test_support::message_of([] { PointerDevice d({ .time_s = 0.0 }); }),
            "time_s: the time constant must be positive");
        EXPECT_EQ(test_support::message_of([] {
            PointerDevice d({ .workspace = { Vec3::Zero(), Vec3::Zero() } });
        }),
            "workspace: the workspace is empty");
    }

} // namespace pointer_device_test
} // namespace retractor::haptics
