// The bridge on the loopback address, with a network between its two ends that delays and loses, always the same way.

#include "haptics/device/udp_bridge.h"

#include "haptics/device/simulated_hand.h"
#include "haptics/servo/servo.h"
#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <deque>
#include <memory>
#include <random>
#include <thread>
#include <vector>

namespace retractor::haptics {
namespace udp_bridge_test {

    constexpr double kStep = 1e-3;

    /// Passes datagrams on between a relay and a device, late by some ticks, losing some.
    class Network {
    public:
        explicit Network(std::uint16_t servo_port, unsigned seed = 7)
            : random_(seed)
        {
            to_servo_.send_to("127.0.0.1", servo_port);
        }
        [[nodiscard]] std::uint16_t port() const { return from_device_.port(); }

        void tick()
        {
            ++now_;
            pass(from_device_, to_servo_, outward_);
            from_device_.answer_last();
            pass(to_servo_, from_device_, homeward_);
        }

        int delay = 0; ///< ticks
        int jitter = 0; ///< ticks more, at random: datagrams overtake each other
        double loss = 0.0;
        bool down = false;

    private:
        struct Waiting {
            long due;
            std::vector<std::byte> bytes;
        };
        void pass(DatagramSocket& from, DatagramSocket& to, std::deque<Waiting>& waiting)
        {
            std::array<std::byte, 2048> bytes;
            while (const std::size_t size = from.receive(bytes.data(), bytes.size())) {
                const bool kept = !down && std::uniform_real_distribution<>(0.0, 1.0)(random_) >= loss;
                const long late = delay + std::uniform_int_distribution<>(0, jitter)(random_);
                if (kept)
                    waiting.push_back({ now_ + late, { bytes.begin(), bytes.begin() + static_cast<long>(size) } });
            }
            if (&from == &from_device_)
                from.answer_last();
            for (auto it = waiting.begin(); it != waiting.end();)
                if (it->due <= now_) {
                    to.send(it->bytes.data(), it->bytes.size());
                    it = waiting.erase(it);
                } else
                    ++it;
        }

        DatagramSocket from_device_ { "127.0.0.1", 0 }, to_servo_ { "127.0.0.1", 0 };
        std::deque<Waiting> outward_, homeward_;
        std::mt19937 random_;
        long now_ = 0;
    };

    /// A hand on a far device that presses a wall of 0.1 N/mm here.
    struct Bridge {
        SimulatedHand hand;
        UdpDevice near;
        Network network;
        UdpRelay relay;
        test_support::Wall wall { 0.1 };
        Servo servo;
        std::uint64_t ticks = 0;

        static SimulatedHandOptions pressing()
        {
            SimulatedHandOptions options;
            options.path = HandPath({ { 0.0, Vec3::Zero() }, { 0.3, Vec3(0.0, -6.0, 0.0) } });
            return options;
        }
        static ServoOptions options()
        {
            ServoOptions options;
            options.faults.ramp_up_s = 0.05;
            return options;
        }
        Bridge()
            : hand(pressing())
            , network(near.port())
            , relay(hand, { .servo_port = network.port() })
            , servo({ { .device = &near } }, wall, options())
        {
        }
        void run(int count)
        {
            for (int i = 0; i < count; ++i, ++ticks) {
                const double time = static_cast<double>(ticks) * kStep;
                relay.tick(time, kStep);
                network.tick();
                servo.tick(time, kStep);
                network.tick();
            }
        }
    };

    /// Arm, grip and wall in a row.
    double expected_force()
    {
        const HandParameters grip = relaxed_grip();
        return 6.0 / (1.0 / 0.1 + 1.0 / grip.grip_stiffness.y() + 1.0 / grip.arm_stiffness.y());
    }
    constexpr double kQuantum = 0.01; // N: one step of the encoder on the wall, and then some

    TEST(UdpBridge, CarriesPoseAndForce)
    {
        Bridge bridge;
        bridge.run(2500);
        EXPECT_NEAR(bridge.hand.motor_force().y(), expected_force(), kQuantum);
        EXPECT_EQ(bridge.near.received(), 2500u);
        EXPECT_EQ(bridge.near.lost(), 0u);
        EXPECT_EQ(bridge.servo.latest().fault.kind, FaultKind::none);
    }

    TEST(UdpBridge, BearsDelayDisorderAndLoss)
    {
        Bridge bridge;
        bridge.network.delay = 6;
        bridge.network.jitter = 8;
        bridge.network.loss = 0.2;
        bridge.run(4000);
        EXPECT_NEAR(bridge.hand.motor_force().y(), expected_force(), 2 * kQuantum);
        EXPECT_GT(bridge.near.lost(), 400u);
        EXPECT_EQ(bridge.servo.latest().fault.kind, FaultKind::none);
    }

    TEST(UdpBridge, BothSidesLetGoWhenTheLineFallsSilent)
    {
        Bridge bridge;
        bridge.run(2500);
        const double before = bridge.hand.motor_force().y();
        bridge.network.down = true;
        double last = before, steepest = 0.0;
        for (int i = 0; i < 200; ++i) {
            bridge.run(1);
            steepest = std::max(steepest, std::abs(bridge.hand.motor_force().y() - last));
            last = bridge.hand.motor_force().y();
        }
        EXPECT_EQ(bridge.hand.motor_force().norm(), 0.0);
        EXPECT_LT(steepest, 0.05 * before) << "in a ramp, never at once";
        EXPECT_EQ(bridge.servo.latest().fault.kind, FaultKind::silent);
        bridge.network.down = false;
        bridge.run(200);
        EXPECT_EQ(bridge.hand.motor_force().norm(), 0.0) << "latched until somebody arms it";
        bridge.servo.rearm();
        bridge.run(5000);
        EXPECT_EQ(bridge.servo.passivity(0).share(), 1.0);
        EXPECT_NEAR(bridge.hand.motor_force().y(), expected_force(), kQuantum);
    }

