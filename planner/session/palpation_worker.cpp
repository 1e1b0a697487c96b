#include "planner/session/palpation_worker.h"

#include "mesh/base/error.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <new>
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
{
    Workspace room = room_of(scene);
    // Its frame is the scene's: the middle of a workspace is a mapping's zero.
    const Vec3 reach = room.high.cwiseAbs().cwiseMax(room.low.cwiseAbs());
    room = { -reach, reach };
    for (std::size_t f = 0; f < kMostFingers; ++f) {
        pointers_.push_back(std::make_unique<PointerDevice>(PointerOptions { .workspace = room }, mouse_info(f)));
        pointers_.back()->hop_to(reach); // out of the way
    }
    thread_ = std::thread(
        [this, scene = std::move(scene), setup = std::move(setup), backend = std::move(backend)]() mutable {
            run(std::move(scene), std::move(setup), std::move(backend));
        });
}

PalpationWorker::~PalpationWorker()
{
    cancel_.store(true);
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

void PalpationWorker::post(Order order)
{
    {
        const std::lock_guard lock(mutex_);
        orders_.push_back(std::move(order));
        news_.busy = true;
    }
    wake_.notify_one();
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
    const std::lock_guard lock(mutex_);
    return news_;
}

void PalpationWorker::say(std::string answer, bool refused)
{
    const std::lock_guard lock(mutex_);
    news_.answer = std::move(answer);
    news_.refused = refused;
    ++news_.answers;
}

Job PalpationWorker::job()
{
    Job job;
    job.cancel = &cancel_;
    job.on_progress = [this](std::string_view stage, double fraction) {
        const std::lock_guard lock(mutex_);
        news_.stage = stage;
        news_.fraction = fraction;
    };
    return job;
}

std::unique_ptr<PalpationSession> PalpationWorker::prepare(
    PalpationScene scene, PalpationSetup setup, PalpationBackend backend)
{
    std::vector<PointerDevice*> pointers;
    for (const auto& pointer : pointers_)
        pointers.push_back(pointer.get());
    std::string failure;
    try {
        auto session = std::make_unique<PalpationSession>(
            std::move(scene), std::move(setup), std::move(backend), std::move(pointers), job());
        show(*session);
        tell(*session);
        return session;
    } catch (...) {
        failure = to_string(current_failure());
    }
    const std::lock_guard lock(mutex_);
    news_.phase = PalpationNews::Phase::failed;
    news_.failure = std::move(failure);
    news_.busy = false;
    return nullptr;
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
    news_.busy = !orders_.empty();
}

void PalpationWorker::carry_out(PalpationSession& session, const Order& order)
{
    try {
        if (std::string answer = order(session, job()); !answer.empty())
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

void PalpationWorker::run(PalpationScene scene, PalpationSetup setup, PalpationBackend backend)
{
    const std::unique_ptr<PalpationSession> session = prepare(std::move(scene), std::move(setup), std::move(backend));
    auto next = std::chrono::steady_clock::now();
    while (true) {
        next = std::max(next + kFrame, std::chrono::steady_clock::now());
        std::deque<Order> orders;
        {
            std::unique_lock lock(mutex_);
            const auto called = [&] { return stop_ || !orders_.empty(); };
            if (session == nullptr)
                wake_.wait(lock, [&] { return stop_; });
            else
                wake_.wait_until(lock, next, called);
            if (stop_)
                return;
            std::swap(orders, orders_);
        }
        for (const Order& order : orders)
            carry_out(*session, order);
        try {
            show(*session);
        } catch (...) { // an edit that cannot be; the servo goes on without it, and so does the next frame
            say(to_string(current_failure()), true);
        }
        tell(*session);
    }
}

} // namespace retractor
