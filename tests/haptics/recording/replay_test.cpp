#include "haptics/recording/replay.h"

#include "haptics/device/simulated_hand.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

namespace retractor::haptics {
namespace replay_test {

    constexpr double kStep = 1e-3;

    /// A hand that pushes a spring of 0.3 N/mm down by 8 mm and lets go.
    MotionRecording a_press()
    {
        SimulatedHandOptions options;
        options.path = HandPath({ { 0.0, Vec3::Zero() }, { 0.3, Vec3(0.0, -8.0, 0.0) }, { 0.6, Vec3(0.0, -8.0, 0.0) },
            { 0.9, Vec3::Zero() } });
        SimulatedHand hand(options);
        MotionRecorder recorder({ { "hand", "simulated", "7" } }, 1000.0, 1000);
        for (int i = 0; i < 1000; ++i) {
            const DeviceReading reading = hand.read(i * kStep, kStep);
            const Vec3 force(0.0, std::max(0.0, -0.3 * reading.position.y()), 0.0);
            const Vec3 applied = hand.write(force);
            recorder.add(i * kStep,
                std::array { MotionSample { .position = reading.position,
                    .velocity = reading.velocity,
                    .commanded_force = force,
                    .applied_force = applied,
                    .buttons = reading.buttons } });
        }
        return recorder.recording();
    }

    TEST(Replay, RepeatsEveryTickBitForBit)
    {
        const MotionRecording recording = a_press();
        ReplayDevice device(recording, 0);
        for (std::size_t i = 0; i < recording.tick_count(); ++i) {
            const DeviceReading reading = device.read(static_cast<double>(i) * kStep, kStep);
            ASSERT_EQ(reading.position, recording.at(i, 0).position) << i;
            ASSERT_EQ(reading.velocity, recording.at(i, 0).velocity) << i;
            EXPECT_DOUBLE_EQ(device.write(Vec3(0.0, 100.0, 0.0)).y(), 3.3);
        }
        EXPECT_EQ(device.info().serial, "7");
        EXPECT_EQ(device.info().model, "replay of simulated");
    }

    TEST(Replay, IsTheSameMotionAtAnotherRate)
    {
        constexpr double kBetween = 0.1; // mm: half a tick's way at the press' top speed
        const MotionRecording recording = a_press();
        ReplayDevice device(recording, 0);
        for (int i = 0; i < 1990; ++i) {
            const Vec3 position = device.read(0.5 * i * kStep, 0.5 * kStep).position;
            const std::size_t tick = static_cast<std::size_t>(i) / 2;
            ASSERT_LT((position - recording.at(tick, 0).position).norm(), kBetween) << i;
        }
    }

    TEST(Replay, StaysAtTheEnd)
    {
        const MotionRecording recording = a_press();
        ReplayDevice once(recording, 0);
        EXPECT_EQ(once.read(99.0, kStep).position, recording.samples.back().position);
    }

    TEST(Replay, RefusesWhatIsNotThere)
    {
        EXPECT_EQ(test_support::message_of([] { ReplayDevice(a_press(), 1); }),
            "the recording has 1 devices, none of number 1");
        MotionRecording empty = a_press();
        empty.times_s.clear();
        empty.samples.clear();
        EXPECT_EQ(test_support::message_of([&] { ReplayDevice(empty, 0); }), "the recording is empty");
    }

} // namespace replay_test
} // namespace retractor::haptics
