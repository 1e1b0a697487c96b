// Every line of the HDAPI driver, against a simulated library with a simulated Touch in it.

#include "haptics/device/hd_session.h"

#include "haptics/servo/servo.h"
#include "tests/haptics/device/simulated_hd.h"
#include "tests/support/test_help.h"
#include "tests/support/wait_until.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cmath>
#include <set>

namespace retractor::haptics {
namespace hd_session_test {

    /// The simulated library's own functions, out of the library that the driver loads.
    template <class Function> Function* simulated(Function* /*declared*/, const char* name)
    {
        static void* const library = ::dlopen(RETRACTOR_SIMULATED_HD, RTLD_LAZY | RTLD_GLOBAL);
        EXPECT_NE(library, nullptr) << ::dlerror();
        return reinterpret_cast<Function*>(::dlsym(library, name));
    }
#define SIMULATED(function) simulated(static_cast<decltype(&function)>(nullptr), #function)

    double scheduler_time() noexcept { return 1e-3 * static_cast<double>(SIMULATED(simulated_ticks)()); }

    HdOptions by_hand()
    {
        HdOptions options;
        options.libraries = { RETRACTOR_SIMULATED_HD };
        options.calibration_limit = std::chrono::milliseconds(60);
        options.ramp_up_s = 1e-3;
        options.clock = scheduler_time;
        return options;
    }

    class HdSessionTest : public ::testing::Test {
    protected:
        HdSessionTest()
        {
            SIMULATED(simulated_reset)();
            SIMULATED(simulated_threaded)(0);
        }
        ~HdSessionTest() override
        {
            EXPECT_STREQ(SIMULATED(simulated_violations)(), "");
            EXPECT_EQ(SIMULATED(simulated_scheduler_runs)(), 0);
            EXPECT_EQ(SIMULATED(simulated_initialised)(0) + SIMULATED(simulated_initialised)(1), 0)
                << "all is given back";
            SIMULATED(simulated_reset)();
        }
        static void run(int ticks) { SIMULATED(simulated_run)(ticks); }
        static Vec3 motor_force(int device)
        {
            Vec3 force;
            SIMULATED(simulated_motor_force)(device, force.data());
            return force;
        }
        static std::string message(const std::vector<HdDeviceRequest>& requests, const HdOptions& options = by_hand())
        {
            return test_support::message_of([&] { HdSession session(requests, options); });
        }
    };

    /// Pushes each device with its own constant force, keeps what was read.
    struct Pusher : Ticked {
        HdSession& session;
        std::vector<Vec3> forces;
        std::vector<DeviceReading> readings;
        int ticks = 0;

        explicit Pusher(HdSession& s)
            : session(s)
            , forces(s.device_count(), Vec3::Zero())
            , readings(s.device_count())
        {
        }
        void tick(double time_s, double step_s) noexcept override
        {
            ++ticks;
            for (std::size_t d = 0; d < forces.size(); ++d)
                readings[d] = session.device(d).read(time_s, step_s);
            for (std::size_t d = 0; d < forces.size(); ++d)
                session.device(d).write(forces[d]);
        }
    };

    TEST_F(HdSessionTest, KnowsWhatTheDeviceIsAndCanDo)
    {
        HdSession session({ { .name = "Left Device" } }, by_hand());
        const DeviceInfo& info = session.device(0).info();
        EXPECT_EQ(info.name, "Left Device");
        EXPECT_EQ(info.model, "Simulated Touch");
        EXPECT_EQ(info.serial, "100-2");
        EXPECT_EQ(info.limits.max_force, 3.3);
        EXPECT_EQ(info.limits.max_stiffness, 0.5);
        EXPECT_EQ(info.limits.max_damping, DeviceLimits {}.max_damping)
            << "what it does not tell stays the data sheet's";
        EXPECT_EQ(info.limits.own_friction, 0.0) << "nobody has measured it";
        EXPECT_EQ(info.workspace.low, Vec3(-80.0, -60.0, -35.0));
        EXPECT_TRUE(session.take_problems().empty()) << "nothing is asked that a Touch does not know";
    }

