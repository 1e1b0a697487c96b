#include "haptics/recording/motion_recording.h"

#include "haptics/recording/motion_file.h"

#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

namespace retractor::haptics {
namespace motion_recording_test {

    namespace fs = std::filesystem;

    MotionSample sample(double seed)
    {
        return { .position = Vec3(seed, 1.0 / 3.0, -seed),
            .orientation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5),
            .velocity = Vec3(1e-300, seed * seed, 0.1),
            .commanded_force = Vec3(0.1 * seed, 0.2, 0.3),
            .applied_force = Vec3(-0.1 * seed, 3.3, 0.0),
            .buttons = 0xf0000001u };
    }

    MotionRecording two_devices(std::size_t ticks)
    {
        SceneFrame turned;
        turned.linear << 0.0, -2.5, 0.0, 2.5, 0.0, 0.0, 0.0, 0.0, -2.5; // mirrored, too
        turned.offset = Vec3(1.0 / 7.0, -120.5, 1e-9);
        turned.clutch_buttons = 2;
        MotionRecorder recorder({ { "left", "Touch", "12-34", turned }, { "right, thumb" } }, 1000.0, ticks);
        for (std::size_t i = 0; i < ticks; ++i)
            recorder.add(1e-3 * static_cast<double>(i),
                std::array { sample(static_cast<double>(i)), sample(-0.7 * static_cast<double>(i)) });
        return recorder.recording();
    }

    void expect_same(const MotionRecording& a, const MotionRecording& b)
    {
        EXPECT_EQ(a.rate_hz, b.rate_hz);
        EXPECT_EQ(a.times_s, b.times_s);
        ASSERT_EQ(a.devices.size(), b.devices.size());
        for (std::size_t d = 0; d < a.devices.size(); ++d) {
            EXPECT_EQ(a.devices[d].name, b.devices[d].name);
            EXPECT_EQ(a.devices[d].model, b.devices[d].model);
            EXPECT_EQ(a.devices[d].serial, b.devices[d].serial);
            ASSERT_EQ(a.devices[d].frame.has_value(), b.devices[d].frame.has_value());
            if (a.devices[d].frame) {
                EXPECT_EQ(a.devices[d].frame->linear, b.devices[d].frame->linear);
                EXPECT_EQ(a.devices[d].frame->offset, b.devices[d].frame->offset);
                EXPECT_EQ(a.devices[d].frame->clutch_buttons, b.devices[d].frame->clutch_buttons);
            }
        }
        ASSERT_EQ(a.samples.size(), b.samples.size());
        for (std::size_t i = 0; i < a.samples.size(); ++i) {
            EXPECT_EQ(a.samples[i].position, b.samples[i].position);
            EXPECT_EQ(a.samples[i].orientation.coeffs(), b.samples[i].orientation.coeffs());
            EXPECT_EQ(a.samples[i].velocity, b.samples[i].velocity);
            EXPECT_EQ(a.samples[i].commanded_force, b.samples[i].commanded_force);
            EXPECT_EQ(a.samples[i].applied_force, b.samples[i].applied_force);
            EXPECT_EQ(a.samples[i].buttons, b.samples[i].buttons);
        }
    }

