#include "haptics/recording/motion_formats.h"

#include "haptics/device/pose_check.h"
#include "mesh/base/error.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace retractor::haptics {

namespace {

    static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

    constexpr std::string_view kMagic { "RTRMOTN\n", 8 };
    constexpr std::uint32_t kFileVersion = 2, kVersionWithoutFrames = 1;
    constexpr std::uint32_t kMaxDevices = 64, kMaxText = 4096;
    constexpr std::size_t kNumbersPerDevice = 16; // per device and tick, before the buttons
    constexpr std::size_t kSampleBytes = kNumbersPerDevice * sizeof(double) + sizeof(std::uint64_t);

    std::uint64_t fnv1a(std::string_view bytes)
    {
        std::uint64_t hash = 0xcbf29ce484222325u;
        for (const char c : bytes)
            hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
        return hash;
    }

    template <class T> void put(std::string& out, const T& value)
    {
        std::array<char, sizeof(T)> bytes;
        std::memcpy(bytes.data(), &value, sizeof(T));
        out.append(bytes.data(), bytes.size());
    }
    void put_text(std::string& out, const std::string& text)
    {
        put(out, static_cast<std::uint32_t>(text.size()));
        out += text;
    }

    /// Reads values from the front and tracks the position for messages.
    class Bytes {
    public:
        Bytes(std::string_view content, const std::string& where)
            : content_(content)
            , where_(where)
        {
        }

        template <class T> T take()
        {
            need(sizeof(T));
            T value;
            std::memcpy(&value, content_.data() + at_, sizeof(T));
            at_ += sizeof(T);
            return value;
        }
        std::string take_text()
        {
            const auto size = take<std::uint32_t>();
            if (size > kMaxText)
                fail("a name of " + std::to_string(size) + " bytes");
            need(size);
            std::string text(content_.substr(at_, size));
            at_ += size;
            return text;
        }
        std::size_t left() const { return content_.size() - at_; }
        std::size_t at() const { return at_; }
        [[noreturn]] void fail(const std::string& what) const
        {
            throw InputError("recording: " + what + " at byte " + std::to_string(at_), where_);
        }

    private:
        void need(std::size_t bytes) const
        {
            if (left() < bytes)
                fail("cut off");
        }
        std::string_view content_;
        const std::string& where_;
        std::size_t at_ = 0;
    };

    void put_frame(std::string& out, const std::optional<SceneFrame>& frame)
    {
        put(out, static_cast<std::uint8_t>(frame ? 1 : 0));
        if (!frame)
            return;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                put(out, frame->linear(row, column));
            put(out, frame->offset[row]);
        }
        put(out, frame->clutch_buttons);
    }

    std::optional<SceneFrame> take_frame(Bytes& bytes)
    {
        const auto there = bytes.take<std::uint8_t>();
        if (there > 1)
            bytes.fail("neither a frame nor none");
        if (there == 0)
            return {};
        SceneFrame frame;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                frame.linear(row, column) = bytes.take<double>();
            frame.offset[row] = bytes.take<double>();
        }
        frame.clutch_buttons = bytes.take<std::uint32_t>();
        if (const std::string problem = problem_of(frame); !problem.empty())
            bytes.fail(problem);
        return frame;
    }

    std::array<double, kNumbersPerDevice> numbers_of(const MotionSample& s)
    {
        const auto& q = s.orientation;
        return { s.position.x(), s.position.y(), s.position.z(), q.w(), q.x(), q.y(), q.z(), s.velocity.x(),
            s.velocity.y(), s.velocity.z(), s.commanded_force.x(), s.commanded_force.y(), s.commanded_force.z(),
            s.applied_force.x(), s.applied_force.y(), s.applied_force.z() };
    }

    MotionSample sample_of(const std::array<double, kNumbersPerDevice>& n, std::uint32_t buttons)
    {
        return { .position = { n[0], n[1], n[2] },
            .orientation = Eigen::Quaterniond(n[3], n[4], n[5], n[6]),
            .velocity = { n[7], n[8], n[9] },
            .commanded_force = { n[10], n[11], n[12] },
            .applied_force = { n[13], n[14], n[15] },
            .buttons = buttons };
    }

} // namespace

bool is_binary_motion(std::string_view content) { return content.substr(0, kMagic.size()) == kMagic; }