    TEST_F(HdSessionTest, FindsADeviceByDefaultByNameAndBySerial)
    {
        EXPECT_EQ(HdSession({ {} }, by_hand()).device(0).info().serial, "100-1");
        EXPECT_EQ(HdSession({ { .name = "Default Device" } }, by_hand()).device(0).info().serial, "100-1");
        EXPECT_EQ(HdSession({ { .serial = "100-2" } }, by_hand()).device(0).info().serial, "100-2");
        EXPECT_EQ(HdSession({ { .serial = "100-1" } }, by_hand()).device(0).info().serial, "100-1");
        EXPECT_NE(
            message({ { .serial = "999" } }).find("device '999' was not found; there is 100-1"), std::string::npos);
        EXPECT_NE(message({ { .name = "Nobody" } })
                      .find("device 'Nobody' cannot be initialised: a call was wrong (HDAPI 0x0101"),
            std::string::npos);
        EXPECT_NE(message({ {}, {} }).find("already in use"), std::string::npos);
        EXPECT_EQ(message({}), "no device was asked for");
    }

    TEST_F(HdSessionTest, ReadsPoseAndButtonsAndPushesTheHand)
    {
        HdSession session({ {} }, by_hand());
        Pusher pusher(session);
        SIMULATED(simulated_target)(0, 11.0, -7.0, 3.0);
        SIMULATED(simulated_buttons)(0, 2);
        session.start(pusher);
        run(800);
        const DeviceReading& reading = pusher.readings[0];
        EXPECT_NEAR((reading.position - Vec3(11.0, -7.0, 3.0)).norm(), 0.0, 0.055);
        EXPECT_EQ(reading.buttons, 2u);
        EXPECT_EQ(reading.trouble, DeviceTrouble::none);
        EXPECT_EQ(reading.orientation.col(0), Vec3::UnitY()) << "its transform is column by column";
        pusher.forces[0] = Vec3(0.4, 0.0, 0.0);
        run(800);
        EXPECT_NEAR(pusher.readings[0].position.x(), 12.0, 0.06) << "0.4 N on a hand of 0.4 N/mm";
        pusher.forces[0] = Vec3(0.0, 70.0, 0.0);
        run(2);
        EXPECT_NEAR(motor_force(0).norm(), 3.3, 1e-9);
        EXPECT_TRUE(session.take_problems().empty()) << "clamped before the device could complain";
        pusher.forces[0].setZero();
        run(2);
        EXPECT_EQ(test_support::message_of([&] { session.start(pusher); }), "the devices run already");
    }

    TEST_F(HdSessionTest, OneCallbackDrivesTwoDevicesEachWithItsForce)
    {
        HdSession session({ {}, { .name = "Left Device" } }, by_hand());
        Pusher pusher(session);
        pusher.forces = { Vec3(0.5, 0.0, 0.0), Vec3(0.0, -0.7, 0.0) };
        session.start(pusher);
        run(10);
        EXPECT_EQ(pusher.ticks, 10);
        EXPECT_NEAR((motor_force(0) - pusher.forces[0]).norm(), 0.0, 1e-12);
        EXPECT_NEAR((motor_force(1) - pusher.forces[1]).norm(), 0.0, 1e-12);
        EXPECT_TRUE(session.take_problems().empty());
        pusher.forces = { Vec3::Zero(), Vec3::Zero() };
        run(2);
        SIMULATED(simulated_threaded)(0);
    }

    TEST_F(HdSessionTest, BringsTheForceUpAndTakesItDownBeforeItLetsGo)
    {
        SIMULATED(simulated_threaded)(1);
        HdOptions options = by_hand();
        options.clock = tick_clock_s;
        options.ramp_up_s = 0.05;
        HdSession session({ {} }, options);
        Pusher pusher(session);
        pusher.forces[0] = Vec3(1.0, 0.0, 0.0);
        session.start(pusher);
        ASSERT_TRUE(test_support::wait_until([&] { return motor_force(0).x() >= 1.0; }));
        session.stop(); // the simulated library notes a force that is left on
        EXPECT_EQ(SIMULATED(simulated_scheduler_runs)(), 0);
        EXPECT_GT(session.times().ticks, 50u);
        session.stop();
        session.start(pusher);
        session.stop();
    }

