#pragma once
// Real devices by name, and the one source that ticks them all: the vendor's scheduler when a Touch is among them, our
// own thread otherwise.
//
//   touch             the default Touch           udp:PORT      a device on another computer (udp_bridge.h)
//   touch:NAME        by the vendor's name        replay:FILE   a recording, in real time
//   touch:#SERIAL     by its serial number     udp:ADDRESS:PORT  the same, heard on this address of ours alone

#include "haptics/device/device.h"
#include "haptics/device/hd_session.h"
#include "haptics/device/tick_thread.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace retractor::haptics {

/// Whether a name asks for hardware, which only lives in real time: touch or udp.
bool is_live_device(const std::string& name);

class DeviceRig {
public:
    /// @throws InputError on a name that is none of these; IoError as HdSession, UdpDevice and read_motion
    /// @param fingers of each device: a recording is played as its finger's device, or as the first one where there are
    /// not so many; empty: the names' order
    explicit DeviceRig(
        std::span<const std::string> names, const HdOptions& options = {}, std::span<const std::size_t> fingers = {});

    /// In the order of the names.
    [[nodiscard]] const std::vector<Device*>& devices() const noexcept { return devices_; }
    [[nodiscard]] TickSource& source() noexcept;
    /// Of the last run. @pre it is stopped
    [[nodiscard]] const TickTimes& times() const noexcept;
    /// What the Touches' error queue told since the last call; empty without one.
    [[nodiscard]] std::vector<HdProblem> take_problems();

private:
    std::unique_ptr<HdSession> touches_;
    std::vector<std::unique_ptr<Device>> others_;
    std::vector<Device*> devices_;
    std::unique_ptr<TickThread> thread_;
};

} // namespace retractor::haptics
