#include "haptics/device/device_rig.h"

#include "haptics/device/udp_bridge.h"
#include "haptics/recording/motion_file.h"
#include "haptics/recording/replay.h"
#include "mesh/base/error.h"

#include <charconv>

namespace retractor::haptics {

namespace {

    constexpr std::string_view kTouch = "touch", kUdp = "udp:", kReplay = "replay:";

    bool is_touch(std::string_view name) { return name == kTouch || name.starts_with("touch:"); }

    HdDeviceRequest request_of(const std::string& name)
    {
        const std::string which = name.size() > kTouch.size() ? name.substr(kTouch.size() + 1) : std::string();
        return which.starts_with('#') ? HdDeviceRequest { .serial = which.substr(1) }
                                      : HdDeviceRequest { .name = which };
    }

    [[noreturn]] void refuse(const std::string& name)
    {
        throw InputError("there is no such device; there are touch, touch:NAME, touch:#SERIAL, udp:PORT, "
                         "udp:ADDRESS:PORT and replay:FILE",
            name);
    }

    /// "udp:4000", "udp:127.0.0.1:4000".
    UdpDeviceOptions udp_of(const std::string& name)
    {
        UdpDeviceOptions options { .address = "0.0.0.0" };
        std::string_view rest = std::string_view(name).substr(kUdp.size());
        if (const std::size_t colon = rest.rfind(':'); colon != std::string_view::npos) {
            options.address = rest.substr(0, colon);
            rest.remove_prefix(colon + 1);
        }
        const char* const end = rest.data() + rest.size();
        const auto [stop, error] = std::from_chars(rest.data(), end, options.port);
        if (stop != end || error != std::errc() || options.port == 0)
            refuse(name);
        return options;
    }

    std::unique_ptr<Device> make_other(const std::string& name, std::size_t finger)
    {
        if (name.starts_with(kReplay)) {
            MotionRecording recording = read_motion(name.substr(kReplay.size()));
            const std::size_t which = finger < recording.devices.size() ? finger : 0;
            return std::make_unique<ReplayDevice>(std::move(recording), which);
        }
        if (name.starts_with(kUdp))
            return std::make_unique<UdpDevice>(udp_of(name));
        refuse(name);
    }

} // namespace

bool is_live_device(const std::string& name) { return is_touch(name) || name.starts_with(kUdp); }

DeviceRig::DeviceRig(std::span<const std::string> names, const HdOptions& options, std::span<const std::size_t> fingers)
{
    if (names.empty())
        throw InputError("no device was asked for");
    if (!fingers.empty() && fingers.size() != names.size())
        throw InputError("there must be one finger for each device");
    std::vector<HdDeviceRequest> requests;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (is_touch(names[i]))
            requests.push_back(request_of(names[i]));
        else
            others_.push_back(make_other(names[i], fingers.empty() ? i : fingers[i]));
    }
    if (requests.empty())
        thread_ = std::make_unique<TickThread>();
    else
        touches_ = std::make_unique<HdSession>(requests, options);
    std::size_t touch = 0, other = 0;
    for (const std::string& name : names)
        devices_.push_back(is_touch(name) ? &touches_->device(touch++) : others_[other++].get());
}

TickSource& DeviceRig::source() noexcept
{
    return touches_ ? static_cast<TickSource&>(*touches_) : static_cast<TickSource&>(*thread_);
}

const TickTimes& DeviceRig::times() const noexcept { return touches_ ? touches_->times() : thread_->times(); }

std::vector<HdProblem> DeviceRig::take_problems()
{
    return touches_ ? touches_->take_problems() : std::vector<HdProblem> {};
}

} // namespace retractor::haptics