    TEST_F(HdSessionTest, DrainsTheErrorQueueAndKnowsWhatEachMeans)
    {
        HdSession session({ {}, { .name = "Left Device" } }, by_hand());
        Pusher pusher(session);
        session.start(pusher);
        SIMULATED(simulated_post_error)(1, hd::kWarmMotors, 5);
        SIMULATED(simulated_post_error)(0, hd::kInvalidInputType, 0);
        run(1);
        const std::vector<HdProblem> problems = session.take_problems();
        ASSERT_EQ(problems.size(), 2u);
        EXPECT_EQ(describe(problems[0]), "0x0200, the motors are warm: device 1 is over its limits");
        EXPECT_EQ(problems[0].internal, 5);
        EXPECT_EQ(describe(problems[1]), "0x0103, a call was wrong");
        run(1);
        EXPECT_EQ(pusher.readings[1].trouble, DeviceTrouble::over_limit);
        EXPECT_EQ(pusher.readings[0].trouble, DeviceTrouble::none);
        run(1);
        EXPECT_EQ(pusher.readings[1].trouble, DeviceTrouble::none) << "it recovers";
        for (int i = 0; i < 200; ++i)
            SIMULATED(simulated_post_error)(0, hd::kInvalidInputType, 0);
        run(5);
        EXPECT_EQ(session.take_problems().size(), 64u) << "as many as there is room for";
        EXPECT_TRUE(session.take_problems().empty());
    }

    TEST_F(HdSessionTest, EveryErrorHasItsMeaning)
    {
        for (const hd::ErrorCode code :
            { hd::kWarmMotors, hd::kExceededForce, hd::kExceededImpulse, hd::kExceededVelocity, hd::kForceError })
            EXPECT_EQ(trouble_of(code), DeviceTrouble::over_limit) << code;
        for (const hd::ErrorCode code : { hd::kDeviceFault, hd::kCommError, hd::kCommConfigError, hd::kTimerError })
            EXPECT_EQ(trouble_of(code), DeviceTrouble::lost) << code;
        for (const hd::ErrorCode code : { hd::kInvalidInputType, hd::kAlreadyInitiated, hd::kFrameError,
                 hd::kIllegalBegin, hd::kIllegalEnd, hd::kSchedulerFull, hd::kInvalidPriority, hd::kInvalidLicense })
            EXPECT_EQ(trouble_of(code), DeviceTrouble::none) << code;
        std::set<std::string> words;
        for (const hd::ErrorCode code : { 0x100u, 0x200u, 0x201u, 0x202u, 0x203u, 0x204u, 0x300u, 0x301u, 0x302u,
                 0x303u, 0x304u, 0x400u, 0x500u, 0x600u, 0x700u })
            words.insert(describe(HdProblem { .code = code }).substr(8));
        EXPECT_EQ(words.size(), 15u);
    }

    /// The servo on top: a wall of 0.3 N/mm, pressed 2 mm deep.
    struct Pressed {
        HdSession session;
        test_support::Wall wall { 0.3 };
        Servo servo;
        static ServoOptions options()
        {
            ServoOptions options;
            options.coupling.damping_share = 0.0;
            options.faults.ramp_up_s = 1e-3;
            return options;
        }
        Pressed()
            : session({ {} }, by_hand())
            , servo({ { .device = &session.device(0) } }, wall, options())
        {
            SIMULATED(simulated_target)(0, 0.0, -3.5, 0.0);
            session.start(servo);
            SIMULATED(simulated_run)(1000);
        }
        ~Pressed()
        {
            servo.let_go();
            SIMULATED(simulated_run)(150);
        }
        Pressed(const Pressed&) = delete;
        Pressed& operator=(const Pressed&) = delete;
    };

    TEST_F(HdSessionTest, TheServoFeelsAWallThroughIt)
    {
        SIMULATED(simulated_noise)(0.01);
        Pressed pressed;
        // Springs in a row: 0.4 and 0.3 N/mm over 3.5 mm.
        EXPECT_NEAR(motor_force(0).y(), 3.5 * 0.4 * 0.3 / 0.7, 0.03);
        EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::none);
    }

