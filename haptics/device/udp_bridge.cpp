#include "haptics/device/udp_bridge.h"

#include "haptics/device/pose_check.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstring>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace retractor::haptics {

namespace {

    static_assert(std::endian::native == std::endian::little, "datagrams carry numbers as they lie in memory");

    constexpr std::uint32_t kPacketVersion = 1;
    constexpr std::uint32_t kPoseMark = 0x50525452u, kForceMark = 0x46525452u; // "RTRP", "RTRF"
    constexpr int kWaiting = 1000; ///< datagrams read in one tick; a flood must not hold up the servo

    struct PoseDatagram {
        std::uint32_t mark, version;
        std::uint64_t number;
        std::array<double, 3> position, velocity;
        std::array<double, 4> quaternion;
        std::uint32_t buttons, trouble;
    };
    static_assert(sizeof(PoseDatagram) == 104);

    struct ForceDatagram {
        std::uint32_t mark, version;
        std::uint64_t number;
        std::array<double, 3> force;
    };
    static_assert(sizeof(ForceDatagram) == 40);

    Vec3 vector_of(const std::array<double, 3>& v) { return { v[0], v[1], v[2] }; }
    std::array<double, 3> array_of(const Vec3& v) { return { v.x(), v.y(), v.z() }; }

    sockaddr_in address_of(const std::string& address, std::uint16_t port)
    {
        sockaddr_in result {};
        result.sin_family = AF_INET;
        result.sin_port = htons(port);
        if (::inet_pton(AF_INET, address.c_str(), &result.sin_addr) != 1)
            throw InputError("not a numeric IPv4 address", address);
        return result;
    }

    sockaddr* plain(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

} // namespace

struct DatagramSocket::Addresses {
    sockaddr_in peer {}, last {};
    bool has_peer = false, has_last = false;
};

DatagramSocket::DatagramSocket(const std::string& address, std::uint16_t port)
    : addresses_(std::make_unique<Addresses>())
{
    sockaddr_in own = address_of(address, port);
    const auto fail = [&](const char* what) {
        const std::string reason = std::strerror(errno);
        if (socket_ >= 0)
            ::close(socket_);
        throw IoError(std::string(what) + ": " + reason, address + ":" + std::to_string(port));
    };
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket_ < 0)
        fail("a UDP socket cannot be opened");
    if (::bind(socket_, plain(own), sizeof(own)) != 0)
        fail("a UDP socket cannot be bound");
    socklen_t size = sizeof(own);
    if (::getsockname(socket_, plain(own), &size) != 0)
        fail("a UDP socket has no name");
    port_ = ntohs(own.sin_port);
}

DatagramSocket::~DatagramSocket() { ::close(socket_); }

void DatagramSocket::send_to(const std::string& address, std::uint16_t port)
{
    addresses_->peer = address_of(address, port);
    addresses_->has_peer = true;
}

void DatagramSocket::answer_last() noexcept
{
    addresses_->peer = addresses_->last;
    addresses_->has_peer = addresses_->has_last;
}

bool DatagramSocket::send(const void* data, std::size_t size) noexcept
{
    return addresses_->has_peer
        && ::sendto(socket_, data, size, MSG_DONTWAIT, plain(addresses_->peer), sizeof(sockaddr_in))
        == static_cast<ssize_t>(size);
}

std::size_t DatagramSocket::receive(void* data, std::size_t room) noexcept
{
    socklen_t size = sizeof(sockaddr_in);
    const ssize_t got = ::recvfrom(socket_, data, room, MSG_DONTWAIT, plain(addresses_->last), &size);
    if (got <= 0)
        return 0;
    addresses_->has_last = true;
    return static_cast<std::size_t>(got);
}

bool DatagramSocket::wait(double seconds) const noexcept
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    pollfd socket { .fd = socket_, .events = POLLIN, .revents = 0 };
    for (;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
        if (::poll(&socket, 1, static_cast<int>(std::max<std::int64_t>(0, left.count()))) > 0)
            return (socket.revents & POLLIN) != 0;
        if (left.count() <= 0)
            return false; // interrupted by a signal: wait on
    }
}

