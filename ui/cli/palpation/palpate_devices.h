#pragma once
// Opens haptic devices by name, for commands that touch tissue or pass a device on:
//
// - fixed follows its path, whatever pushes back;
// - simulated is a relaxed hand on a Touch;
// - simulated:firm is a hand that stiffens;
// - touch, touch:NAME and touch:#SERIAL are a 3D Systems Touch;
// - udp:PORT and udp:ADDRESS:PORT are a device on another computer;
// - replay:FILE is a recorded motion.
//
// The prefix "mirrored:" turns the device's x round: a left hand then does what a right hand shows.

#include "haptics/device/device_rig.h"
#include "haptics/device/hand_path.h"
#include "haptics/servo/device_mapping.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Whether a name, mirrored or not, means a device that runs in real time.
bool is_live_hand(const std::string& name);

class HandDevices {
public:
    /// @param path path of fixed and simulated hands
    /// The n-th device of a replay takes the n-th recorded device, where the recording has that many.
    /// @throws InputError on an unknown name; IoError as DeviceRig does, pointing to `retractor doctor` when a Touch
    /// cannot be opened
    HandDevices(const std::vector<std::string>& names, const haptics::HandPath& path);

    [[nodiscard]] const std::vector<haptics::Device*>& devices() const noexcept { return devices_; }
    [[nodiscard]] bool is_mirrored(std::size_t i) const { return mirrored_.at(i); }
    [[nodiscard]] bool is_replay(std::size_t i) const;
    /// The frame of device i in the scene of its recording; nothing when the device is no replay or the recording has
    /// no frame.
    [[nodiscard]] std::optional<haptics::SceneFrame> recorded_frame(std::size_t i) const;
    /// Whether device i runs in real time.
    [[nodiscard]] bool is_live(std::size_t i) const { return live_.at(i); }
    /// Whether any device runs in real time; rig() then ticks all devices.
    [[nodiscard]] bool any_live() const noexcept { return rig_ != nullptr; }
    [[nodiscard]] haptics::DeviceRig& rig() { return *rig_; }
    /// Messages of the Touch devices since the last call.
    [[nodiscard]] std::vector<std::string> take_problems();
    /// Duration of the longest recorded motion (s); 0 without one.
    [[nodiscard]] double replay_seconds() const noexcept { return replay_seconds_; }

private:
    std::unique_ptr<haptics::DeviceRig> rig_;
    std::vector<std::unique_ptr<haptics::Device>> own_;
    std::vector<haptics::Device*> devices_;
    std::vector<std::string> names_; ///< without "mirrored:"
    std::vector<bool> mirrored_, live_;
    double replay_seconds_ = 0.0;
};

/// The device names for --help.
inline constexpr const char* kDeviceHelp
    = "fixed (follows its path against any force), simulated (a relaxed hand on a Touch), simulated:firm, replay:FILE, "
      "touch, touch:NAME, touch:#SERIAL, udp:PORT or udp:ADDRESS:PORT (another computer: see retractor relay); "
      "mirrored:DEVICE mirrors the x axis of that device";

} // namespace retractor::ui::cli
