#pragma once
// A palpation on a separate thread: commands go in, frames and snapshots come out. The caller of a command never waits
// for its result.
//
// Callers: a front end. One thread creates the worker, moves the pointers, takes frames and destroys the worker; any
// thread may send commands and take snapshots.
// Threads: the tissue is made, commands run and frames are drawn on the worker's thread, one at a time; the servo ticks
// on its own thread, and feels a moved pointer at its next tick.
// Restriction: a frame must not be used after the next call of frame().

#include "mesh/base/serial_executor.h"
#include "mesh/base/triple_buffer.h"
#include "planner/session/palpation_command.h"
#include "planner/session/palpation_session.h"

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// The state beside the frames at one moment. A published snapshot never changes.
struct PalpationSnapshot {
    enum class Phase { preparing, ready, failed };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: the current work and its progress
    /// Preparing: progress from 0 to 1.
    double fraction = 0.0;
    std::string failure; ///< failed: the reason
    std::string answer; ///< last message
    bool refused = false; ///< the message says why a command was refused
    std::size_t answers = 0; ///< number of messages so far; tells a new message from the last
    bool busy = true; ///< commands wait or run

    // Ready:
    PalpationSetup setup;
    TissueAbilities abilities;
    std::vector<std::string> notes;
    std::size_t fingers = 0;
    double heart_rate = 0.0; ///< 1/min
    std::vector<haptics::ElasticTemplate> edits {}; ///< active edits, in order
    bool unwritten_recording = false; ///< a recording that could not be written is kept
};

class PalpationWorker {
public:
    PalpationWorker(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend);
    /// Drops waiting commands and cancels the preparation. The session ends on the worker's thread.
    ~PalpationWorker();
    PalpationWorker(const PalpationWorker&) = delete;
    PalpationWorker& operator=(const PalpationWorker&) = delete;

    /// Owner's thread: the device that the mouse moves, one for each possible finger of a model.
    haptics::PointerDevice& pointer(std::size_t finger) { return *pointers_[finger]; }

    /// Any thread: runs a command; commands run in the order of arrival.
    void run(palpation::Command command);
    /// Any thread: the newest snapshot; never null.
    [[nodiscard]] std::shared_ptr<const PalpationSnapshot> snapshot() const;

    /// The owner's thread:
    [[nodiscard]] bool has_frame() const noexcept { return frames_.has_news(); }
    const PalpationFrame& frame() noexcept { return frames_.latest(); }

private:
    struct Runner;
    template <class Change> void change_snapshot(const Change& change);
    void set_status(std::string answer, bool refused);
    void publish();
    void prepare(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend, const Job& job);
    void execute(const palpation::Command& command, const Job& job);
    std::optional<std::chrono::steady_clock::time_point> step();
    void draw_frame();

    std::vector<std::unique_ptr<haptics::PointerDevice>> pointers_;
    TripleBuffer<PalpationFrame> frames_;
    mutable std::mutex mutex_; ///< guards snapshot_
    std::shared_ptr<const PalpationSnapshot> snapshot_;

    // The executor's thread only:
    struct Unwritten {
        haptics::MotionRecording recording;
        std::size_t lost = 0;
    };
    std::optional<Unwritten> unwritten_;
    std::unique_ptr<PalpationSession> session_; ///< null: being prepared, or failed
    std::chrono::steady_clock::time_point next_frame_ {};

    SerialExecutor executor_; ///< last, because its tasks use all members above
};

} // namespace retractor::planner
