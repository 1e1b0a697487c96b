#pragma once
// Our own thread as a tick source, for devices whose vendors provide no scheduler.

#include "haptics/device/device.h"
#include "haptics/device/tick_timer.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

namespace retractor::haptics {

struct TickThreadOptions {
    double period_s = 1e-3;
    /// Priority under SCHED_FIFO: above other programs, below the kernel's own threads; 0: ordinary scheduling.
    int priority = 80;
};

/// Wakes at multiples of the period after the start. Missed periods are skipped, and no tick makes up for them.
class TickThread : public TickSource {
public:
    explicit TickThread(const TickThreadOptions& options = {});
    ~TickThread() override;

    void start(Ticked& ticked) override;
    void stop() noexcept override;

    /// Whether the thread runs under SCHED_FIFO. If not, realtime_note() is the reason ("Operation not permitted:
    /// ...").
    /// @pre start() was called
    [[nodiscard]] bool is_realtime() const noexcept { return realtime_note_.empty(); }
    [[nodiscard]] const std::string& realtime_note() const noexcept { return realtime_note_; }
    /// Times of the last run. @pre the source is stopped
    [[nodiscard]] const TickTimes& times() const noexcept { return timer_->times(); }

private:
    void loop(Ticked& ticked) noexcept;

    TickThreadOptions options_;
    std::unique_ptr<TickTimer> timer_;
    std::atomic<bool> stopping_ { false };
    std::thread thread_;
    std::string realtime_note_;
};

} // namespace retractor::haptics