    TEST(UdpBridge, WaitsForADatagramAndNoLongerThanItWasTold)
    {
        UdpDevice device;
        EXPECT_FALSE(device.wait(0.0));
        EXPECT_FALSE(device.wait(0.01));
        DatagramSocket peer("127.0.0.1", 0);
        peer.send_to("127.0.0.1", device.port());
        ASSERT_TRUE(peer.send("x", 1));
        constexpr double kLong = 60.0; // s: a busy machine
        EXPECT_TRUE(device.wait(kLong));
        device.read(0.0, kStep);
        EXPECT_FALSE(device.wait(0.0)) << "it was taken";
    }

    TEST(UdpBridge, TakesNothingThatIsNoneOfIts)
    {
        UdpDevice device;
        DatagramSocket stranger("127.0.0.1", 0);
        stranger.send_to("127.0.0.1", device.port());
        std::array<char, 200> noise {};
        for (const std::size_t size : { 1u, 40u, 104u, 105u, 200u })
            EXPECT_TRUE(stranger.send(noise.data(), size));
        DeviceReading reading;
        constexpr int kPatienceMs = 10000; // datagrams to oneself are there at once, but the machine may be busy
        for (int i = 0; i < kPatienceMs && device.refused() < 5; ++i) {
            reading = device.read(0.0, kStep);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        EXPECT_EQ(device.refused(), 5u);
        EXPECT_EQ(device.received(), 0u);
        EXPECT_EQ(reading.trouble, DeviceTrouble::silent);
        EXPECT_EQ(device.write(Vec3::UnitX()), Vec3::Zero()) << "nobody is there to be pushed";
    }

    TEST(UdpBridge, EitherSideMayBeStartedAnew)
    {
        SimulatedHand hand { Bridge::pressing() };
        auto near = std::make_unique<UdpDevice>();
        const std::uint16_t port = near->port();
        auto relay = std::make_unique<UdpRelay>(hand, UdpRelayOptions { .servo_port = port });
        DeviceReading reading;
        const auto run = [&](int ticks) {
            for (int i = 0; i < ticks; ++i) {
                relay->tick(0.0, kStep);
                reading = near->read(0.0, kStep);
                near->write(Vec3::UnitY());
            }
        };
        run(300);
        EXPECT_EQ(reading.trouble, DeviceTrouble::none);
        EXPECT_EQ(relay->share(), 1.0);
        relay = std::make_unique<UdpRelay>(hand, UdpRelayOptions { .servo_port = port });
        run(15);
        EXPECT_EQ(reading.trouble, DeviceTrouble::silent) << "a low number may still be a late one";
        run(200);
        EXPECT_EQ(reading.trouble, DeviceTrouble::none);
        EXPECT_EQ(relay->share(), 1.0);
        EXPECT_EQ(near->lost(), 0u) << "counted anew";
        near.reset();
        near = std::make_unique<UdpDevice>(UdpDeviceOptions { .port = port });
        run(10);
        run(200);
        EXPECT_EQ(reading.trouble, DeviceTrouble::none);
        EXPECT_EQ(relay->share(), 1.0);
    }

    TEST(UdpBridge, TakesNoPoseThatNoHandHas)
    {
        struct Stretched : Device {
            DeviceInfo own { .name = "stretched" };
            DeviceReading reading;
            const DeviceInfo& info() const noexcept override { return own; }
            DeviceReading read(double, double) noexcept override { return reading; }
            Vec3 write(const Vec3& force) noexcept override { return force; }
        } far;
        UdpDevice near;
        UdpRelay relay(far, { .servo_port = near.port() });
        const auto trouble = [&] {
            relay.tick(0.0, kStep);
            return near.read(0.0, kStep).trouble;
        };
        EXPECT_EQ(trouble(), DeviceTrouble::none);
        far.reading.velocity.x() = 1e7;
        EXPECT_EQ(trouble(), DeviceTrouble::silent);
        far.reading.velocity.setZero();
        far.reading.orientation.setZero(); // what a driver leaves that does not answer
        EXPECT_EQ(trouble(), DeviceTrouble::silent);
        EXPECT_EQ(near.refused(), 2u);
    }

    TEST(UdpBridge, AsksForNoMemory)
    {
        if (!test_support::allocations_are_counted())
            GTEST_SKIP() << "a sanitizer has its own malloc";
        SimulatedHand hand { Bridge::pressing() };
        UdpDevice near;
        UdpRelay relay(hand, { .servo_port = near.port() });
        const std::size_t before = test_support::allocation_count();
        for (int i = 0; i < 200; ++i) {
            relay.tick(i * kStep, kStep);
            near.read(i * kStep, kStep);
            near.write(Vec3::UnitY());
        }
        EXPECT_EQ(test_support::allocation_count(), before);
    }

    TEST(UdpBridge, SaysWhyASocketCannotBe)
    {
        EXPECT_EQ(test_support::message_of([] { DatagramSocket socket("not an address", 0); }),
            "not an address: not a numeric IPv4 address");
        const DatagramSocket taken("127.0.0.1", 0);
        EXPECT_EQ(test_support::message_of([&] { DatagramSocket socket("127.0.0.1", taken.port()); }),
            "127.0.0.1:" + std::to_string(taken.port()) + ": a UDP socket cannot be bound: Address already in use");
    }

} // namespace udp_bridge_test
} // namespace retractor::haptics
