#pragma once
// Live surgery on a separate thread: commands go in, snapshots come out. The caller of a command never waits for its
// result.
//
// Callers: a front end, from any thread; one thread creates and destroys the worker.
// Threads: `prepare`, `on_snapshot`, every command and the opening of the wound run on the worker's thread, one at a
// time.
// Restriction: `on_snapshot` neither waits for the worker nor destroys it.

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

/// Everything that a front end shows at one moment. A published snapshot never changes.
struct SurgerySnapshot {
    enum class Phase {
        preparing,
        /// Saved cuts of an earlier session are on disk; the front end asks whether to restore them or set them aside.
        asking,
        ready,
        failed,
    };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: the current work and its progress
    /// Preparing: progress from 0 to 1.
    double fraction = 0.0;
    std::string failure; ///< failed: the reason
    std::size_t saved_cuts = 0; ///< asking: number of saved cuts

    mesh::LabelTable labels; ///< set in phase `ready`, like the next two members
    std::shared_ptr<const BeyondSurface> beyond; ///< drawn wall outside the mesh; null: none
    /// Border of the region that can be cut; see region_outline().
    std::shared_ptr<const std::vector<EdgePlace>> outline;
    std::shared_ptr<const WallPicture> picture;
    std::vector<CutEntry> cuts;
    std::string cuts_not_saved; ///< why the cuts are not on the disk; empty: they are, or nothing keeps them
    std::string to_undo, to_redo; ///< the step of Undo and Redo, as SurgerySession::step_to_undo(); empty: none
    bool stroke_open = false;
    std::size_t refused_stroke = 0; ///< number of the last stroke when it could not be begun; 0: the stroke was begun
    std::string answer; ///< last message for the surgeon
    bool refused = false; ///< the message says why a command was refused
    std::size_t answers = 0; ///< number of messages so far; tells a new message from the last
    double tension = 0.0; ///< strain
    double case_tension = 0.0; ///< largest pre-strain of the case; 0: none
    double gape_mm = 0.0; ///< gape of the widest wound
    bool moving = false; ///< the wound is still opening
    double step_ms = 0.0; ///< time of the last step of the knife
    double picture_ms = 0.0; ///< time to make the surface after that step
    double relax_ms = 0.0; ///< time of the last frame of the wound's opening
    HookReport hooks;
    std::size_t planned_hooks = 0; ///< number of hooks in the approach
    std::optional<PlannedForce> planned_force; ///< see SurgerySetup
    DivisionExtent division = DivisionExtent::skin; ///< what the approach divides beyond the skin
};

class SurgeryWorker {
public:
    /// @param prepare runs on the worker's thread; an exception gives phase `failed` with its message
    /// @param on_snapshot called on the worker's thread when there is a new snapshot, and not again until snapshot()
    /// was called
    SurgeryWorker(std::function<SurgerySetup(const Job&)> prepare, std::function<void()> on_snapshot);
    /// Cancels the preparation and leaves saved cuts on disk. Finishes an open stroke, so that its cuts are kept.
    ~SurgeryWorker();
    SurgeryWorker(const SurgeryWorker&) = delete;
    SurgeryWorker& operator=(const SurgeryWorker&) = delete;

    // Any thread:

    /// Answers the question of phase `asking`: whether to restore the saved cuts. Does nothing in another phase.
    void restore(bool wanted);
    /// Runs a command; commands run in the order of arrival. Commands that arrive before phase `ready` wait, and are
    /// dropped when the preparation fails.
    void run(surgery::Command command);

    /// The newest snapshot; never null.
    std::shared_ptr<const SurgerySnapshot> snapshot();
    /// Whether nothing is being prepared, no command waits or runs, and the wound is at rest.
    bool idle() const;

private:
    struct Runner;
    template <class Change> void change_snapshot(const Change& change);
    void set_status(std::string answer, bool refused);
    void add_status(const std::string& more); ///< appends to the last message
    std::string why_not_saved() const; ///< see SurgerySnapshot::cuts_not_saved
    void publish(SurgerySession& live_session);
    void announce();
    void prepare_session(const std::function<SurgerySetup(const Job&)>& prepare, const Job& job);
    std::unique_ptr<SurgerySession> start_session(
        SurgerySetup setup, std::optional<SavedCuts> kept, std::optional<bool> wanted, const Job& job);
    void ask_to_restore(SurgerySetup setup, SavedCuts kept);
    void make_ready(const std::function<std::unique_ptr<SurgerySession>()>& start);
    void execute(const surgery::Command& command);
    void take_remark();
    std::optional<std::chrono::steady_clock::time_point> step();
    void open_wound();

    std::function<void()> on_snapshot_;
    mutable std::mutex mutex_; ///< guards the next three members
    std::shared_ptr<const SurgerySnapshot> snapshot_;
    bool announced_ = false;
    std::vector<surgery::Command> deferred_; ///< commands that arrived while the question was open

    // The executor's thread only:
    struct Question {
        SurgerySetup setup;
        SavedCuts kept;
    };
    std::optional<Question> question_; ///< none: not asked, or answered already
    std::string caution_; ///< caution of the setup
    mesh::WaitingLines waiting_; ///< cuts of the session that wait for the disk
    std::string not_kept_; ///< why the session has no journal; empty: it has one, or needs none
    std::function<void(const std::filesystem::path&, const mesh::TetMesh&)> write_wall_; ///< of the setup
    std::unique_ptr<SurgerySession> live_session_; ///< null: being prepared, or failed
    std::size_t refused_stroke_ = 0; ///< see SurgerySnapshot
    bool changed_ = false; ///< a command ran since the last snapshot

    SerialExecutor executor_; ///< last, because its tasks use all members above
};

} // namespace retractor::planner
