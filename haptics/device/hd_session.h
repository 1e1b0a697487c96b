#pragma once
// 3D Systems Touch devices (and older Phantoms) through HDAPI: one session, one scheduler callback for all devices.
// Units mm, s, N.

#include "haptics/device/device.h"
#include "haptics/device/hd_library.h"
#include "haptics/device/tick_timer.h"

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace retractor::haptics {

/// A device by its name in the vendor's configuration or by its serial number. Both empty: the default device.
struct HdDeviceRequest {
    std::string name = {};
    std::string serial = {};
};

/// One interpreted entry of HDAPI's error queue.
struct HdProblem {
    hd::ErrorCode code = 0;
    int internal = 0;
    std::size_t device = 0; ///< index in the session; the number of devices when the entry belongs to no device
    /// Meaning for the servo; none: our call was wrong, or the entry is harmless.
    DeviceTrouble trouble = DeviceTrouble::none;
};
/// A message such as "0x0302, communication error: device lost", with our own words because the library's may be
/// missing.
std::string describe(const HdProblem& problem);
DeviceTrouble trouble_of(hd::ErrorCode code) noexcept;

struct HdOptions {
    std::vector<std::string> libraries = default_hd_libraries();
    unsigned rate_hz = 1000;
    /// Ramps of the force beside the servo's ramps, because a session may run without a servo.
    double ramp_up_s = 0.5, ramp_down_s = 0.1;
    std::chrono::milliseconds calibration_limit { 15000 }; ///< time for a person to put the stylus into its inkwell
    TickTimer::Clock clock = tick_clock_s; ///< another clock for tests that run the scheduler by hand
};

class HdSession : public TickSource {
public:
    /// Loads the library, initialises and calibrates the devices, and reads their limits. Force stays off.
    /// @throws IoError naming the library, the device and HDAPI's error, with advice
    HdSession(const std::vector<HdDeviceRequest>& requests, const HdOptions& options = {});
    /// Stops the session and disables the devices.
    ~HdSession() override;

    [[nodiscard]] std::size_t device_count() const noexcept { return devices_.size(); }
    /// Device for use within the tick only.
    [[nodiscard]] Device& device(std::size_t i);
    [[nodiscard]] const std::string& library() const noexcept { return library_.name(); }

    void start(Ticked& ticked) override;
    /// Ramps the force down, then ends the callback, the scheduler and the force output, in this order.
    void stop() noexcept override;

    /// Entries of the error queue since the last call, at most 64. One thread, not the servo's.
    [[nodiscard]] std::vector<HdProblem> take_problems();
    /// Times of the last run. @pre the session is stopped
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
    std::atomic<std::uint64_t> calls_ { 0 }; ///< number of calls of the callback

    static constexpr std::size_t kProblems = 64;
    std::array<HdProblem, kProblems> problems_ {};
    std::atomic<std::size_t> written_ { 0 }, read_ { 0 };
};

} // namespace retractor::haptics