    std::string content_of(const fs::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    /// Reads back `content` with a change made to it.
    std::string message_after(const fs::path& path, std::string content)
    {
        std::ofstream(path, std::ios::binary) << content;
        return test_support::message_of([&] { read_motion(path); });
    }

    TEST(MotionRecording, ReadsBackBitForBitInBothFormats)
    {
        const test_support::TemporaryFolder folder;
        const MotionRecording recording = two_devices(20);
        for (const char* name : { "motion.bin", "motion.csv" }) {
            write_motion(folder.path / name, recording);
            expect_same(read_motion(folder.path / name), recording);
        }
        EXPECT_EQ(content_of(folder.path / "motion.csv").substr(0, 41), "# retractor motion recording, version 2\n#");
    }

    /// As version 1 wrote it. @pre no device has a frame
    std::string first_version_csv(std::string csv)
    {
        csv.replace(csv.find("version 2"), 9, "version 1");
        return csv;
    }
    std::string first_version_binary(std::string content, const MotionRecording& recording)
    {
        content[8] = 1;
        std::size_t at = 8 + 4 + 4 + 8 + 8;
        for (const RecordedDevice& device : recording.devices) {
            at += 3 * sizeof(std::uint32_t) + device.name.size() + device.model.size() + device.serial.size();
            EXPECT_EQ(content[at], 0);
            content.erase(at, 1); // that there is no frame
        }
        content.resize(content.size() - sizeof(std::uint64_t));
        std::uint64_t hash = 0xcbf29ce484222325u; // FNV-1a
        for (const char c : content)
            hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
        for (int i = 0; i < 8; ++i)
            content += static_cast<char>((hash >> (8 * i)) & 0xffu);
        return content;
    }

    TEST(MotionRecording, FilesOfTheFirstVersionHaveNoFrameButAPointersIsTheScenes)
    {
        const test_support::TemporaryFolder folder;
        for (const char* model : { "Touch", "pointer", "replay of pointer" }) {
            MotionRecording recording = two_devices(3);
            recording.devices[0].frame.reset();
            recording.devices[0].model = model;
            write_motion(folder.path / "new.csv", recording);
            write_motion(folder.path / "new.bin", recording);
            std::ofstream(folder.path / "old.csv") << first_version_csv(content_of(folder.path / "new.csv"));
            std::ofstream(folder.path / "old.bin", std::ios::binary)
                << first_version_binary(content_of(folder.path / "new.bin"), recording);
            expect_same(read_motion(folder.path / "new.csv"), recording); // version 2 says what there is
            if (model != std::string("Touch"))
                recording.devices[0].frame = SceneFrame {};
            for (const char* old : { "old.csv", "old.bin" })
                expect_same(read_motion(folder.path / old), recording);
        }
        EXPECT_EQ(SceneFrame {}.clutch_buttons, 0u);
    }

    TEST(MotionRecording, AFrameThatIsNoneIsRefused)
    {
        const test_support::TemporaryFolder folder;
        MotionRecording recording = two_devices(2);
        const fs::path path = folder.path / "motion.csv";
        write_motion(path, recording);
        const std::string csv = content_of(path);
        const auto after = [&](const std::string& from, const std::string& to) {
            std::string changed = csv;
            changed.replace(changed.find(from), from.size(), to);
            return message_after(path, changed);
        };
        EXPECT_NE(after("0,-2.5,0", "0,-2.6,0").find("no rotation times a scale in line 4"), std::string::npos);
        EXPECT_NE(after("0,-2.5,0", "0,-2.5").find("a frame of other than 13 numbers in line 4"), std::string::npos);
        EXPECT_NE(after("0,-2.5,0", "0,nan,0").find("not finite"), std::string::npos);
        recording.devices[0].frame->linear.setZero();
        write_motion(folder.path / "motion.bin", recording);
        EXPECT_NE(test_support::message_of([&] {
            read_motion(folder.path / "motion.bin");
        }).find("no rotation times a scale"),
            std::string::npos);
    }

    TEST(MotionRecording, CountsWhatFindsNoRoom)
    {
        MotionRecorder recorder({ { "only", "", "" } }, 1000.0, 3);
        for (int i = 0; i < 5; ++i)
            recorder.add(1e-3 * i, std::array { sample(i) });
        EXPECT_EQ(recorder.recording().tick_count(), 3u);
        EXPECT_EQ(recorder.lost_ticks(), 2u);
    }

    TEST(MotionRecording, EveryCutAndEveryFlippedByteOfTheBinaryIsNoticed)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder.path / "motion.bin";
        write_motion(path, two_devices(2));
        const std::string content = content_of(path);
        for (std::size_t length = 0; length < content.size(); length += 5)
            EXPECT_NE(message_after(path, content.substr(0, length)), "") << length;
        for (std::size_t i = 0; i < content.size(); i += 3) {
            std::string damaged = content;
            damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
            EXPECT_NE(message_after(path, damaged), "") << i;
        }
        std::string later = content;
        later[8] = 3;
        EXPECT_NE(message_after(path, later).find("format version 3, this program reads 2"), std::string::npos);
        std::string huge = content;
        huge[22] = 0x7f; // a count of 2^54 ticks
        EXPECT_NE(message_after(path, huge).find("ticks do not fill the file"), std::string::npos);
    }

