#pragma once
// Our own thread as a tick source, for devices whose vendors bring no scheduler.

#include "haptics/device/device.h"
#include "haptics/device/tick_statistics.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

namespace retractor::haptics {

struct TickThreadOptions {
    double period_s = 1e-3;
    int priority = 80; ///< under SCHED_FIFO: above what else runs, below the kernel's own threads; 0 asks for none
};

/// Wakes at multiples of the period after the start; those it slept through are left out, never made up for.
class TickThread : public TickSource {
public:
    explicit TickThread(const TickThreadOptions& options = {});
    ~TickThread() override;

    void start(Ticked& ticked) override;
    void stop() noexcept override;

    /// Whether the thread runs under SCHED_FIFO; why not otherwise ("Operation not permitted: ..."). After start().
    [[nodiscard]] bool is_realtime() const noexcept { return realtime_note_.empty(); }
    [[nodiscard]] const std::string& realtime_note() const noexcept { return realtime_note_; }
    /// Of the last run. @pre it is stopped
    [[nodiscard]] const TickTimes& times() const noexcept { return timer_->times(); }

private:
    void loop(Ticked& ticked) noexcept;

    TickThreadOptions options_;
    std::unique_ptr<TickTimer> timer_;
    std::atomic<bool> stopping_ { false };
    std::thread thread_;
    std::string realtime_note_;
};

/// Runs nothing for a while: the machine's own jitter. @param seconds of it
TickTimes empty_loop(double seconds, const TickThreadOptions& options = {});

} // namespace retractor::haptics
