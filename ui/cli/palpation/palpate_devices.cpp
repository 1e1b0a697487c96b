#include "ui/cli/palpation/palpate_devices.h"

#include "haptics/device/simulated_hand.h"
#include "haptics/recording/motion_file.h"
#include "haptics/recording/replay.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>

namespace retractor::ui::cli {

namespace {

    constexpr double kStep = 1e-3; // s
    constexpr std::string_view kMirrored = "mirrored:", kReplay = "replay:";

    /// The path as a recording: a finger that follows its path, whatever pushes back.
    haptics::MotionRecording as_recording(const haptics::HandPath& path)
    {
        haptics::MotionRecording recording;
        recording.devices.push_back({ "fixed", "", "" });
        const auto ticks = static_cast<std::size_t>(std::ceil(path.end_s() / kStep)) + 1;
        for (std::size_t i = 0; i < ticks; ++i) {
            const double t = static_cast<double>(i) * kStep;
            haptics::MotionSample sample;
            sample.position = path.position(t);
            sample.velocity = (path.position(t + kStep) - path.position(t - kStep)) / (2.0 * kStep);
            recording.times_s.push_back(t);
            recording.samples.push_back(sample);
        }
        return recording;
    }

    std::string plain_name(const std::string& name)
    {
        return name.starts_with(kMirrored) ? name.substr(kMirrored.size()) : name;
    }

    std::unique_ptr<haptics::DeviceRig> make_rig(const std::vector<std::string>& names)
    {
        if (names.empty())
            return nullptr;
        try {
            return std::make_unique<haptics::DeviceRig>(names);
        } catch (const IoError& error) {
            const bool touch = std::any_of(
                names.begin(), names.end(), [](const std::string& name) { return name.starts_with("touch"); });
            throw IoError(
                error.what() + std::string(touch ? " (retractor doctor tells what is missing)" : ""), error.where());
        }
    }

} // namespace

bool is_live_hand(const std::string& name) { return haptics::is_live_device(plain_name(name)); }

HandDevices::HandDevices(const std::vector<std::string>& names, const haptics::HandPath& path)
{
    std::vector<std::string> plain, live;
    for (const std::string& name : names) {
        mirrored_.push_back(name.starts_with(kMirrored));
        plain.push_back(plain_name(name));
        live_.push_back(haptics::is_live_device(plain.back()));
        if (live_.back())
            live.push_back(plain.back());
    }
    for (std::size_t i = 0; i < plain.size(); ++i) {
        const std::string& name = plain[i];
        if (live_[i])
            continue;
        if (name == "fixed") {
            own_.push_back(std::make_unique<haptics::ReplayDevice>(as_recording(path), 0));
        } else if (name == "simulated" || name == "simulated:firm") {
            own_.push_back(std::make_unique<haptics::SimulatedHand>(haptics::SimulatedHandOptions {
                .hand = name == "simulated" ? haptics::relaxed_grip() : haptics::firm_grip(), .path = path }));
        } else if (name.starts_with(kReplay)) {
            haptics::MotionRecording recording = haptics::read_motion(name.substr(kReplay.size()));
            const std::size_t which = i < recording.devices.size() ? i : 0;
            auto replay = std::make_unique<haptics::ReplayDevice>(std::move(recording), which);
            replay_seconds_ = std::max(replay_seconds_, replay->duration_s());
            own_.push_back(std::move(replay));
        } else {
            throw InputError("there is no device \"" + name + "\"; there is " + kDeviceHelp, "--device");
        }
    }
    rig_ = make_rig(live);
    names_ = plain;
    for (std::size_t i = 0, mine = 0, rigged = 0; i < plain.size(); ++i)
        devices_.push_back(live_[i] ? rig_->devices()[rigged++] : own_[mine++].get());
}

bool HandDevices::is_replay(std::size_t i) const { return names_.at(i).starts_with(kReplay); }

std::optional<haptics::SceneFrame> HandDevices::recorded_frame(std::size_t i) const
{
    const auto* replay = dynamic_cast<const haptics::ReplayDevice*>(devices_.at(i));
    return replay != nullptr ? replay->frame() : std::nullopt;
}

std::vector<std::string> HandDevices::take_problems()
{
    std::vector<std::string> words;
    if (rig_ != nullptr)
        for (const haptics::HdProblem& problem : rig_->take_problems())
            words.push_back(haptics::describe(problem));
    return words;
}

} // namespace retractor::ui::cli
