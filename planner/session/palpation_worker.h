#pragma once
// A palpation on a thread of its own: orders go in, frames and what is to be said come out. The window never waits for
// it. The mouse's pointers are moved directly: the servo feels them at its next tick.

#include "mesh/base/serial_executor.h"
#include "mesh/base/triple_buffer.h"
#include "planner/session/palpation_session.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace retractor {

/// How things stand beside the frames.
struct PalpationNews {
    enum class Phase { preparing, ready, failed };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: what is being done, and how far
    double fraction = 0.0;
    std::string failure; ///< failed: why
    std::string answer; ///< the last thing to be said
    bool refused = false; ///< the answer is why something was not done
    std::size_t answers = 0; ///< tells a new one from the last
    bool busy = true; ///< orders wait or are being carried out

    // ready:
    PalpationSetup setup;
    TissueAbilities abilities;
    std::vector<std::string> notes;
    std::size_t fingers = 0;
    double heart_rate = 0.0; ///< per minute
    std::vector<ElasticTemplate> edits {}; ///< in force, in order
    bool unwritten_recording = false; ///< one is kept that could not be written
};

class PalpationWorker {
public:
    PalpationWorker(PalpationScene scene, PalpationSetup setup, PalpationBackend backend);
    /// Drops what waits and stops preparing. The session ends on the thread that it ran on.
    ~PalpationWorker();
    PalpationWorker(const PalpationWorker&) = delete;
    PalpationWorker& operator=(const PalpationWorker&) = delete;

    /// Window's thread: what the mouse moves; there is one for every finger that a model may have.
    PointerDevice& pointer(std::size_t finger) { return *pointers_[finger]; }

    // Any thread. What is wrong with an order is said in news().
    void change(const PalpationSetup& setup);
    void reset();
    void edit(const ElasticTemplate& edit);
    void set_heart_rate(double per_min);
    void grip(std::size_t finger, bool held);
    void rearm();
    void start_recording();
    /// And writes it; what could not be written is kept for the next call. Nothing when there is none.
    void stop_recording(const std::filesystem::path& path);

    [[nodiscard]] PalpationNews news() const;
    /// Window's thread.
    [[nodiscard]] bool has_frame() const noexcept { return frames_.has_news(); }
    const PalpationFrame& frame() noexcept { return frames_.latest(); }

private:
    /// @return what is to be said; empty: nothing
    using Order = std::function<std::string(PalpationSession&, const Job&)>;
    void post(Order order);
    void prepare(PalpationScene scene, PalpationSetup setup, PalpationBackend backend, const Job& job);
    void carry_out(const Order& order, const Job& job);
    std::optional<std::chrono::steady_clock::time_point> step();
    void show(PalpationSession& session);
    void tell(const PalpationSession& session);
    void say(std::string answer, bool refused);

    std::vector<std::unique_ptr<PointerDevice>> pointers_;
    TripleBuffer<PalpationFrame> frames_;
    mutable std::mutex mutex_; ///< of the news
    PalpationNews news_;

    // The executor's thread only:
    struct Unwritten {
        MotionRecording recording;
        std::size_t lost = 0;
    };
    std::optional<Unwritten> unwritten_;
    std::unique_ptr<PalpationSession> session_; ///< null: being prepared, or failed
    std::chrono::steady_clock::time_point next_frame_ {};

    SerialExecutor executor_; ///< last: its tasks use all of the above
};

} // namespace retractor
