#include "haptics/recording/motion_formats.h"

#include "haptics/device/pose_check.h"
#include "mesh/base/error.h"

#include <array>
#include <charconv>
#include <cmath>

namespace retractor::haptics {

namespace {

    constexpr std::string_view kFirstLine = "# retractor motion recording, version 2",
                               kFirstLineBefore = "# retractor motion recording, version 1";
    constexpr std::string_view kRate = "# rate_hz: ", kDevice = "# device: ", kFrame = "# scene_from_device: ";
    constexpr std::string_view kColumns = "t_s,device,x_mm,y_mm,z_mm,qw,qx,qy,qz,vx_mm_s,vy_mm_s,vz_mm_s,"
                                          "commanded_x_N,commanded_y_N,commanded_z_N,applied_x_N,applied_y_N,"
                                          "applied_z_N,buttons";
    constexpr std::size_t kFields = 19;

    void put(std::string& out, double value)
    {
        std::array<char, 32> text;
        // Shortest text that reads back exactly.
        const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
        out.append(text.data(), end);
        out += ',';
    }
    template <class Vector> void put_all(std::string& out, const Vector& v)
    {
        for (Eigen::Index i = 0; i < v.size(); ++i)
            put(out, v[i]);
    }

    /// Replaces characters that would end a field or a line by blanks, because names are free text.
    std::string one_field(std::string text)
    {
        for (char& c : text)
            if (c == '\n' || c == '\r' || c == ';')
                c = ' ';
        return text;
    }

    struct Line {
        std::string_view text;
        std::size_t number;
        const std::string& where;

        [[noreturn]] void fail(const std::string& what) const
        {
            throw InputError("recording: " + what + " in line " + std::to_string(number), where);
        }
    };

    template <class Number> Number parse(const Line& line, std::string_view text)
    {
        Number value {};
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size())
            line.fail("'" + std::string(text.substr(0, 40)) + "' is no number");
        if constexpr (std::is_floating_point_v<Number>)
            if (!std::isfinite(value))
                line.fail("a number that is not finite");
        return value;
    }

    std::array<std::string_view, kFields> fields_of(const Line& line)
    {
        std::array<std::string_view, kFields> fields;
        std::string_view rest = line.text;
        for (std::size_t i = 0; i < kFields; ++i) {
            const std::size_t comma = rest.find(',');
            if ((comma == std::string_view::npos) != (i + 1 == kFields))
                line.fail("there are not " + std::to_string(kFields) + " fields");
            fields[i] = rest.substr(0, comma);
            rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
        }
        return fields;
    }

    RecordedDevice device_of(std::string_view text)
    {
        RecordedDevice device;
        for (std::string* part : { &device.name, &device.model, &device.serial }) {
            const std::size_t end = text.find("; ");
            *part = std::string(text.substr(0, end));
            text = end == std::string_view::npos ? std::string_view() : text.substr(end + 2);
        }
        return device;
    }

    /// Three rows of four numbers, then the clutch's buttons.
    SceneFrame frame_from(const Line& line, std::string_view text)
    {
        constexpr int kNumbers = 13;
        SceneFrame frame;
        for (int i = 0; i < kNumbers; ++i) {
            const std::size_t comma = text.find(',');
            if ((comma == std::string_view::npos) != (i + 1 == kNumbers))
                line.fail("a frame of other than " + std::to_string(kNumbers) + " numbers");
            const std::string_view field = text.substr(0, comma);
            if (i + 1 == kNumbers)
                frame.clutch_buttons = parse<std::uint32_t>(line, field);
            else
                (i % 4 == 3 ? frame.offset[i / 4] : frame.linear(i / 4, i % 4)) = parse<double>(line, field);
            text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
        }
        if (const std::string problem = problem_of(frame); !problem.empty())
            line.fail(problem);
        return frame;
    }

    void put_frame(std::string& out, const SceneFrame& frame)
    {
        out += kFrame;
        for (int row = 0; row < 3; ++row) {
            put_all(out, frame.linear.row(row));
            put(out, frame.offset[row]);
        }
        out += std::to_string(frame.clutch_buttons) + "\n";
    }

