#pragma once
// Opens real devices by name and ticks them all from one source: the vendor's scheduler when a Touch is among the
// devices, else our own thread. Names of devices:
//
// - touch: the default Touch
// - touch:NAME: a Touch by the vendor's name; touch:#SERIAL: a Touch by its serial number
// - udp:PORT: a device on another computer (udp_bridge.h); udp:ADDRESS:PORT: the same, received on this address of our
//   computer only
// - replay:FILE: a recording, in real time

#include "haptics/device/device.h"
#include "haptics/device/hd_session.h"
#include "haptics/device/tick_thread.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace retractor::haptics {

/// Whether a name means hardware, which works in real time only: touch or udp.
bool is_live_device(const std::string& name);

class DeviceRig {
public:
    /// @param fingers finger of each device. A replay plays the recorded device with this number, or the first device
    /// when the recording has fewer devices. Empty: the order of the names.
    /// @throws InputError on an unknown name; IoError as HdSession, UdpDevice and read_motion
    explicit DeviceRig(
        std::span<const std::string> names, const HdOptions& options = {}, std::span<const std::size_t> fingers = {});

    /// In the order of the names.
    [[nodiscard]] const std::vector<Device*>& devices() const noexcept { return devices_; }
    [[nodiscard]] TickSource& source() noexcept;
    /// Times of the last run. @pre the source is stopped
    [[nodiscard]] const TickTimes& times() const noexcept;
    /// Entries of the Touches' error queue since the last call; empty without a Touch.
    [[nodiscard]] std::vector<HdProblem> take_problems();

private:
    std::unique_ptr<HdSession> touches_;
    std::vector<std::unique_ptr<Device>> others_;
    std::vector<Device*> devices_;
    std::unique_ptr<TickThread> thread_;
};

} // namespace retractor::haptics