std::string motion_to_binary(const MotionRecording& recording)
{
    std::string out(kMagic);
    out.reserve(1024 + recording.samples.size() * kSampleBytes + recording.tick_count() * sizeof(double));
    put(out, kFileVersion);
    put(out, static_cast<std::uint32_t>(recording.devices.size()));
    put(out, static_cast<std::uint64_t>(recording.tick_count()));
    put(out, recording.rate_hz);
    for (const RecordedDevice& device : recording.devices) {
        put_text(out, device.name);
        put_text(out, device.model);
        put_text(out, device.serial);
        put_frame(out, device.frame);
    }
    for (std::size_t tick = 0; tick < recording.tick_count(); ++tick) {
        put(out, recording.times_s[tick]);
        for (std::size_t device = 0; device < recording.devices.size(); ++device) {
            const MotionSample& sample = recording.at(tick, device);
            put(out, numbers_of(sample));
            put(out, static_cast<std::uint64_t>(sample.buttons));
        }
    }
    put(out, fnv1a(out));
    return out;
}

MotionRecording motion_from_binary(std::string_view content, const std::string& where)
{
    Bytes bytes(content, where);
    for (std::size_t i = 0; i < kMagic.size(); ++i)
        bytes.take<char>();
    const auto version = bytes.take<std::uint32_t>();
    if (version != kFileVersion && version != kVersionWithoutFrames)
        bytes.fail(
            "format version " + std::to_string(version) + ", this program reads " + std::to_string(kFileVersion));
    const auto devices = bytes.take<std::uint32_t>();
    if (devices == 0 || devices > kMaxDevices)
        bytes.fail(std::to_string(devices) + " devices");
    const auto ticks = bytes.take<std::uint64_t>();
    MotionRecording recording;
    recording.rate_hz = bytes.take<double>();
    if (!(std::isfinite(recording.rate_hz) && recording.rate_hz > 0.0))
        bytes.fail("rate_hz is not positive and finite");
    for (std::uint32_t d = 0; d < devices; ++d) {
        RecordedDevice device;
        device.name = bytes.take_text();
        device.model = bytes.take_text();
        device.serial = bytes.take_text();
        if (version != kVersionWithoutFrames)
            device.frame = take_frame(bytes);
        recording.devices.push_back(std::move(device));
    }
    if (version == kVersionWithoutFrames)
        place_pointers(recording);
    // Checked before any allocation: a damaged count must not request all memory.
    const std::size_t tick_bytes = sizeof(double) + devices * kSampleBytes;
    if (bytes.left() < sizeof(std::uint64_t) || (bytes.left() - sizeof(std::uint64_t)) % tick_bytes != 0
        || (bytes.left() - sizeof(std::uint64_t)) / tick_bytes != ticks)
        bytes.fail("cut off or damaged: " + std::to_string(ticks) + " ticks do not fill the file");
    std::uint64_t hash = 0;
    std::memcpy(&hash, content.data() + content.size() - sizeof(hash), sizeof(hash));
    if (hash != fnv1a(content.substr(0, content.size() - sizeof(hash))))
        throw InputError("recording: damaged: its checksum is wrong", where);
    recording.times_s.reserve(ticks);
    recording.samples.reserve(ticks * devices);
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        const auto time = bytes.take<double>();
        if (!std::isfinite(time) || (tick > 0 && !(time > recording.times_s.back())))
            bytes.fail("times do not increase");
        recording.times_s.push_back(time);
        for (std::uint32_t d = 0; d < devices; ++d) {
            const auto numbers = bytes.take<std::array<double, kNumbersPerDevice>>();
            for (const double number : numbers)
                if (!std::isfinite(number))
                    bytes.fail("a number that is not finite");
            const auto buttons = bytes.take<std::uint64_t>();
            if (buttons > std::numeric_limits<std::uint32_t>::max())
                bytes.fail("buttons beyond the 32nd");
            recording.samples.push_back(sample_of(numbers, static_cast<std::uint32_t>(buttons)));
            if (!is_rotation(recording.samples.back().orientation))
                bytes.fail("a quaternion that is not of length 1");
            if (!is_speed(recording.samples.back().velocity))
                bytes.fail("a speed that no device has");
        }
    }
    return recording;
}

} // namespace retractor::haptics
