#include "haptics/servo/servo.h"

#include "haptics/device/simulated_hand.h"
#include "haptics/device/tick_thread.h"
#include "haptics/recording/replay.h"
#include "haptics/springs/spring_tissue.h"
#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::haptics {
namespace servo_test {

    constexpr double kStep = 1e-3;
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

    /// Says what it is told to say, keeps what it is given.
    struct Puppet : Device {
        DeviceInfo own { .name = "puppet", .model = {}, .serial = "1" };
        DeviceReading reading;
        Vec3 force = Vec3::Constant(-1.0);

        const DeviceInfo& info() const noexcept override { return own; }
        DeviceReading read(double, double) noexcept override { return reading; }
        Vec3 write(const Vec3& wanted) noexcept override { return force = clamped(wanted, own.limits.max_force); }
    };

    ServoOptions at_once()
    {
        ServoOptions options;
        options.coupling.damping_share = 0.0;
        options.faults.ramp_up_s = kStep; // full force from the second tick on
        return options;
    }

    /// A puppet that holds a wall of 0.3 N/mm 2 mm deep: 0.6 N.
    struct HeldWall {
        Puppet puppet;
        test_support::Wall wall { 0.3 };
        Servo servo;
        std::uint64_t ticks = 0;

        explicit HeldWall(const ServoOptions& options = at_once())
            : servo({ { .device = &puppet } }, wall, options)
        {
            puppet.reading.position.y() = -2.0;
            run(100);
        }
        void run(std::uint64_t count)
        {
            run_ticks(servo, count, kStep, ticks);
            ticks += count;
        }
    };
    constexpr double kHeld = 0.6;

    TEST(Servo, GivesTheHandTheTissuesForce)
    {
        HeldWall held;
        EXPECT_NEAR((held.puppet.force - Vec3(0.0, kHeld, 0.0)).norm(), 0.0, 1e-12);
        const ServoState& state = held.servo.latest();
        EXPECT_EQ(state.ticks, 100u);
        EXPECT_EQ(state.finger_count, 1u);
        EXPECT_TRUE(state.contacts[0].touching);
        EXPECT_EQ(state.fingers[0].position, held.puppet.reading.position);
        EXPECT_EQ(state.fault.kind, FaultKind::none);
        EXPECT_EQ(held.wall.ticks, 100u) << "the tissue is asked once a tick";
    }

    TEST(Servo, BringsTheForceUpSlowly)
    {
        ServoOptions options = at_once();
        options.faults.ramp_up_s = 0.5;
        HeldWall held(options);
        EXPECT_NEAR(held.puppet.force.y(), kHeld * 0.2, 1e-9);
        held.run(400);
        EXPECT_NEAR(held.puppet.force.y(), kHeld, 1e-9);
    }

    TEST(Servo, TwoDevicesFeelTheirOwnForcesInOneAnswer)
    {
        Puppet left, right;
        left.reading.position.y() = -2.0;
        right.reading.position.y() = -1.0;
        test_support::Wall wall(0.3, 2);
        Servo servo({ { .device = &left, .mapping = { .mirrored = true } }, { .device = &right } }, wall, at_once());
        run_ticks(servo, 10);
        EXPECT_NEAR(left.force.y(), 0.6, 1e-12);
        EXPECT_NEAR(right.force.y(), 0.3, 1e-12);
        EXPECT_EQ(wall.ticks, 10u);
    }

    TEST(Servo, ThreeFingersOnEachOfTwoHandsAreSixContacts)
    {
        Puppet left, right;
        test_support::Wall wall(0.1, 6);
        ServoOptions options = at_once();
        for (std::size_t device = 0; device < 2; ++device)
            for (const double y : { -1.0, -2.0, 3.0 })
                options.fingers.push_back({ .device = device, .offset = Vec3(10.0, y, 0.0) });
        Servo servo({ { .device = &left, .mapping = { .mirrored = true } }, { .device = &right } }, wall, options);
        run_ticks(servo, 10);
        const ServoState& state = servo.latest();
        EXPECT_EQ(state.finger_count, 6u);
        EXPECT_EQ(state.fingers[0].position, Vec3(-10.0, -1.0, 0.0));
        EXPECT_EQ(state.fingers[3].position, Vec3(10.0, -1.0, 0.0));
        EXPECT_NEAR(left.force.y(), 0.3, 1e-12) << "a hand feels the sum of its fingers";
        EXPECT_NEAR(right.force.y(), 0.3, 1e-12);
    }

