#pragma once
// Live surgery on a thread of its own: commands go in, snapshots come out. Whoever gives commands never waits for them.
//
// Who calls: a front end, from any thread; one thread makes the worker and destroys it.
// On which thread: prepare, on_snapshot, every command and the opening of the wound run on the worker's thread, one at
// a time.
// What may not happen: on_snapshot neither waits for the worker nor destroys it.

#include "mesh/base/serial_executor.h"
#include "planner/session/saved_cuts.h"
#include "planner/session/surgery_command.h"
#include "planner/session/surgery_session.h"

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

/// Everything that a front end shows, as of one moment. A snapshot that was handed out does not change.
struct SessionSnapshot {
    enum class Phase {
        preparing,
        asking, ///< cuts of the last time are on disk: restore them, or set them aside?
        ready,
        failed,
    };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: what is being done, and how far
    double fraction = 0.0;
    std::string failure; ///< failed: why
    std::size_t saved_cuts = 0; ///< asking: how many

    mesh::LabelTable labels; ///< ready; and the next two
    std::shared_ptr<const BeyondSurface> beyond; ///< null: nothing
    std::shared_ptr<const std::vector<EdgePlace>> outline; ///< of where can be cut; see region_outline()
    std::shared_ptr<const WallPicture> picture;
    std::vector<CutEntry> cuts;
    bool can_undo = false, can_redo = false, stroke_open = false;
    std::size_t refused_stroke = 0; ///< the last stroke, when it could not be begun, by its number; 0: it was begun
    std::string answer; ///< the last thing the surgeon should know
    bool refused = false; ///< the answer is why something was not done
    std::size_t answers = 0; ///< how many answers there were: tells a new one from the last
    double tension = 0.0; ///< strain
    double case_tension = 0.0; ///< the largest that the case states; 0: none
    double gape_mm = 0.0; ///< of the widest wound
    bool moving = false; ///< the wound is still opening
    double step_ms = 0.0; ///< of the last step of the knife
    double picture_ms = 0.0; ///< making the surface after it
    double relax_ms = 0.0; ///< of the last frame of the wound's opening
    HookReport hooks;
    std::size_t planned_hooks = 0; ///< how many the approach has
};

class KnifeWorker {
public:
    /// @param prepare runs on the worker's thread; what it throws is the failure.
    /// @param on_snapshot called on the worker's thread when there is a new snapshot, once until snapshot() is called.
    KnifeWorker(std::function<SurgerySetup(const Job&)> prepare, std::function<void()> on_snapshot);
    /// Stops preparing and leaves kept cuts as they are; finishes a stroke that is open, so that what was cut is kept.
    ~KnifeWorker();
    KnifeWorker(const KnifeWorker&) = delete;
    KnifeWorker& operator=(const KnifeWorker&) = delete;

    // Any thread:

    /// Answers the question; does nothing when none was asked.
    void restore(bool wanted);
    /// Commands are carried out in the order in which they came; those that come before the session is ready wait for
    /// it, and are dropped when it fails.
    void run(surgery::Command command);

    /// The newest; never null.
    std::shared_ptr<const SessionSnapshot> snapshot();
    /// Nothing is being prepared, no command waits or is being carried out, and the wound is at rest.
    bool idle() const;

private:
    struct Runner;
    template <class Change> void change_snapshot(const Change& change);
    void set_status(std::string answer, bool refused);
    void add_status(const std::string& more); ///< after what was said last
    void publish(SurgerySession& live_session);
    void announce();
    void prepare_session(const std::function<SurgerySetup(const Job&)>& prepare, const Job& job);
    std::unique_ptr<SurgerySession> start_session(
        SurgerySetup table, std::optional<SavedCuts> kept, std::optional<bool> wanted, const Job& job);
    void ask_to_restore(SurgerySetup table, SavedCuts kept);
    void make_ready(const std::function<std::unique_ptr<SurgerySession>()>& lay);
    void execute(const surgery::Command& command);
    void take_remark();
    std::optional<std::chrono::steady_clock::time_point> step();
    void open_wound();

    std::function<void()> on_snapshot_;
    mutable std::mutex mutex_; ///< of the next three
    std::shared_ptr<const SessionSnapshot> snapshot_;
    bool announced_ = false;
    std::vector<surgery::Command> deferred_; ///< that came while the question was open

    // The executor's thread only:
    struct Question {
        SurgerySetup table;
        SavedCuts kept;
    };
    std::optional<Question> question_; ///< none: it was not asked, or is answered
    std::string caution_; ///< of the table
    std::unique_ptr<SurgerySession> live_session_; ///< null: being prepared, or failed
    std::size_t refused_stroke_ = 0; ///< see SessionSnapshot
    bool changed_ = false; ///< a command was carried out since the last snapshot

    SerialExecutor executor_; ///< last: its tasks use all of the above
};

} // namespace retractor::planner