UdpDevice::UdpDevice(const UdpDeviceOptions& options, const DeviceInfo& info)
    : socket_(options.address, options.port)
    , info_(info)
    , silence_s_(options.silence_s)
{
    if (info_.model.empty())
        info_.model = "device on another computer";
    // One tick to the device and one back. The delay of the network is unknown.
    info_.limits.delay_ticks = std::max(info_.limits.delay_ticks, 2);
    last_.position = 0.5 * (info_.workspace.low + info_.workspace.high);
    last_.trouble = DeviceTrouble::silent;
}

DeviceReading UdpDevice::read(double, double step_s) noexcept
{
    last_.trouble = DeviceTrouble::silent;
    silent_s_ += step_s;
    // One byte more than a pose, so that longer datagrams can be recognised.
    std::array<std::byte, sizeof(PoseDatagram) + 1> bytes;
    for (int i = 0; i < kWaiting; ++i) {
        const std::size_t size = socket_.receive(bytes.data(), bytes.size());
        if (size == 0)
            break;
        PoseDatagram pose;
        std::memcpy(&pose, bytes.data(), sizeof(pose));
        const auto& q = pose.quaternion;
        const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
        if (size != sizeof(pose) || pose.mark != kPoseMark || pose.version != kPacketVersion
            || pose.trouble > static_cast<std::uint32_t>(DeviceTrouble::lost) || !is_rotation(turn)
            || !is_speed(vector_of(pose.velocity))) {
            ++refused_;
            continue;
        }
        ++received_;
        if (seen_ && pose.number <= newest_) {
            if (silent_s_ <= silence_s_)
                continue; // late or repeated
            lost_before_ = lost_; // the peer started anew and counts from 1
            received_before_ = received_ - pose.number; // as if all datagrams of the new start had arrived
        }
        newest_ = pose.number;
        seen_ = true;
        silent_s_ = 0.0;
        socket_.answer_last();
        last_ = { .position = vector_of(pose.position),
            .velocity = vector_of(pose.velocity),
            .orientation = turn.toRotationMatrix(),
            .buttons = pose.buttons,
            .trouble = static_cast<DeviceTrouble>(pose.trouble) };
    }
    const std::uint64_t came = received_ - received_before_;
    lost_ = lost_before_ + (seen_ && newest_ > came ? newest_ - came : 0);
    return last_;
}

Vec3 UdpDevice::write(const Vec3& force) noexcept
{
    const Vec3 applied = force.allFinite() ? clamped(force, info_.limits.max_force) : Vec3(Vec3::Zero());
    const ForceDatagram datagram { kForceMark, kPacketVersion, ++sent_, array_of(applied) };
    return socket_.send(&datagram, sizeof(datagram)) ? applied : Vec3(Vec3::Zero());
}

UdpRelay::UdpRelay(Device& device, const UdpRelayOptions& options)
    : device_(device)
    , options_(options)
    , socket_("0.0.0.0", 0)
{
    socket_.send_to(options.servo_address, options.servo_port);
}

void UdpRelay::tick(double time_s, double step_s) noexcept
{
    const DeviceReading reading = device_.read(time_s, step_s);
    const Eigen::Quaterniond q(reading.orientation);
    const PoseDatagram pose { kPoseMark, kPacketVersion, ++sent_, array_of(reading.position),
        array_of(reading.velocity), { q.w(), q.x(), q.y(), q.z() }, reading.buttons,
        static_cast<std::uint32_t>(reading.trouble) };
    socket_.send(&pose, sizeof(pose));
    silent_s_ += step_s;
    std::array<std::byte, sizeof(ForceDatagram) + 1> bytes;
    for (int i = 0; i < kWaiting; ++i) {
        const std::size_t size = socket_.receive(bytes.data(), bytes.size());
        if (size == 0)
            break;
        ForceDatagram force;
        std::memcpy(&force, bytes.data(), sizeof(force));
        if (size != sizeof(force) || force.mark != kForceMark || force.version != kPacketVersion
            || (seen_ && force.number <= newest_ && silent_s_ <= options_.silence_s)
            || !vector_of(force.force).allFinite())
            continue;
        newest_ = force.number;
        seen_ = true;
        silent_s_ = 0.0;
        force_ = vector_of(force.force);
    }
    const bool silent = !seen_ || silent_s_ > options_.silence_s;
    share_ = std::clamp(share_ + (silent ? -step_s : step_s) / options_.ramp_s, 0.0, 1.0);
    device_.write(share_ * force_);
}

} // namespace retractor::haptics