    void add_row(MotionRecording& recording, const Line& line)
    {
        const auto fields = fields_of(line);
        const auto time = parse<double>(line, fields[0]);
        const auto device = parse<std::size_t>(line, fields[1]);
        const std::size_t expected = recording.samples.size() % recording.devices.size();
        if (device != expected)
            line.fail("device " + std::to_string(device) + " where " + std::to_string(expected) + " should be");
        if (device == 0) {
            if (!recording.times_s.empty() && !(time > recording.times_s.back()))
                line.fail("times do not increase");
            recording.times_s.push_back(time);
        } else if (time != recording.times_s.back())
            line.fail("the devices of one tick have different times");
        std::array<double, 16> n;
        for (std::size_t i = 0; i < n.size(); ++i)
            n[i] = parse<double>(line, fields[2 + i]);
        recording.samples.push_back({ .position = { n[0], n[1], n[2] },
            .orientation = Eigen::Quaterniond(n[3], n[4], n[5], n[6]),
            .velocity = { n[7], n[8], n[9] },
            .commanded_force = { n[10], n[11], n[12] },
            .applied_force = { n[13], n[14], n[15] },
            .buttons = parse<std::uint32_t>(line, fields[18]) });
        if (!is_rotation(recording.samples.back().orientation))
            line.fail("a quaternion that is not of length 1");
        if (!is_speed(recording.samples.back().velocity))
            line.fail("a speed that no device has");
    }

} // namespace

std::string motion_to_csv(const MotionRecording& recording)
{
    std::string out(kFirstLine);
    out += "\n" + std::string(kRate);
    put(out, recording.rate_hz);
    out.back() = '\n';
    for (const RecordedDevice& d : recording.devices) {
        out += std::string(kDevice) + one_field(d.name) + "; " + one_field(d.model) + "; " + one_field(d.serial) + "\n";
        if (d.frame)
            put_frame(out, *d.frame);
    }
    out += std::string(kColumns) + "\n";
    for (std::size_t tick = 0; tick < recording.tick_count(); ++tick)
        for (std::size_t device = 0; device < recording.devices.size(); ++device) {
            const MotionSample& s = recording.at(tick, device);
            put(out, recording.times_s[tick]);
            out += std::to_string(device) + ",";
            put_all(out, s.position);
            put(out, s.orientation.w());
            put_all(out, s.orientation.vec());
            put_all(out, s.velocity);
            put_all(out, s.commanded_force);
            put_all(out, s.applied_force);
            out += std::to_string(s.buttons) + "\n";
        }
    return out;
}

MotionRecording motion_from_csv(std::string_view content, const std::string& where)
{
    MotionRecording recording;
    bool in_rows = false, first_version = false;
    std::size_t number = 0;
    while (!content.empty()) {
        const std::size_t end = content.find('\n');
        const Line line { content.substr(0, end), ++number, where };
        if (end == std::string_view::npos)
            line.fail("cut off");
        content.remove_prefix(end + 1);
        if (number == 1) {
            if (line.text != kFirstLine && line.text != kFirstLineBefore)
                throw InputError(
                    "not a motion recording: it does not begin with '" + std::string(kFirstLine) + "'", where);
            first_version = line.text == kFirstLineBefore;
        } else if (in_rows)
            add_row(recording, line);
        else if (line.text.starts_with(kRate)) {
            recording.rate_hz = parse<double>(line, line.text.substr(kRate.size()));
            if (!(recording.rate_hz > 0.0))
                line.fail("rate_hz is not positive and finite");
        } else if (line.text.starts_with(kDevice))
            recording.devices.push_back(device_of(line.text.substr(kDevice.size())));
        else if (line.text.starts_with(kFrame) && !recording.devices.empty() && !recording.devices.back().frame)
            recording.devices.back().frame = frame_from(line, line.text.substr(kFrame.size()));
        else if (line.text == kColumns && !recording.devices.empty())
            in_rows = true;
        else
            line.fail("neither a header nor the names of the columns");
    }
    const Line last { {}, number, where };
    if (number == 0)
        throw InputError("not a motion recording: the file is empty", where);
    if (!in_rows)
        last.fail("cut off");
    if (first_version)
        place_pointers(recording);
    if (recording.samples.size() != recording.tick_count() * recording.devices.size())
        last.fail("the last tick is cut off");
    return recording;
}

} // namespace retractor::haptics
