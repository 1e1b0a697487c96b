#pragma once
// 3D Systems Touch devices (and older Phantoms) through HDAPI: one session, one scheduler callback for all of them.

#include "haptics/device/device.h"
#include "haptics/device/hd_library.h"
#include "haptics/device/tick_statistics.h"

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace retractor::haptics {

/// Which device: by the name in the vendor's configuration, by serial number, or the default one when both are empty.
struct HdDeviceRequest {
    std::string name = {};
    std::string serial = {};
};

/// One entry of HDAPI's error queue, understood.
struct HdProblem {
    hd::ErrorCode code = 0;
    int internal = 0;
    std::size_t device = 0; ///< index in the session; the number of devices when it belongs to none
    DeviceTrouble trouble = DeviceTrouble::none; ///< what it means for the servo; none: our call was wrong, or no harm
};
/// "0x0302, communication error: device lost"; numbers and our words, where the library's are not at hand.
std::string describe(const HdProblem& problem);
DeviceTrouble trouble_of(hd::ErrorCode code) noexcept;

struct HdOptions {
    std::vector<std::string> libraries = default_hd_libraries();
    unsigned rate_hz = 1000;
    double ramp_up_s = 0.5,
           ramp_down_s = 0.1; ///< of the force, beside the servo's own: a session may be used without one
    std::chrono::milliseconds calibration_limit { 15000 }; ///< for a person to put the stylus into its inkwell
    TickTimer::Clock clock = tick_clock_s; ///< another one for tests that run the scheduler by hand
    bool frames_overlap = true; ///< all devices' frames are open while the tissue is asked; off: each is closed at
                                ///< once, and forces are a tick later
};

class HdSession : public TickSource {
public:
    /// Loads the library, initialises and calibrates the devices, and reads what they can do. Force stays off.
    /// @throws IoError naming library, device and HDAPI's error, with what to do
    HdSession(const std::vector<HdDeviceRequest>& requests, const HdOptions& options = {});
    /// Stops, and disables the devices.
    ~HdSession() override;

    [[nodiscard]] std::size_t device_count() const noexcept { return devices_.size(); }
    /// To be read and written within the tick only.
    [[nodiscard]] Device& device(std::size_t i);
    [[nodiscard]] const std::string& library() const noexcept { return library_.name(); }

    void start(Ticked& ticked) override;
    /// Force fades, then the callback, the scheduler and the force output end, in this order.
    void stop() noexcept override;

    /// What the error queue told since the last call, at most 64 entries. One thread, not the servo's.
    [[nodiscard]] std::vector<HdProblem> take_problems();
    /// Of the last run. @pre it is stopped
    [[nodiscard]] const TickTimes& times() const noexcept { return timer_->times(); }

private:
    class Touch;

    static std::uint32_t callback(void* session) noexcept;
    void run_tick() noexcept;
    void drain_errors() noexcept;
    void initialise(const HdDeviceRequest& request);
    hd::Handle handle_of(const HdDeviceRequest& request);
    void calibrate(Touch& touch);
    void check_queue(const std::string& what) const;

    HdLibrary library_;
    const hd::Functions& hd_;
    HdOptions options_;
    std::vector<std::unique_ptr<Touch>> devices_;
    std::unique_ptr<TickTimer> timer_;
    Ticked* ticked_ = nullptr;
    hd::SchedulerHandle scheduled_ = 0;
    bool running_ = false;
    double gain_ = 0.0;
    std::atomic<bool> stopping_ { false }, faded_ { false };
    std::atomic<std::uint64_t> calls_ { 0 }; ///< of the callback

    static constexpr std::size_t kProblems = 64;
    std::array<HdProblem, kProblems> problems_ {};
    std::atomic<std::size_t> written_ { 0 }, read_ { 0 };
};

} // namespace retractor::haptics
