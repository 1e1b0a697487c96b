#pragma once
// Hands by name, for commands that let them touch something or pass them on:
//
//   fixed             goes its path whatever pushes back      touch, touch:NAME, touch:#SERIAL   a 3D Systems Touch
//   simulated         a relaxed hand on a Touch               udp:PORT, udp:ADDRESS:PORT         on another computer
//   simulated:firm    one that stiffens                       replay:FILE                        a recorded motion
//
// With "mirrored:" before it a device's x is turned round: a left hand that does what a right hand shows.

#include "haptics/device/device_rig.h"
#include "haptics/device/hand_path.h"
#include "haptics/servo/device_mapping.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Whether a name, mirrored or not, asks for a device that lives in real time.
bool is_live_hand(const std::string& name);

class HandDevices {
public:
    /// @param path of fixed and simulated hands. The n-th device of a replay takes the n-th recorded one where there
    /// are so many. @throws InputError on an unknown name; IoError as DeviceRig, pointing to `retractor doctor` when a
    /// Touch cannot be opened.
    HandDevices(const std::vector<std::string>& names, const haptics::HandPath& path);

    [[nodiscard]] const std::vector<haptics::Device*>& devices() const noexcept { return devices_; }
    [[nodiscard]] bool is_mirrored(std::size_t i) const { return mirrored_.at(i); }
    [[nodiscard]] bool is_replay(std::size_t i) const;
    /// Where device i stood in the scene it was recorded in; nothing when it is no replay or none that tells.
    [[nodiscard]] std::optional<haptics::SceneFrame> recorded_frame(std::size_t i) const;
    /// Whether device i lives in real time.
    [[nodiscard]] bool is_live(std::size_t i) const { return live_.at(i); }
    /// Whether any does: then rig() ticks them all.
    [[nodiscard]] bool any_live() const noexcept { return rig_ != nullptr; }
    [[nodiscard]] haptics::DeviceRig& rig() { return *rig_; }
    /// What Touches reported since the last call, in words.
    [[nodiscard]] std::vector<std::string> take_problems();
    /// Of the recorded motions, the longest; 0 without any.
    [[nodiscard]] double replay_seconds() const noexcept { return replay_seconds_; }

private:
    std::unique_ptr<haptics::DeviceRig> rig_;
    std::vector<std::unique_ptr<haptics::Device>> own_;
    std::vector<haptics::Device*> devices_;
    std::vector<std::string> names_; ///< without mirrored:
    std::vector<bool> mirrored_, live_;
    double replay_seconds_ = 0.0;
};

/// What may stand for a device, for --help.
inline constexpr const char* kDeviceHelp
    = "fixed (keeps its path whatever pushes back), simulated (a relaxed hand on a Touch), simulated:firm, "
      "replay:FILE, touch, touch:NAME, touch:#SERIAL, udp:PORT or udp:ADDRESS:PORT (another computer: see retractor "
      "relay); mirrored:DEVICE turns its x round";

} // namespace retractor::ui::cli