    TEST(MotionRecording, NamesTheLineThatIsWrong)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder.path / "motion.csv";
        write_motion(path, two_devices(2));
        const std::string content = content_of(path);
        const auto replaced = [&](const std::string& from, const std::string& to) {
            std::string changed = content;
            const std::size_t at = changed.rfind(from);
            EXPECT_NE(at, std::string::npos);
            return message_after(path, changed.replace(at, from.size(), to));
        };
        EXPECT_EQ(message_after(path, "hello\n"),
            path.string()
                + ": not a motion recording: it does not begin with '# retractor motion recording, version 2'");
        EXPECT_EQ(message_after(path, ""), path.string() + ": not a motion recording: the file is empty");
        EXPECT_NE(replaced("4026531841\n", "4026531841").find("cut off in line 10"), std::string::npos);
        EXPECT_NE(replaced("0.001,1,", "0.002,1,").find("different times in line 10"), std::string::npos);
        EXPECT_NE(replaced("0.001,1,", "0.001,0,").find("device 0 where 1 should be in line 10"), std::string::npos);
        EXPECT_NE(replaced("0.001,0,", "-0.001,0,").find("times do not increase in line 9"), std::string::npos);
        EXPECT_NE(replaced("0.3333333333333333", "nan").find("not finite in line 10"), std::string::npos);
        EXPECT_NE(replaced("0.3333333333333333", "0.33x").find("'0.33x' is no number in line 10"), std::string::npos);
        EXPECT_NE(replaced(",4026531841", "").find("there are not 19 fields in line 10"), std::string::npos);
    }

    TEST(MotionRecording, RefusesPosesThatNoHandHas)
    {
        const test_support::TemporaryFolder folder;
        for (const char* name : { "m.bin", "m.csv" }) {
            const auto message_with = [&](const auto& change) {
                MotionRecording recording = two_devices(2);
                change(recording);
                write_motion(folder.path / name, recording);
                return test_support::message_of([&] { read_motion(folder.path / name); });
            };
            const std::string turned
                = message_with([](MotionRecording& r) { r.samples[3].orientation.coeffs() *= 1.002; });
            EXPECT_NE(turned.find("a quaternion that is not of length 1"), std::string::npos) << turned;
            const std::string fast = message_with([](MotionRecording& r) { r.samples[3].velocity.y() = 1e7; });
            EXPECT_NE(fast.find("a speed that no device has"), std::string::npos) << fast;
            for (const double rate : { 0.0, -1000.0 }) {
                const std::string text = message_with([&](MotionRecording& r) { r.rate_hz = rate; });
                EXPECT_NE(text.find("rate_hz is not positive and finite"), std::string::npos) << text;
            }
            EXPECT_NE(message_with([](MotionRecording& r) { r.rate_hz = std::nan(""); }), "");
            EXPECT_EQ(message_with([](MotionRecording& r) { r.samples[3].orientation.coeffs() *= 1.0005; }), "");
        }
    }

    TEST(MotionRecording, RefusesToWriteWhatDoesNotFit)
    {
        const test_support::TemporaryFolder folder;
        MotionRecording recording = two_devices(2);
        recording.samples.pop_back();
        EXPECT_EQ(test_support::message_of([&] { write_motion(folder.path / "m.bin", recording); }),
            (folder.path / "m.bin").string() + ": the recording has 3 samples for 2 ticks of 2 devices");
        EXPECT_EQ(test_support::message_of([&] { read_motion(folder.path / "none.bin"); }),
            (folder.path / "none.bin").string() + ": cannot be opened");
        EXPECT_NE(test_support::message_of([] { MotionRecorder({}, 1000.0, 1); }), "");
        EXPECT_NE(test_support::message_of([] { MotionRecorder({ {} }, 1000.0, 0); }), "");
    }

} // namespace motion_recording_test
} // namespace retractor::haptics
