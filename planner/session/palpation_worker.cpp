#include "planner/session/palpation_worker.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace retractor {

namespace {

    constexpr std::chrono::milliseconds kFrame { 16 };
    constexpr double kRoom = 500.0; ///< mm round the body that pointers may go

    Workspace room_of(const PalpationScene& scene)
    {
        const Points& p = scene.body.mesh.vertices;
        return { p.colwise().minCoeff().transpose().array() - kRoom,
            p.colwise().maxCoeff().transpose().array() + kRoom };
    }

} // namespace

PalpationWorker::PalpationWorker(PalpationScene scene, PalpationSetup setup, PalpationBackend backend)
    : executor_({ .step = [this] { return step(); }, .when_destroyed = WaitingTasks::run })
{
    Workspace room = room_of(scene);
    // Its frame is the scene's: the middle of a workspace is a mapping's zero.
    const Vec3 reach = room.high.cwiseAbs().cwiseMax(room.low.cwiseAbs());
    room = { -reach, reach };
    for (std::size_t f = 0; f < kMostFingers; ++f) {
        pointers_.push_back(std::make_unique<PointerDevice>(PointerOptions { .workspace = room }, mouse_info(f)));
        pointers_.back()->hop_to(reach); // out of the way
    }
    executor_.post(
        [this, scene = std::move(scene), setup = std::move(setup), backend = std::move(backend)](
            const Job& job) mutable { prepare(std::move(scene), std::move(setup), std::move(backend), job); });
}

PalpationWorker::~PalpationWorker()
{
    executor_.post([this](const Job&) { session_.reset(); });
}

void PalpationWorker::post(Order order)
{
    const std::lock_guard lock(mutex_); // as in tell(): what waits is busy
    news_.busy = true;
    executor_.post([this, order = std::move(order)](const Job& job) {
        if (session_ != nullptr && !job.cancelled()) // it is, once the worker ends
            carry_out(order, job);
    });
}

void PalpationWorker::change(const PalpationSetup& setup)
{
    post([this, setup](PalpationSession& session, const Job& job) -> std::string {
        const bool other_tissue = setup.model != session.setup().model;
        session.change(setup, job);
        return other_tissue ? std::to_string(session.finger_count()) + " fingers on " + setup.model : std::string();
    });
}

void PalpationWorker::reset()
{
    post([this](PalpationSession& session, const Job& job) -> std::string {
        session.reset(job);
        return "As it was read";
    });
}

void PalpationWorker::edit(const ElasticTemplate& edit)
{
    post([edit](PalpationSession& session, const Job&) -> std::string {
        const std::size_t changed = session.edit(edit);
        if (changed == 0)
            throw InputError("nothing lies inside: move or enlarge it", "template");
        return std::to_string(changed) + (edit.role ? " elements and vertices changed" : " elements changed");
    });
}

void PalpationWorker::set_heart_rate(double per_min)
{
    post([per_min](PalpationSession& session, const Job&) -> std::string {
        session.set_heart_rate(per_min);
        return {};
    });
}

void PalpationWorker::grip(std::size_t finger, bool held)
{
    post([finger, held](PalpationSession& session, const Job&) -> std::string {
        session.grip(finger, held);
        return {};
    });
}

void PalpationWorker::rearm()
{
    post([](PalpationSession& session, const Job&) -> std::string {
        session.rearm();
        return {};
    });
}

void PalpationWorker::start_recording()
{
    post([this](PalpationSession& session, const Job&) -> std::string {
        if (unwritten_)
            throw InputError("the last one is not written yet: save it first", "recording");
        session.start_recording();
        return {};
    });
}

void PalpationWorker::stop_recording(const std::filesystem::path& path)
{
    post([this, path](PalpationSession& session, const Job&) -> std::string {
        if (session.recording()) {
            Unwritten stopped;
            stopped.recording = session.stop_recording(stopped.lost);
            if (stopped.recording.tick_count() == 0)
                throw InputError("the recording is empty: the servo did not tick", path.string());
            unwritten_ = std::move(stopped);
        }
        if (!unwritten_)
            return {};
        const auto& [recording, lost] = *unwritten_;
        write_motion(path, recording);
        std::string answer = "Saved " + path.string() + " (" + std::to_string(recording.tick_count()) + " ticks"
            + (lost > 0 ? ", " + std::to_string(lost) + " more found no room" : std::string()) + ")";
        unwritten_.reset();
        return answer;
    });
}

PalpationNews PalpationWorker::news() const
{
    const SerialExecutor::Progress progress = executor_.progress();
    const std::lock_guard lock(mutex_);
    PalpationNews news = news_;
    news.stage = progress.stage;
    news.fraction = progress.fraction;
    return news;
}

void PalpationWorker::say(std::string answer, bool refused)
{
    const std::lock_guard lock(mutex_);
    news_.answer = std::move(answer);
    news_.refused = refused;
    ++news_.answers;
}

void PalpationWorker::prepare(PalpationScene scene, PalpationSetup setup, PalpationBackend backend, const Job& job)
{
    std::vector<PointerDevice*> pointers;
    for (const auto& pointer : pointers_)
        pointers.push_back(pointer.get());
    try {
        auto session = std::make_unique<PalpationSession>(
            std::move(scene), std::move(setup), std::move(backend), std::move(pointers), job);
        show(*session);
        tell(*session);
        session_ = std::move(session);
    } catch (...) {
        const std::lock_guard lock(mutex_);
        news_.phase = PalpationNews::Phase::failed;
        news_.failure = to_string(current_failure());
        news_.busy = false;
    }
}

void PalpationWorker::tell(const PalpationSession& session)
{
    const std::lock_guard lock(mutex_);
    news_.phase = PalpationNews::Phase::ready;
    news_.setup = session.setup();
    news_.abilities = session.abilities();
    news_.notes = session.notes();
    news_.fingers = session.finger_count();
    news_.heart_rate = session.heart_rate();
    news_.edits = session.edits();
    news_.unwritten_recording = unwritten_.has_value();
    news_.busy = executor_.task_waits();
}

/// @pre there is a session
void PalpationWorker::carry_out(const Order& order, const Job& job)
{
    try {
        if (std::string answer = order(*session_, job); !answer.empty())
            say(std::move(answer), false);
    } catch (...) {
        say(to_string(current_failure()), true);
    }
}

void PalpationWorker::show(PalpationSession& session)
{
    session.frame(frames_.draft());
    frames_.publish();
}

/// A frame, after orders at once and else at the display's pace.
std::optional<std::chrono::steady_clock::time_point> PalpationWorker::step()
{
    if (session_ == nullptr)
        return {};
    try {
        show(*session_);
    } catch (...) { // an edit that cannot be; the servo goes on without it, and so does the next frame
        say(to_string(current_failure()), true);
    }
    tell(*session_);
    next_frame_ = std::max(next_frame_ + kFrame, std::chrono::steady_clock::now());
    return next_frame_;
}

} // namespace retractor
