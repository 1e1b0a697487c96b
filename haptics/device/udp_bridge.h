#pragma once
// A device on another computer: its side sends poses and takes forces over UDP, ours is a Device like any other. One
// datagram per tick and direction, each with the newest state only: what is lost is not sent again, what comes late or
// twice is left out. When nothing new has come for a while, both sides let go: the servo by its latch (the reading is
// silent), the device's side by a ramp of its own.
//
// Datagrams, version 1, little-endian, packed:
//   pose (to the servo):   "RTRP" u32 version, u64 number, f64 position[3], f64 velocity[3], f64 quaternion[4] (w x y
//   z),
//                          u32 buttons, u32 trouble
//   force (to the device): "RTRF" u32 version, u64 number, f64 force[3]
// No names, no encryption: for a local network between two computers of one laboratory.

#include "haptics/device/device.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace retractor::haptics {

/// A UDP socket that never waits.
class DatagramSocket {
public:
    /// Bound to `address` ("127.0.0.1", "0.0.0.0"), `port` 0 for any.
    /// @throws IoError naming address and port and the system's reason
    DatagramSocket(const std::string& address, std::uint16_t port);
    ~DatagramSocket();
    DatagramSocket(const DatagramSocket&) = delete;
    DatagramSocket& operator=(const DatagramSocket&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
    /// All that is sent goes there. @throws InputError when it is no numeric IPv4 address
    void send_to(const std::string& address, std::uint16_t port);
    /// To the sender of the last datagram that was accepted.
    void answer_last() noexcept;
    /// @return whether the system took it; without an address nothing is sent
    bool send(const void* data, std::size_t size) noexcept;
    /// @return its size; 0 when none waits. Longer ones are cut, which no format accepts.
    std::size_t receive(void* data, std::size_t room) noexcept;
    /// Not in a tick: waits, in real time, until a datagram waits. @return whether one does
    [[nodiscard]] bool wait(double seconds) const noexcept;

private:
    struct Addresses;
    int socket_ = -1;
    std::uint16_t port_ = 0;
    std::unique_ptr<Addresses> addresses_;
};

struct UdpDeviceOptions {
    std::string address = "127.0.0.1"; ///< ours
    std::uint16_t port = 0; ///< where poses arrive; 0: any, see port()
    double silence_s = 0.02; ///< without a pose, after which a lower number is a peer that was started anew
};

/// The servo's side. read() takes the newest pose that has come; without a new one the reading is silent, and the force
/// is sent all the same. Until the first pose comes it is silent at its workspace's middle.
class UdpDevice : public Device {
public:
    /// @throws IoError when the socket cannot be opened
    explicit UdpDevice(const UdpDeviceOptions& options = {}, const DeviceInfo& info = { .name = "udp" });

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;
    [[nodiscard]] std::uint16_t port() const noexcept { return socket_.port(); }

    /// Between ticks in simulated time, which does not wait for the system's: until a datagram has come.
    [[nodiscard]] bool wait(double seconds) const noexcept { return socket_.wait(seconds); }
    /// Servo thread, or when no tick runs.
    [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; } ///< numbers that never came, or came too late
    [[nodiscard]] std::uint64_t refused() const noexcept
    {
        return refused_;
    } ///< datagrams that were none of ours, or no pose

private:
    DatagramSocket socket_;
    DeviceInfo info_;
    DeviceReading last_;
    double silence_s_, silent_s_ = 0.0;
    std::uint64_t newest_ = 0, sent_ = 0, received_ = 0, lost_ = 0, refused_ = 0;
    std::uint64_t lost_before_ = 0, received_before_ = 0; ///< the peer's last start
    bool seen_ = false;
};

struct UdpRelayOptions {
    std::string servo_address = "127.0.0.1";
    std::uint16_t servo_port = 0;
    double silence_s = 0.02; ///< without a force from the servo; then a lower number is a servo started anew
    double ramp_s = 0.1;
};

/// The device's side: ticked by the device's own tick source, it passes pose and force on.
class UdpRelay : public Ticked {
public:
    /// @param device lives longer
    /// @throws IoError, InputError as DatagramSocket
    UdpRelay(Device& device, const UdpRelayOptions& options);

    void tick(double time_s, double step_s) noexcept override;
    /// As UdpDevice::wait().
    [[nodiscard]] bool wait(double seconds) const noexcept { return socket_.wait(seconds); }
    /// Share of the last force that is put out: 1 while forces come.
    [[nodiscard]] double share() const noexcept { return share_; }

private:
    Device& device_;
    UdpRelayOptions options_;
    DatagramSocket socket_;
    std::uint64_t sent_ = 0, newest_ = 0;
    bool seen_ = false;
    double silent_s_ = 0.0, share_ = 0.0;
    Vec3 force_ = Vec3::Zero();
};

} // namespace retractor::haptics
