#include "haptics/device/tick_thread.h"
#include "haptics/device/udp_bridge.h"
#include "mesh/base/error.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/palpation/palpate_devices.h"
#include "ui/cli/palpation/palpate_run.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <chrono>
#include <limits>
#include <memory>
#include <thread>

namespace retractor::ui::cli {

namespace {

    constexpr const char* kRelayedHelp = "touch, touch:NAME, touch:#SERIAL, replay:FILE, simulated (a relaxed hand on "
                                         "a Touch), simulated:firm or fixed (follows its path against any force)";

    struct RelayOptions {
        std::vector<std::string> devices, to;
        double seconds = 0.0;
    };

    /// Relays of several devices; one source ticks them all.
    class Relays : public haptics::Ticked {
    public:
        void add(haptics::Device& device, const haptics::UdpRelayOptions& options)
        {
            relays_.push_back(std::make_unique<haptics::UdpRelay>(device, options));
        }
        void tick(double time_s, double step_s) noexcept override
        {
            for (const auto& relay : relays_)
                relay->tick(time_s, step_s);
        }
        /// When no tick runs.
        double share(std::size_t i) const { return relays_[i]->share(); }

    private:
        std::vector<std::unique_ptr<haptics::UdpRelay>> relays_;
    };

    /// Parses "192.168.0.7:4000".
    haptics::UdpRelayOptions address_of(const std::string& text)
    {
        const std::size_t colon = text.rfind(':');
        haptics::UdpRelayOptions options;
        if (colon != std::string::npos) {
            options.servo_address = text.substr(0, colon);
            const char *first = text.data() + colon + 1, *last = text.data() + text.size();
            const auto [end, error] = std::from_chars(first, last, options.servo_port);
            if (end == last && error == std::errc() && options.servo_port != 0)
                return options;
        }
        throw InputError("is ADDRESS:PORT, such as 192.168.0.7:4000, got \"" + text + '"', "--to");
    }

    Outcome relay(const RelayOptions& options, const Job& job)
    {
        if (options.to.size() != options.devices.size())
            throw InputError(std::to_string(options.devices.size()) + " devices need as many addresses, not "
                    + std::to_string(options.to.size()),
                "--to");
        for (const std::string& name : options.devices)
            if (name.starts_with("mirrored:"))
                throw InputError(
                    "a hand is mirrored on the computer that receives it: give mirrored:udp:PORT to retractor palpate",
                    "--device " + name);
        // A simulated hand has no tissue here, so it moves to and fro about the middle of its workspace.
        constexpr int kTimes = 100;
        HandDevices hands(
            options.devices, press_path({ .depth_mm = 5.0, .radius_mm = 0.0, .seconds = 2.0, .times = kTimes }));
        Relays relays;
        for (std::size_t i = 0; i < options.devices.size(); ++i)
            relays.add(*hands.devices()[i], address_of(options.to[i]));
        haptics::TickThread thread;
        haptics::TickSource& source = hands.any_live() ? hands.rig().source() : thread;
        source.start(relays);
        const auto begun = std::chrono::steady_clock::now();
        const auto since
            = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); };
        const double until = options.seconds > 0.0 ? options.seconds : std::numeric_limits<double>::infinity();
        while (since() < until && !job.cancelled()) {
            constexpr std::chrono::milliseconds kLook(50);
            std::this_thread::sleep_for(kLook);
            job.report("relay", options.seconds > 0.0 ? since() / until : 0.0);
        }
        source.stop();
        const haptics::TickTimes& times = hands.any_live() ? hands.rig().times() : thread.times();
        Outcome outcome;
        outcome.document = { { "ticks", times.ticks }, { "missed", times.missed }, { "devices", Json::array() } };
        outcome.text = std::to_string(times.ticks) + " ticks, " + std::to_string(times.missed) + " missed\n";
        for (std::size_t i = 0; i < options.devices.size(); ++i) {
            const bool answered = relays.share(i) > 0.0;
            outcome.document["devices"].push_back({ { "device", options.devices[i] }, { "to", options.to[i] },
                { "forces_coming_at_the_end", answered } });
            outcome.text += options.devices[i] + " to " + options.to[i]
                + (answered ? ": forces arrived until the end\n" : ": no forces arrived at the end\n");
        }
        if (const std::vector<std::string> problems = hands.take_problems(); !problems.empty()) {
            outcome.document["device_problems"] = problems;
            for (const std::string& problem : problems)
                outcome.text += "a device reported: " + problem + "\n";
        }
        return outcome;
    }

} // namespace

void add_relay_command(Commands& commands)
{
    auto options = std::make_shared<RelayOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "relay", "Pass a haptic device on to another computer, where retractor palpate --device udp:PORT receives it");
    command->footer("Example: retractor relay --device touch --to 192.168.0.7:4000\n"
                    "         (and there: retractor palpate aorta.json --press normal --device udp:4000)\n"
                    "Poses and forces are not encrypted. Use the relay only in the local network of one laboratory.");
    command->add_option("--device", options->devices, std::string(kRelayedHelp) + "; repeatable")->required();
    command->add_option("--to", options->to, "ADDRESS:PORT of the other computer, one per device")->required();
    command->add_option("--seconds", options->seconds, "Duration, s (default: until the command is interrupted)")
        ->check(in_range(0.1, 1e6));
    commands.on(command, [options](const Job& job) { return relay(*options, job); });
}

} // namespace retractor::ui::cli
