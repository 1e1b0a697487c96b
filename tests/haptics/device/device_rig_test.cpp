#include "haptics/device/device_rig.h"

#include "haptics/recording/motion_file.h"
#include "haptics/servo/servo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"
#include "tests/support/wait_until.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <array>

namespace retractor::haptics {
namespace device_rig_test {

    std::string write_recording(const test_support::TemporaryFolder& folder)
    {
        MotionRecorder recorder({ { "hand", "simulated", "1" } }, 1000.0, 2);
        for (int i = 0; i < 2; ++i)
            recorder.add(1e-3 * i, std::array { MotionSample { .position = Vec3(0.0, -1.0, 0.0) } });
        const std::filesystem::path file = folder.path / "motion.bin";
        write_motion(file, recorder.recording());
        return file.string();
    }

    TEST(DeviceRig, OneSchedulerTicksATouchAndARecordingTogether)
    {
        const test_support::TemporaryFolder folder;
        const std::vector<std::string> names { "replay:" + write_recording(folder), "touch:Left Device",
            "touch:#100-1" };
        DeviceRig rig(names, { .libraries = { RETRACTOR_SIMULATED_HD } });
        ASSERT_EQ(rig.devices().size(), 3u);
        EXPECT_EQ(rig.devices()[0]->info().name, "hand");
        EXPECT_EQ(rig.devices()[1]->info().serial, "100-2");
        EXPECT_EQ(rig.devices()[2]->info().serial, "100-1");
        test_support::Wall wall(0.1, 3);
        ServoOptions options;
        options.faults.late_s = 60.0; // the machine may be busy
        Servo servo({ { .device = rig.devices()[0] }, { .device = rig.devices()[1] }, { .device = rig.devices()[2] } },
            wall, options);
        rig.source().start(servo);
        ASSERT_TRUE(test_support::wait_until([&] { return servo.latest().ticks >= 20; }));
        EXPECT_TRUE(servo.latest().contacts[0].touching);
        rig.source().stop();
        EXPECT_GE(rig.times().ticks, 20u);
        EXPECT_TRUE(rig.take_problems().empty());
    }

    TEST(DeviceRig, OurOwnThreadTicksTheOthers)
    {
        const test_support::TemporaryFolder folder;
        const std::vector<std::string> names { "replay:" + write_recording(folder) };
        DeviceRig rig(names);
        test_support::Wall wall(0.1);
        Servo servo({ { .device = rig.devices()[0] } }, wall);
        rig.source().start(servo);
        ASSERT_TRUE(test_support::wait_until([&] { return servo.latest().ticks >= 5; }));
        rig.source().stop();
        EXPECT_GE(rig.times().ticks, 5u);
        EXPECT_TRUE(rig.take_problems().empty());
    }

    TEST(DeviceRig, ARecordingIsPlayedAsItsFingersDevice)
    {
        const test_support::TemporaryFolder folder;
        MotionRecorder recorder({ { "left", "simulated", "1" }, { "right", "simulated", "2" } }, 1000.0, 1);
        recorder.add(0.0, std::array { MotionSample {}, MotionSample { .position = Vec3(3.0, 0.0, 0.0) } });
        const std::filesystem::path file = folder.path / "two.motion";
        write_motion(file, recorder.recording());
        const std::vector<std::string> names(3, "replay:" + file.string());
        DeviceRig in_order(names);
        EXPECT_EQ(in_order.devices()[0]->info().name, "left");
        EXPECT_EQ(in_order.devices()[1]->info().name, "right");
        EXPECT_EQ(in_order.devices()[2]->info().name, "left") << "there is no third";
        constexpr std::array<std::size_t, 1> kSecond { 1 };
        DeviceRig second(std::span<const std::string>(names).first(1), {}, kSecond);
        EXPECT_EQ(second.devices()[0]->info().name, "right");
        EXPECT_EQ(second.devices()[0]->read(0.0, 1e-3).position.x(), 3.0);
        EXPECT_EQ(test_support::message_of([&] { DeviceRig rig(names, {}, kSecond); }),
            "there must be one finger for each device");
    }

    TEST(DeviceRig, KnowsWhatIsLiveAndRefusesTheRest)
    {
        EXPECT_TRUE(is_live_device("touch"));
        EXPECT_TRUE(is_live_device("touch:Left"));
        EXPECT_TRUE(is_live_device("udp:4000"));
        EXPECT_FALSE(is_live_device("replay:x"));
        EXPECT_FALSE(is_live_device("touchpad"));
        for (const std::string name : { "mouse", "udp:", "udp:x", "udp:70000", "udp:127.0.0.1:", "touchpad" })
            EXPECT_EQ(test_support::message_of([&] { DeviceRig rig(std::array { name }); }),
                name
                    + ": there is no such device; there are touch, touch:NAME, touch:#SERIAL, udp:PORT, "
                      "udp:ADDRESS:PORT and replay:FILE");
        EXPECT_EQ(test_support::message_of([] { DeviceRig rig(std::span<const std::string> {}); }),
            "no device was asked for");
    }

} // namespace device_rig_test
} // namespace retractor::haptics