    TEST(Servo, NeverGoesBeyondTheDevicesForceAndSparesWarmMotors)
    {
        HeldWall held;
        held.puppet.reading.position.y() = -20.0; // 6 N wanted
        held.run(200);
        EXPECT_NEAR(held.puppet.force.norm(), 3.3, 1e-9);
        held.run(60'000);
        EXPECT_LT(held.puppet.force.norm(), 1.1) << "a minute on it is back near the continuous force";
        EXPECT_GT(held.puppet.force.norm(), 0.87);
    }

    TEST(Servo, TheClutchFreesTheHandAndBringsTheForceBackSmoothly)
    {
        HeldWall held;
        held.puppet.reading.buttons = 2;
        held.run(100);
        EXPECT_EQ(held.puppet.force.norm(), 0.0);
        held.puppet.reading.position.x() = 50.0;
        held.puppet.reading.buttons = 0;
        double last = 0.0, largest = 0.0;
        for (int i = 0; i < 100; ++i) {
            held.run(1);
            largest = std::max(largest, std::abs(held.puppet.force.y() - last));
            last = held.puppet.force.y();
        }
        EXPECT_NEAR(last, kHeld, 1e-9);
        EXPECT_LT(largest, 0.02) << "N per tick";
        EXPECT_EQ(held.servo.latest().fingers[0].position.x(), 0.0);
    }

    /// What every fault must do.
    void expect_let_go(HeldWall& held, FaultKind kind)
    {
        double last = held.puppet.force.norm();
        EXPECT_GT(last, 0.5 * kHeld) << "the ramp begins where the force was";
        for (int i = 0; i < 110; ++i) {
            held.run(1);
            ASSERT_TRUE(held.puppet.force.allFinite());
            EXPECT_LE(held.puppet.force.norm(), last + 1e-12);
            EXPECT_GE(held.puppet.force.norm(), last - 0.02) << "N per tick";
            last = held.puppet.force.norm();
        }
        EXPECT_EQ(last, 0.0);
        EXPECT_EQ(held.servo.latest().fault.kind, kind) << describe(held.servo.latest().fault);
        held.run(500);
        EXPECT_EQ(held.puppet.force.norm(), 0.0) << "it stays latched";
    }

    TEST(Servo, LetsGoWhenAPoseIsNotANumber)
    {
        HeldWall held;
        held.puppet.reading.position.x() = kNaN;
        held.run(1);
        expect_let_go(held, FaultKind::bad_position);
        EXPECT_TRUE(held.servo.latest().fingers[0].position.allFinite()) << "the tissue never sees it";
    }

    TEST(Servo, LetsGoWhenADeviceJumps)
    {
        HeldWall held;
        held.puppet.reading.position.x() = 99.0;
        held.run(1);
        EXPECT_EQ(held.servo.latest().fault.kind, FaultKind::none);
        held.puppet.reading.position.x() = -2.0;
        held.run(1);
        expect_let_go(held, FaultKind::jump);
        EXPECT_EQ(held.servo.latest().fault.value, 101.0);
        EXPECT_EQ(held.servo.latest().fault.tick, 102u);
        EXPECT_EQ(held.servo.latest().fingers[0].position.x(), 99.0) << "the tissue never sees it";
        held.servo.rearm();
        held.run(100);
        EXPECT_EQ(held.servo.latest().fingers[0].position.x(), -2.0);
        EXPECT_NEAR(held.puppet.force.norm(), kHeld, 1e-9);

        HeldWall exact; // a jump of 100 mm is one of 100 mm
        exact.puppet.reading.position.x() = 100.0;
        exact.run(1);
        expect_let_go(exact, FaultKind::jump);
    }

    TEST(Servo, RecordsWhereADeviceIsThatTheTissueNoLongerSees)
    {
        Puppet puppet;
        test_support::Wall wall(0.3);
        Servo servo({ { .device = &puppet } }, wall, at_once());
        MotionRecorder recorder(servo.recorded_devices(), 1000.0, 4);
        servo.record_to(&recorder);
        run_ticks(servo, 1);
        puppet.reading.position.x() = 150.0;
        puppet.reading.velocity.x() = 7.0;
        puppet.reading.buttons = 4;
        run_ticks(servo, 2, kStep, 1);
        EXPECT_EQ(servo.latest().fingers[0].position.x(), 0.0);
        puppet.reading.position.x() = kNaN;
        run_ticks(servo, 1, kStep, 3);
        const MotionRecording& recording = recorder.recording();
        ASSERT_EQ(recording.tick_count(), 4U);
        for (const std::size_t tick : { 1U, 2U }) {
            EXPECT_EQ(recording.at(tick, 0).position.x(), 150.0);
            EXPECT_EQ(recording.at(tick, 0).velocity.x(), 7.0);
            EXPECT_EQ(recording.at(tick, 0).buttons, 4U);
        }
        EXPECT_EQ(recording.at(3, 0).position.x(), 150.0) << "the last that can be";
        EXPECT_EQ(recording.at(3, 0).velocity.x(), 0.0);
    }

    TEST(Servo, ADeviceArmedAgainElsewhereSweepsNothingOnTheWay)
    {
        Puppet puppet;
        SpringTissue sheet(make_spring_sheet(), { .drag = 30.0 }); // 24 mm wide, in the plane z = 0
        Servo servo({ { .device = &puppet } }, sheet, at_once());
        const auto moved
            = [&] { return Points(sheet.motion().positions() - sheet.surface().vertices).rowwise().norm().maxCoeff(); };
        const Vec3 beside(-75.0, 0.0, -2.0);
        puppet.reading.position = beside;
        run_ticks(servo, 50);
        const Vec3 shift(150.0, 0.0, 0.0); // the device's zero: it stays
        puppet.reading.position = beside + shift;
        run_ticks(servo, 200, kStep, 50);
        ASSERT_EQ(servo.latest().fault.kind, FaultKind::jump);
        servo.rearm();
        puppet.reading.position.y() = kNaN; // a pose that is none does not count as the first
        run_ticks(servo, 1, kStep, 250);
        servo.rearm();
        puppet.reading.position = beside + shift;
        run_ticks(servo, 1, kStep, 251);
        ASSERT_EQ(servo.latest().fingers[0].position, beside + shift);
        EXPECT_TRUE(servo.latest().fingers[0].placed);
        EXPECT_FALSE(servo.latest().contacts[0].touching);
        constexpr double kRounding = 1e-9; // mm
        EXPECT_LT(moved(), kRounding);
        run_ticks(servo, 200, kStep, 252);
        EXPECT_EQ(servo.latest().fault.kind, FaultKind::none);
        EXPECT_FALSE(servo.latest().fingers[0].placed);
        EXPECT_LT(moved(), kRounding);
    }

    TEST(Servo, LetsGoWhenATickIsLateOrTimeStandsStill)
    {
        for (const double step : { 0.05, 0.0, kNaN }) {
            HeldWall held;
            held.servo.tick(0.15, step);
            EXPECT_EQ(held.servo.latest().fault.kind, FaultKind::late);
            expect_let_go(held, FaultKind::late);
        }
    }

    TEST(Servo, LetsGoWhenADeviceFallsSilentButNotAtOnce)
    {
        HeldWall held;
        held.puppet.reading.trouble = DeviceTrouble::silent;
        held.run(19);
        EXPECT_EQ(held.servo.latest().fault.kind, FaultKind::none);
        EXPECT_NEAR(held.puppet.force.norm(), kHeld, 1e-12);
        held.run(2);
        expect_let_go(held, FaultKind::silent);
    }

    TEST(Servo, LetsGoWhenADeviceIsLostOrOverItsLimits)
    {
        for (const auto& [trouble, kind] : { std::pair { DeviceTrouble::lost, FaultKind::lost },
                 std::pair { DeviceTrouble::over_limit, FaultKind::over_limit } }) {
            HeldWall held;
            held.puppet.reading.trouble = trouble;
            held.run(1);
            expect_let_go(held, kind);
        }
    }

    TEST(Servo, LetsGoWhenTheTissueHasNoAnswer)
    {
        HeldWall held;
        held.wall.bad_tick = held.wall.ticks + 1;
        held.run(1);
        expect_let_go(held, FaultKind::bad_force);
    }

    TEST(Servo, LetsGoWhenAFiniteAnswerOverflowsAndStillSparesWarmMotors)
    {
        HeldWall held;
        held.wall.far_tick = held.wall.ticks + 1; // no finite speed takes the proxy there
        held.run(1);
        expect_let_go(held, FaultKind::bad_force);
        held.servo.rearm();
        held.run(100);
        EXPECT_NEAR(held.puppet.force.norm(), kHeld, 1e-9);
        held.puppet.reading.position.y() = -20.0;
        held.run(60'000);
        EXPECT_LT(held.puppet.force.norm(), 1.1) << "the motors' heat is still counted";
    }

    TEST(Servo, LetsGoOfAPoseThatNoHandHas)
    {
        HeldWall fast;
        fast.puppet.reading.velocity.x() = 1e7;
        fast.run(1);
        expect_let_go(fast, FaultKind::bad_position);
        HeldWall stretched;
        stretched.puppet.reading.orientation *= 1.01;
        stretched.run(1);
        expect_let_go(stretched, FaultKind::bad_position);
    }

    TEST(Servo, ComesBackWhenItIsArmedAgainUnlessTheFaultIsStillThere)
    {
        HeldWall held;
        held.puppet.reading.trouble = DeviceTrouble::lost;
        held.run(200);
        held.servo.rearm();
        held.run(100);
        EXPECT_EQ(held.servo.latest().fault.kind, FaultKind::lost);
        EXPECT_EQ(held.puppet.force.norm(), 0.0);
        held.puppet.reading.trouble = DeviceTrouble::none;
        held.servo.rearm();
        held.run(10);
        EXPECT_EQ(held.servo.latest().fault.kind, FaultKind::none);
        EXPECT_NEAR(held.puppet.force.norm(), kHeld, 1e-12);
    }

    TEST(Servo, EndsCleanly)
    {
        HeldWall held;
        held.servo.let_go();
        held.run(1);
        expect_let_go(held, FaultKind::let_go);
    }

    TEST(Servo, RecordsWhatItDidAndTheReplayDoesTheSame)
    {
        SimulatedHandOptions hand;
        hand.path
            = HandPath({ { 0.0, Vec3(0.0, 3.0, 0.0) }, { 0.3, Vec3(0.0, -6.0, 0.0) }, { 0.8, Vec3(0.0, 3.0, 0.0) } });
        const auto record = [&] {
            SimulatedHand device(hand);
            test_support::Wall wall(0.25);
            Servo servo({ { .device = &device } }, wall);
            MotionRecorder recorder(servo.recorded_devices(), 1000.0, 1000);
            servo.record_to(&recorder);
            run_ticks(servo, 1000);
            return recorder.recording();
        };
        const MotionRecording a = record(), b = record();
        ASSERT_EQ(a.tick_count(), 1000u);
        EXPECT_EQ(a.devices[0].name, "simulated");
        double strongest = 0.0;
        for (std::size_t i = 0; i < a.tick_count(); ++i) {
            ASSERT_EQ(a.at(i, 0).position, b.at(i, 0).position);
            ASSERT_EQ(a.at(i, 0).applied_force, b.at(i, 0).applied_force);
            strongest = std::max(strongest, a.at(i, 0).applied_force.y());
        }
        EXPECT_GT(strongest, 0.2);
    }

    TEST(Servo, ARecordingBegunAfterTheClutchIsReplayedWhereItWas)
    {
        const auto path = [](double t) -> Vec3 { return { 40.0 * t, 20.0 * std::cos(9.0 * t), -15.0 * t }; };
        constexpr std::uint32_t kClutch = 2;
        constexpr int kTicks = 600;
        // Held from tick 50 to 150 and from 400 to 450: a recording begins before, within and after.
        for (const int from : { 20, 100, 200 }) {
            Puppet hand;
            test_support::Wall wall(0.1);
            const MappingOptions mapping { .scene_centre = Vec3(5.0, 10.0, -200.0), .scale = 1.5 };
            Servo servo({ { .device = &hand, .mapping = mapping } }, wall);
            MotionRecorder recorder(servo.recorded_devices(), 1000.0, kTicks);
            std::vector<Vec3> there;
            for (int i = 0; i < kTicks; ++i) {
                hand.reading.position = path(i * kStep);
                hand.reading.buttons = (i >= 50 && i < 150) || (i >= 400 && i < 450) ? kClutch : 0;
                if (i == from)
                    servo.record_to(&recorder);
                run_ticks(servo, 1, kStep, static_cast<std::uint64_t>(i));
                if (i >= from)
                    there.push_back(servo.latest().fingers[0].position);
            }
            const MotionRecording recording = recorder.recording();
            ASSERT_EQ(recording.tick_count(), there.size());
            ReplayDevice replay(recording, 0);
            ASSERT_TRUE(replay.frame());
            test_support::Wall same(0.1);
            Servo again(
                { { .device = &replay, .mapping = mapping_of(*replay.frame(), replay.info().workspace) } }, same);
            constexpr double kRounding = 1e-9; // mm
            for (std::size_t i = 0; i < there.size(); ++i) {
                run_ticks(again, 1, kStep, i);
                ASSERT_LT((again.latest().fingers[0].position - there[i]).norm(), kRounding) << from << ' ' << i;
            }
        }
    }

    TEST(Servo, AsksForNoMemory)
    {
        if (!test_support::allocations_are_counted())
            GTEST_SKIP() << "a sanitizer has its own malloc";
        const std::size_t before = test_support::allocation_count();
        ::operator delete(::operator new(4)); // called like this it cannot be left out
        ASSERT_EQ(test_support::allocation_count(), before + 1) << "the count counts";

        SimulatedHandOptions hand;
        hand.path
            = HandPath({ { 0.0, Vec3(0.0, 3.0, 0.0) }, { 0.2, Vec3(0.0, -6.0, 0.0) }, { 0.5, Vec3(0.0, 3.0, 0.0) } });
        SimulatedHand left(hand);
        Puppet right;
        right.reading.position.y() = -1.0;
        test_support::Wall wall(5.0, 2); // stiff: the spring in series is at work
        Servo servo({ { .device = &left }, { .device = &right } }, wall);
        MotionRecorder recorder(servo.recorded_devices(), 1000.0, 1500);
        servo.record_to(&recorder);
        const std::size_t start = test_support::allocation_count();
        run_ticks(servo, 1000);
        right.reading.position.x() = kNaN; // a fault asks for none either
        run_ticks(servo, 1000, kStep, 1000);
        servo.rearm();
        run_ticks(servo, 100, kStep, 2000);
        EXPECT_EQ(test_support::allocation_count(), start);
        EXPECT_EQ(recorder.lost_ticks(), 600u);
    }

    TEST(Servo, AnotherThreadReadsWholeStates)
    {
        SimulatedHandOptions hand;
        hand.path = HandPath({ { 0.0, Vec3(0.0, -1.0, 0.0) } });
        SimulatedHand device(hand);
        test_support::Wall wall(0.25);
        ServoOptions options;
        options.faults.late_s = 10.0; // the machine may be busy
        Servo servo({ { .device = &device } }, wall, options);
        TickThread thread({ .period_s = 2e-4 });
        thread.start(servo);
        std::uint64_t last = 0;
        while (last < 300) {
            const ServoState& state = servo.latest();
            ASSERT_GE(state.ticks, last);
            if (state.ticks > 0) {
                ASSERT_EQ(state.finger_count, 1u);
                ASSERT_TRUE(state.fingers[0].position.allFinite());
            }
            if (last > 150)
                servo.let_go();
            last = state.ticks;
        }
        thread.stop();
        EXPECT_EQ(servo.latest().fault.kind, FaultKind::let_go);
    }

    TEST(Servo, RefusesWhatCannotWork)
    {
        Puppet puppet;
        test_support::Wall one(1.0), two(1.0, 2);
        const auto message
            = [&](std::vector<ServoDevice> devices, test_support::Wall& wall, const ServoOptions& options = {}) {
                  return test_support::message_of([&] { Servo servo(std::move(devices), wall, options); });
              };
        EXPECT_EQ(message({}, one), "a servo needs at least one device");
        EXPECT_EQ(message({ { .device = &puppet } }, two), "there are 1 fingers, but 'wall' takes 2");
        ServoOptions options;
        options.fingers = { { .device = 3 } };
        EXPECT_EQ(message({ { .device = &puppet } }, one, options), "finger 0: device 3 does not exist");
        options.fingers = { { .radius = 0.0 } };
        EXPECT_EQ(
            message({ { .device = &puppet } }, one, options), "finger 0: the fingertip's radius or place is wrong");
        const double infinite = std::numeric_limits<double>::infinity();
        options.fingers = { { .radius = infinite } };
        EXPECT_EQ(
            message({ { .device = &puppet } }, one, options), "finger 0: the fingertip's radius or place is wrong");
        options = {};
        options.step_s = infinite;
        EXPECT_EQ(message({ { .device = &puppet } }, one, options),
            "the step must be positive, the force gain not negative, both finite");
        options.fingers.assign(9, {});
        EXPECT_EQ(message({ { .device = &puppet } }, one, options), "there are 9 fingers, at most 8 are possible");
    }

} // namespace servo_test
} // namespace retractor::haptics
