#include "planner/session/palpation_worker.h"

#include "haptics/recording/motion_file.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <chrono>
#include <type_traits>
#include <utility>
#include <variant>

namespace retractor::planner {

namespace {

    constexpr std::chrono::milliseconds kFrame { 16 };
    constexpr double kRoom = 500.0; ///< mm; distance that pointers may go from the body

    haptics::Workspace room_of(const datasets::PalpationScene& scene)
    {
        const Points& p = scene.body.mesh.vertices;
        return { p.colwise().minCoeff().transpose().array() - kRoom,
            p.colwise().maxCoeff().transpose().array() + kRoom };
    }

} // namespace

/// Changes a copy, because a published snapshot never changes.
template <class Change> void PalpationWorker::change_snapshot(const Change& change)
{
    const std::lock_guard lock(mutex_);
    auto next = std::make_shared<PalpationSnapshot>(*snapshot_);
    change(*next);
    snapshot_ = std::move(next);
}

/// Carries each command out on the session. @return the message; empty: none
struct PalpationWorker::Runner {
    PalpationWorker& worker;
    PalpationSession& session;
    const Job& job;

    std::string operator()(const palpation::ChangeSetup& c) const
    {
        const bool other_tissue = c.setup.model != session.setup().model;
        session.change(c.setup, job);
        return other_tissue ? std::to_string(session.finger_count()) + " fingers on " + c.setup.model : std::string();
    }
    std::string operator()(const palpation::Reset&) const
    {
        session.reset(job);
        return "As it was read";
    }
    std::string operator()(const palpation::EditTissue& c) const
    {
        const std::size_t changed = session.edit(c.edit);
        if (changed == 0)
            throw InputError("nothing lies inside: move or enlarge it", "template");
        return std::to_string(changed) + (c.edit.role ? " elements and vertices changed" : " elements changed");
    }
    void operator()(const palpation::SetHeartRate& c) const { session.set_heart_rate(c.per_min); }
    void operator()(const palpation::Grip& c) const { session.grip(c.finger, c.held); }
    void operator()(const palpation::Rearm&) const { session.rearm(); }
    void operator()(const palpation::StartRecording&) const
    {
        if (worker.unwritten_)
            throw InputError("the last one is not written yet: save it first", "recording");
        session.start_recording();
    }
    std::string operator()(const palpation::StopRecording& c) const
    {
        if (session.recording()) {
            Unwritten stopped;
            stopped.recording = session.stop_recording(stopped.lost);
            if (stopped.recording.tick_count() == 0)
                throw InputError("the recording is empty: the servo did not tick", c.path.string());
            worker.unwritten_ = std::move(stopped);
        }
        if (!worker.unwritten_)
            return {};
        const auto& [recording, lost] = *worker.unwritten_;
        haptics::write_motion(c.path, recording);
        std::string answer = "Saved " + c.path.string() + " (" + std::to_string(recording.tick_count()) + " ticks"
            + (lost > 0 ? ", " + std::to_string(lost) + " more found no room" : std::string()) + ")";
        worker.unwritten_.reset();
        return answer;
    }
};

PalpationWorker::PalpationWorker(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend)
    : snapshot_(std::make_shared<const PalpationSnapshot>())
    , executor_({ .step = [this] { return step(); },
          .on_progress =
              [this] {
                  change_snapshot([progress = executor_.progress()](PalpationSnapshot& next) {
                      next.stage = progress.stage;
                      next.fraction = progress.fraction;
                  });
              },
          .when_destroyed = WaitingTasks::run })
{
    haptics::Workspace room = room_of(scene);
    // The frame of a pointer is the scene's, so the box must be symmetric: a mapping's zero is the middle of the
    // workspace.
    const Vec3 reach = room.high.cwiseAbs().cwiseMax(room.low.cwiseAbs());
    room = { -reach, reach };
    for (std::size_t f = 0; f < kMostFingers; ++f) {
        pointers_.push_back(
            std::make_unique<haptics::PointerDevice>(haptics::PointerOptions { .workspace = room }, mouse_info(f)));
        pointers_.back()->hop_to(reach); // away from the body at the start
    }
    executor_.post(
        [this, scene = std::move(scene), setup = std::move(setup), backend = std::move(backend)](
            const Job& job) mutable { prepare(std::move(scene), std::move(setup), std::move(backend), job); });
}

PalpationWorker::~PalpationWorker()
{
    executor_.post([this](const Job&) { session_.reset(); });
}

void PalpationWorker::run(palpation::Command command)
{
    const std::lock_guard lock(mutex_); // held also by publish(), so that no waiting command is missed
    auto next = std::make_shared<PalpationSnapshot>(*snapshot_);
    next->busy = true;
    snapshot_ = std::move(next);
    executor_.post([this, command = std::move(command)](const Job& job) {
        if (session_ != nullptr && !job.cancelled()) // cancelled when the worker ends
            execute(command, job);
    });
}

std::shared_ptr<const PalpationSnapshot> PalpationWorker::snapshot() const
{
    const std::lock_guard lock(mutex_);
    return snapshot_;
}

void PalpationWorker::set_status(std::string answer, bool refused)
{
    change_snapshot([&](PalpationSnapshot& next) {
        next.answer = std::move(answer);
        next.refused = refused;
        ++next.answers;
    });
}

/// @pre there is a session
void PalpationWorker::publish()
{
    RETRACTOR_ASSERT(session_ != nullptr);
    change_snapshot([this](PalpationSnapshot& next) {
        next.phase = PalpationSnapshot::Phase::ready;
        next.setup = session_->setup();
        next.abilities = session_->abilities();
        next.notes = session_->notes();
        next.fingers = session_->finger_count();
        next.heart_rate = session_->heart_rate();
        next.edits = session_->edits();
        next.unwritten_recording = unwritten_.has_value();
        next.busy = executor_.task_waits();
    });
}

/// @pre there is a session
void PalpationWorker::draw_frame()
{
    RETRACTOR_ASSERT(session_ != nullptr);
    session_->frame(frames_.draft());
    frames_.publish();
}

void PalpationWorker::prepare(
    datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend, const Job& job)
{
    std::vector<haptics::PointerDevice*> pointers;
    for (const auto& pointer : pointers_)
        pointers.push_back(pointer.get());
    try {
        session_ = std::make_unique<PalpationSession>(
            std::move(scene), std::move(setup), std::move(backend), std::move(pointers), job);
        draw_frame();
        publish();
    } catch (...) {
        session_.reset();
        change_snapshot([failure = to_string(current_failure())](PalpationSnapshot& next) {
            next.phase = PalpationSnapshot::Phase::failed;
            next.failure = failure;
            next.busy = false;
        });
    }
}

/// @pre there is a session
void PalpationWorker::execute(const palpation::Command& command, const Job& job)
{
    RETRACTOR_ASSERT(session_ != nullptr);
    try {
        const Runner runner { *this, *session_, job };
        std::string answer = std::visit(
            [&](const auto& asked) -> std::string {
                if constexpr (std::is_void_v<decltype(runner(asked))>)
                    return runner(asked), std::string();
                else
                    return runner(asked);
            },
            command);
        if (!answer.empty())
            set_status(std::move(answer), false);
    } catch (...) {
        set_status(to_string(current_failure()), true);
    }
}

/// Draws a frame: after commands at once, else at the display's rate.
std::optional<std::chrono::steady_clock::time_point> PalpationWorker::step()
{
    if (session_ == nullptr)
        return {};
    try {
        draw_frame();
    } catch (...) { // an edit was refused; the servo and the next frame go on without it
        set_status(to_string(current_failure()), true);
    }
    publish();
    next_frame_ = std::max(next_frame_ + kFrame, std::chrono::steady_clock::now());
    return next_frame_;
}

} // namespace retractor::planner