    TEST_F(HdSessionTest, LetsGoWhenItIsUnplugged)
    {
        Pressed pressed;
        SIMULATED(simulated_unplug)(0);
        run(200);
        EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::lost);
        EXPECT_EQ(pressed.servo.latest().force_share, 0.0);
        pressed.servo.rearm();
        run(10);
        EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::lost) << "it does not come back by itself";
    }

    TEST_F(HdSessionTest, LetsGoOfAMotionThatOverruns)
    {
        for (const double jump : { 60.0, 500.0 }) {
            SIMULATED(simulated_reset)();
            SIMULATED(simulated_threaded)(0);
            Pressed pressed;
            SIMULATED(simulated_offset)(0, 80.0 + jump, 0.0, 0.0);
            run(1);
            EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::over_limit) << "beyond any arm's reach";
            run(200);
            EXPECT_EQ(motor_force(0).norm(), 0.0);
            SIMULATED(simulated_offset)(0, 0.0, 0.0, 0.0);
            run(2); // back from the jump
            pressed.servo.rearm();
            run(500);
            EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::none);
            EXPECT_GT(motor_force(0).y(), 0.5);
        }
    }

    TEST_F(HdSessionTest, LetsGoWhenTheDeviceSaysTooFast)
    {
        Pressed pressed;
        SIMULATED(simulated_post_error)(0, hd::kExceededVelocity, 0);
        run(200);
        EXPECT_EQ(pressed.servo.latest().fault.kind, FaultKind::over_limit);
        EXPECT_EQ(motor_force(0).norm(), 0.0);
    }

    TEST_F(HdSessionTest, StopsEvenWhenTheSchedulerDoesNotCallAnyMore)
    {
        HdSession session({ {} }, by_hand());
        Pusher pusher(session);
        session.start(pusher);
        run(3);
        session.stop(); // nobody runs ticks meanwhile
        EXPECT_EQ(SIMULATED(simulated_scheduler_runs)(), 0);
    }

    TEST_F(HdSessionTest, CalibratesWhatCanBeAndSaysWhatAPersonMustDo)
    {
        SIMULATED(simulated_calibration)(0, 1);
        EXPECT_EQ(message({ {} }), "");
        SIMULATED(simulated_calibration)(0, 2);
        EXPECT_NE(message({ {} }).find("device 'default' is not calibrated: put the stylus into its inkwell"),
            std::string::npos);
        SIMULATED(simulated_calibration)(0, 3);
        EXPECT_NE(message({ {} }).find("run the vendor's diagnostics"), std::string::npos);
    }

    TEST_F(HdSessionTest, SaysWhyADeviceCannotBeInitialised)
    {
        SIMULATED(simulated_refuse)(hd::kCommError);
        const std::string text = message({ {} });
        EXPECT_NE(text.find("device 'default' cannot be initialised: communication error (HDAPI 0x0302, internal 7, "
                            "\"Communication error\"); is it plugged in and configured?"),
            std::string::npos)
            << text;
        SIMULATED(simulated_refuse)(0);
        SIMULATED(simulated_post_error)(0, hd::kTimerError, 0); // an old error is not blamed on the next call
        EXPECT_EQ(message({ {} }), "");
    }

    TEST(HdLibrary, SaysWhatWasTriedAndWhyItFailed)
    {
        const std::string text = test_support::message_of([] { HdLibrary library({ "libNoSuchHD.so", "libm.so.6" }); });
        EXPECT_NE(text.find("libNoSuchHD.so: cannot open shared object file"), std::string::npos);
        EXPECT_NE(text.find("libm.so.6 has no hdInitDevice"), std::string::npos);
        const HdLibrary found({ "libNoSuchHD.so", RETRACTOR_SIMULATED_HD });
        EXPECT_EQ(found.name(), RETRACTOR_SIMULATED_HD);
        ASSERT_EQ(found.attempts().size(), 1u);
        EXPECT_EQ(missing_library(found.attempts()[0].reason), "libNoSuchHD.so");
        EXPECT_EQ(missing_library("something else"), "");
    }

} // namespace hd_session_test
} // namespace retractor::haptics
