#pragma once
// A palpation on a thread of its own: commands go in, frames and snapshots come out. Whoever gives commands never waits
// for them.
//
// Who calls: a front end. One thread makes the worker, moves the pointers, takes frames and destroys the worker;
// commands and snapshots are any thread's. On which thread: the tissue is made, commands are carried out and frames are
// drawn on the worker's thread, one at a time; the servo ticks on a thread of its own. A pointer that was moved is felt
// at the servo's next tick. What may not happen: a frame is not used after the next call of frame().

#include "mesh/base/serial_executor.h"
#include "mesh/base/triple_buffer.h"
#include "planner/session/palpation_command.h"
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

namespace retractor::planner {

/// How things stand beside the frames, as of one moment. A snapshot that was handed out does not change.
struct PalpationSnapshot {
    enum class Phase { preparing, ready, failed };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: what is being done, and how far
    double fraction = 0.0;
    std::string failure; ///< failed: why
    std::string answer; ///< the last thing to be said
    bool refused = false; ///< the answer is why something was not done
    std::size_t answers = 0; ///< tells a new one from the last
    bool busy = true; ///< commands wait or are being carried out

    // ready:
    PalpationSetup setup;
    TissueAbilities abilities;
    std::vector<std::string> notes;
    std::size_t fingers = 0;
    double heart_rate = 0.0; ///< per minute
    std::vector<haptics::ElasticTemplate> edits {}; ///< in force, in order
    bool unwritten_recording = false; ///< one is kept that could not be written
};

class PalpationWorker {
public:
    PalpationWorker(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend);
    /// Drops what waits and stops preparing. The session ends on the thread that it ran on.
    ~PalpationWorker();
    PalpationWorker(const PalpationWorker&) = delete;
    PalpationWorker& operator=(const PalpationWorker&) = delete;

    /// The owner's thread: what the mouse moves; there is one for every finger that a model may have.
    haptics::PointerDevice& pointer(std::size_t finger) { return *pointers_[finger]; }

    /// Any thread. Commands are carried out in the order in which they came.
    void run(palpation::Command command);
    /// Any thread: the newest; never null.
    [[nodiscard]] std::shared_ptr<const PalpationSnapshot> snapshot() const;

    /// The owner's thread.
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
    mutable std::mutex mutex_; ///< of the snapshot
    std::shared_ptr<const PalpationSnapshot> snapshot_;

    // The executor's thread only:
    struct Unwritten {
        haptics::MotionRecording recording;
        std::size_t lost = 0;
    };
    std::optional<Unwritten> unwritten_;
    std::unique_ptr<PalpationSession> session_; ///< null: being prepared, or failed
    std::chrono::steady_clock::time_point next_frame_ {};

    SerialExecutor executor_; ///< last: its tasks use all of the above
};

} // namespace retractor::planner
