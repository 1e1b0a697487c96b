#pragma once
// A device on another computer. The device's side sends poses and receives forces over UDP; on our side the device is a
// Device like any other. Each tick sends one datagram per direction, with the newest state only. A lost datagram is not
// sent again; a late or repeated datagram is ignored. When nothing new has arrived for a while, both sides fade the
// force out: the servo by its fault latch (the reading is silent), the device's side by its own ramp.
//
// Datagrams, version 1, little-endian, packed; units mm, mm/s, N:
// - pose (to the servo): "RTRP" u32 version, u64 number, f64 position[3], f64 velocity[3], f64 quaternion[4] (w x y z),
//   u32 buttons, u32 trouble
// - force (to the device): "RTRF" u32 version, u64 number, f64 force[3]
//
// There are no names and no encryption: use the bridge only between two computers of one laboratory's local network.

#include "haptics/device/device.h"

#include <cstdint>
#include <memory>
#include <string>

namespace retractor::haptics {

/// A UDP socket that never blocks.
class DatagramSocket {
public:
    /// Binds the socket to `address` ("127.0.0.1", "0.0.0.0"); `port` 0 means any port.
    /// @throws IoError naming address, port and the system's reason
    DatagramSocket(const std::string& address, std::uint16_t port);
    ~DatagramSocket();
    DatagramSocket(const DatagramSocket&) = delete;
    DatagramSocket& operator=(const DatagramSocket&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
    /// Sets the receiver of all later datagrams. @throws InputError when `address` is no numeric IPv4 address
    void send_to(const std::string& address, std::uint16_t port);
    /// Sets the receiver to the sender of the last accepted datagram.
    void answer_last() noexcept;
    /// @return whether the system accepted the datagram; without a receiver nothing is sent
    bool send(const void* data, std::size_t size) noexcept;
    /// @return the size of the datagram; 0 when none waits. A longer datagram is cut, and no format accepts a cut
    /// datagram.
    std::size_t receive(void* data, std::size_t room) noexcept;
    /// Blocks until a datagram waits, in real time; not for use in a tick. @return whether a datagram waits
    [[nodiscard]] bool wait(double seconds) const noexcept;

private:
    struct Addresses;
    int socket_ = -1;
    std::uint16_t port_ = 0;
    std::unique_ptr<Addresses> addresses_;
};

struct UdpDeviceOptions {
    std::string address = "127.0.0.1"; ///< our address
    std::uint16_t port = 0; ///< port for poses; 0: any, see port()
    double silence_s = 0.02; ///< after this time without a pose, a lower number means that the peer started anew
};

/// The servo's side. read() takes the newest pose; without a new pose the reading is silent, and the force is still
/// sent. Until the first pose arrives the device is silent at the middle of its workspace.
class UdpDevice : public Device {
public:
    /// @throws IoError when the socket cannot be opened
    explicit UdpDevice(const UdpDeviceOptions& options = {}, const DeviceInfo& info = { .name = "udp" });

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;
    [[nodiscard]] std::uint16_t port() const noexcept { return socket_.port(); }

    /// For use between ticks in simulated time, which does not follow real time: blocks until a datagram has arrived.
    [[nodiscard]] bool wait(double seconds) const noexcept { return socket_.wait(seconds); }
    /// Number of accepted datagrams. Servo thread, or when no tick runs; the same holds for lost() and refused().
    [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
    /// Numbers that never arrived or arrived too late.
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }
    /// Datagrams of another format, or with an impossible pose.
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }

private:
    DatagramSocket socket_;
    DeviceInfo info_;
    DeviceReading last_;
    double silence_s_, silent_s_ = 0.0;
    std::uint64_t newest_ = 0, sent_ = 0, received_ = 0, lost_ = 0, refused_ = 0;
    std::uint64_t lost_before_ = 0, received_before_ = 0; ///< counts before the peer's last start
    bool seen_ = false;
};

struct UdpRelayOptions {
    std::string servo_address = "127.0.0.1";
    std::uint16_t servo_port = 0;
    double silence_s = 0.02; ///< after this time without a force, a lower number means that the servo started anew
    double ramp_s = 0.1;
};

/// The device's side, ticked by the device's own tick source: passes pose and force on.
class UdpRelay : public Ticked {
public:
    /// @param device must outlive the relay
    /// @throws IoError, InputError as DatagramSocket
    UdpRelay(Device& device, const UdpRelayOptions& options);

    void tick(double time_s, double step_s) noexcept override;
    /// As UdpDevice::wait().
    [[nodiscard]] bool wait(double seconds) const noexcept { return socket_.wait(seconds); }
    /// Share of the last force that is put out: 1 while forces arrive.
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
