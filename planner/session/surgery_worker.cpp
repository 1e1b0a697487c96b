#include "planner/session/surgery_worker.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <chrono>
#include <exception>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>

namespace retractor::planner {

namespace {

    /// Length of a frame in which the wound opens: short enough that the knife never waits long.
    constexpr double kFrameMs = 40.0;

    /// A hook that has not moved for this time is at rest, and its numbers are computed.
    constexpr std::chrono::milliseconds kHandRests { 150 };

    /// Of the waiting commands with the same key only the newest runs. An empty key means that all run.
    std::string key_of(const surgery::Command& command)
    {
        if (const auto* pull = std::get_if<surgery::PullHook>(&command))
            return "hook " + std::to_string(pull->hook);
        if (const auto* crank = std::get_if<surgery::Crank>(&command))
            return "hook " + std::to_string(crank->blade);
        const bool of_all = std::holds_alternative<surgery::PullAllHooks>(command)
            || std::holds_alternative<surgery::PullHooksByShare>(command);
        return of_all ? "all hooks" : "";
    }

    /// A full disk leaves a journal without a line: there is nothing to keep.
    void drop_empty(const std::filesystem::path& journal)
    {
        std::error_code error;
        if (std::filesystem::file_size(journal, error) == 0 && !error)
            std::filesystem::remove(journal, error);
    }

} // namespace

/// Changes a copy, because a published snapshot never changes.
template <class Change> void SurgeryWorker::change_snapshot(const Change& change)
{
    const std::lock_guard lock(mutex_);
    auto next = std::make_shared<SurgerySnapshot>(*snapshot_);
    change(*next);
    snapshot_ = std::move(next);
}

/// Carries each command out on the session. The result is an answer, or nothing when there is no message.
struct SurgeryWorker::Runner {
    SurgeryWorker& worker;
    SurgerySession& live_session;

    KnifeAnswer operator()(const surgery::BeginStroke& c) const
    {
        worker.refused_stroke_ = c.number; // reset once the stroke has begun
        if (live_session.stroke_open()) // finishing was refused, for example by a full disk: try again
            if (KnifeAnswer former = finish(); !former.reason.empty()) {
                worker.set_status(std::move(former.reason), !former.done);
                if (live_session.stroke_open())
                    return { true, {} }; // the status gives the reason
            }
        KnifeAnswer begun = live_session.begin_stroke(c.at, c.settings);
        if (begun.done)
            worker.refused_stroke_ = 0;
        return begun;
    }
    KnifeAnswer operator()(const surgery::DrawTo& c) const
    {
        return drawing() ? live_session.draw_to(c.at) : nothing();
    }
    void operator()(const surgery::LeaveWall&) const
    {
        if (drawing())
            live_session.leave_wall();
    }
    KnifeAnswer operator()(const surgery::FinishStroke&) const { return drawing() ? finish() : nothing(); }
    void operator()(const surgery::AbandonStroke&) const { live_session.abandon_stroke(); }
    KnifeAnswer operator()(const surgery::CutAsPlanned&) const { return live_session.cut_as_planned(); }
    KnifeAnswer operator()(const surgery::DivideBeyondCut&) const { return live_session.divide_beyond_cut(); }
    KnifeAnswer operator()(const surgery::TakeOut& c) const { return live_session.take_out(c.at, c.radius_mm); }

    void operator()(const surgery::Undo&) const
    {
        if (!live_session.step_to_undo().empty())
            live_session.undo_step();
    }
    void operator()(const surgery::Redo&) const
    {
        if (!live_session.step_to_redo().empty())
            live_session.redo_step();
    }
    void operator()(const surgery::GoTo& c) const
    {
        while (live_session.can_undo() && live_session.session().cut_count() > c.cuts)
            live_session.undo();
        while (live_session.can_redo() && live_session.session().cut_count() < c.cuts)
            live_session.redo();
    }
    void operator()(const surgery::SetTension& c) const { live_session.set_tension(c.strain); }

    KnifeAnswer operator()(const surgery::PlaceHook& c) const { return live_session.place_hook(c.at); }
    KnifeAnswer operator()(const surgery::PlaceRetractor& c) const
    {
        return live_session.place_retractor(c.at, c.kind);
    }
    void operator()(const surgery::Crank& c) const { live_session.crank(c.blade, c.opening_mm); }
    KnifeAnswer operator()(const surgery::TakePlannedHooks&) const { return live_session.take_planned_hooks(); }
    void operator()(const surgery::PullHook& c) const { live_session.pull_hook(c.hook, c.asked); }
    void operator()(const surgery::PullAllHooks& c) const { live_session.pull_all_hooks(c.mm); }
    void operator()(const surgery::PullHooksByShare& c) const { live_session.pull_hooks_by_share(c.share); }
    KnifeAnswer operator()(const surgery::SetPlannedForce& c) const
    {
        if (!live_session.set_planned_force(c.force))
            return nothing();
        worker.change_snapshot([&](SurgerySnapshot& next) { next.planned_force = c.force; });
        if (!c.force)
            return { true, "The new plan says no force: forces by hand are not matched" };
        return { true,
            live_session.hooks().force_factor
                ? "The plan is made: forces by hand are matched to it"
                : "The plan is made: forces by hand are matched to it once the wound is opened as planned" };
    }
    void operator()(const surgery::SetYield& c) const { live_session.set_yield(c.force_N); }
    void operator()(const surgery::SetNonlinear& c) const { live_session.set_nonlinear(c.wanted); }
    void operator()(const surgery::TakeOffHook& c) const { live_session.take_off_hook(c.hook); }
    void operator()(const surgery::TakeOffHooks&) const { live_session.take_off_hooks(); }

    KnifeAnswer operator()(const surgery::SaveCuts&) const
    {
        if (!worker.waiting_.write() || !worker.not_kept_.empty())
            return { false, "The cuts are still not saved: " + worker.why_not_saved() };
        return { true, "The cuts are saved" };
    }
    KnifeAnswer operator()(const surgery::ExportWall& c) const
    {
        if (live_session.stroke_open())
            return { false, "a stroke is open: finish it first" };
        if (!worker.write_wall_)
            return { false, "this program cannot save the wall" };
        worker.write_wall_(c.path, live_session.session().compact_mesh());
        return { true, "Saved " + c.path.string() };
    }

private:
    static KnifeAnswer nothing() { return { true, {} }; } ///< no message
    /// A refused stroke has no line to draw on.
    bool drawing() const { return live_session.stroke_open() && worker.refused_stroke_ == 0; }
    KnifeAnswer finish() const
    {
        try {
            return live_session.finish_stroke();
        } catch (const Error&) {
            return { false, to_string(current_failure()) + "; the stroke is still open: Esc takes it back" };
        }
    }
};

SurgeryWorker::SurgeryWorker(std::function<SurgerySetup(const Job&)> prepare, std::function<void()> on_snapshot)
    : on_snapshot_(std::move(on_snapshot))
    , snapshot_(std::make_shared<const SurgerySnapshot>())
    , executor_({ .step = [this] { return step(); },
          .on_progress =
              [this] {
                  change_snapshot([progress = executor_.progress()](SurgerySnapshot& next) {
                      next.stage = progress.stage;
                      next.fraction = progress.fraction;
                  });
                  announce();
              },
          .when_destroyed = WaitingTasks::run })
{
    executor_.post([this, prepare = std::move(prepare)](const Job& job) { prepare_session(prepare, job); });
}

SurgeryWorker::~SurgeryWorker()
{
    executor_.post([this](const Job&) {
        refused_stroke_ = 0; // the open stroke is finished even when a later stroke was refused
        if (live_session_ != nullptr && live_session_->stroke_open())
            execute(surgery::FinishStroke {});
        live_session_.reset(); // destroyed on the thread that used the session
    });
}

void SurgeryWorker::run(surgery::Command command)
{
    std::string key = key_of(command);
    executor_.post_latest(std::move(key), [this, command = std::move(command)](const Job&) {
        if (live_session_ != nullptr) {
            execute(command);
        } else if (question_) {
            const std::lock_guard lock(mutex_);
            deferred_.push_back(command);
        }
    });
}

void SurgeryWorker::restore(bool wanted)
{
    {
        const std::lock_guard lock(mutex_);
        if (snapshot_->phase != SurgerySnapshot::Phase::asking)
            return;
    }
    executor_.post([this, wanted](const Job& job) {
        if (!question_) // answered already
            return;
        change_snapshot([](SurgerySnapshot& next) { next.phase = SurgerySnapshot::Phase::preparing; });
        Question asked = std::move(*std::exchange(question_, std::nullopt));
        make_ready([&] { return start_session(std::move(asked.setup), std::move(asked.kept), wanted, job); });
    });
}

std::shared_ptr<const SurgerySnapshot> SurgeryWorker::snapshot()
{
    const std::lock_guard lock(mutex_);
    announced_ = false;
    return snapshot_;
}

bool SurgeryWorker::idle() const
{
    if (!executor_.idle())
        return false;
    const std::lock_guard lock(mutex_);
    return deferred_.empty();
}

void SurgeryWorker::announce()
{
    {
        const std::lock_guard lock(mutex_);
        if (std::exchange(announced_, true))
            return;
    }
    on_snapshot_();
}

void SurgeryWorker::set_status(std::string answer, bool refused)
{
    change_snapshot([&](SurgerySnapshot& next) {
        next.answer = std::move(answer);
        next.refused = refused;
        ++next.answers;
    });
}

void SurgeryWorker::add_status(const std::string& more)
{
    change_snapshot([&](SurgerySnapshot& next) {
        remark(next.answer, more);
        ++next.answers;
    });
}

std::string SurgeryWorker::why_not_saved() const { return not_kept_.empty() ? waiting_.reason() : not_kept_; }

void SurgeryWorker::publish(SurgerySession& live_session)
{
    const Stopwatch watch;
    const std::shared_ptr<const WallPicture> picture = live_session.picture();
    const double picture_ms = 1e3 * watch.seconds();
    change_snapshot([&](SurgerySnapshot& next) {
        next.phase = SurgerySnapshot::Phase::ready;
        if (next.picture != picture)
            next.picture_ms = picture_ms;
        next.picture = picture;
        next.cuts = live_session.cuts();
        next.cuts_not_saved = why_not_saved();
        next.to_undo = live_session.step_to_undo();
        next.to_redo = live_session.step_to_redo();
        next.stroke_open = live_session.stroke_open();
        next.refused_stroke = refused_stroke_;
        next.step_ms = live_session.step_ms();
        next.tension = live_session.tension();
        next.case_tension = live_session.case_tension();
        next.gape_mm = live_session.gape_mm();
        next.moving = live_session.moving();
        next.hooks = live_session.hooks();
        next.planned_hooks = live_session.planned_hooks();
        next.division = live_session.division();
    });
    announce();
}

void SurgeryWorker::prepare_session(const std::function<SurgerySetup(const Job&)>& prepare, const Job& job)
{
    make_ready([&] {
        SurgerySetup setup = prepare(job);
        caution_ = setup.caution;
        write_wall_ = setup.write_wall;
        auto outline = std::make_shared<const std::vector<EdgePlace>>(
            region_outline(setup.wall, setup.region, setup.labels, setup.outward));
        std::shared_ptr<const BeyondSurface> beyond;
        if (setup.beyond != nullptr && !setup.beyond->triangles.empty())
            beyond = std::make_shared<const BeyondSurface>(setup.beyond, setup.wall, setup.region);
        change_snapshot([&](SurgerySnapshot& next) {
            next.planned_force = setup.planned_force;
            next.labels = setup.labels;
            next.outline = std::move(outline);
            next.beyond = std::move(beyond);
        });
        return start_session(std::move(setup), {}, {}, job);
    });
}

/// Creates the session, with the saved cuts when there are some and the user wants them. Nothing on disk is lost: cuts
/// that are not restored are set aside.
/// @param kept the saved cuts; empty: they must be read
/// @param wanted the user's answer; empty: the user was not asked
/// @return null when the user must answer first
std::unique_ptr<SurgerySession> SurgeryWorker::start_session(
    SurgerySetup setup, std::optional<SavedCuts> kept, std::optional<bool> wanted, const Job& job)
{
    if (setup.journal.empty())
        return std::make_unique<SurgerySession>(std::move(setup), job);
    try {
        drop_empty(setup.journal);
        if (std::filesystem::exists(setup.journal)) {
            try {
                if (!kept)
                    kept = read_saved_cuts(setup.journal, setup.wall, job);
                if (!wanted && kept->worth_asking()) {
                    ask_to_restore(std::move(setup), std::move(*kept));
                    return nullptr;
                }
                if (wanted.value_or(true)) {
                    if (!kept->note.empty())
                        set_status(kept->note, false);
                    return std::make_unique<SurgerySession>(restored_session(setup, *kept, job, &waiting_));
                }
                const std::filesystem::path other = set_aside(setup.journal);
                set_status("The former cuts are set aside in " + other.string(), false);
            } catch (const InputError&) {
                if (job.cancelled())
                    throw;
                const std::filesystem::path other = set_aside(setup.journal);
                set_status("the former cuts do not fit and are set aside in " + other.string() + " ("
                        + to_string(current_failure()) + ")",
                    true);
            }
        }
        return std::make_unique<SurgerySession>(new_session(setup, job, &waiting_));
    } catch (const IoError&) {
        not_kept_ = to_string(current_failure());
        set_status("cuts are not kept on disk: " + not_kept_, true);
        return std::make_unique<SurgerySession>(std::move(setup), job);
    }
}

void SurgeryWorker::ask_to_restore(SurgerySetup setup, SavedCuts kept)
{
    RETRACTOR_ASSERT(!question_);
    change_snapshot([&](SurgerySnapshot& next) {
        next.phase = SurgerySnapshot::Phase::asking;
        next.saved_cuts = kept.deltas.size();
    });
    question_ = Question { std::move(setup), std::move(kept) };
    announce();
}

/// Takes the new session and runs the commands that arrived while the question was open. When there is no session, the
/// snapshot gives the reason.
/// @param start returns null when the user must answer a question first
void SurgeryWorker::make_ready(const std::function<std::unique_ptr<SurgerySession>()>& start)
{
    try {
        std::unique_ptr<SurgerySession> live_session = start();
        if (question_)
            return;
        if (!caution_.empty())
            add_status(caution_);
        publish(*live_session);
        live_session_ = std::move(live_session);
    } catch (...) {
        change_snapshot([failure = to_string(current_failure())](SurgerySnapshot& next) {
            next.phase = SurgerySnapshot::Phase::failed;
            next.failure = failure;
        });
        announce();
    }
    std::vector<surgery::Command> commands;
    {
        const std::lock_guard lock(mutex_);
        std::swap(commands, deferred_);
    }
    if (live_session_ != nullptr)
        for (const surgery::Command& command : commands)
            execute(command);
}

/// @pre there is a session
void SurgeryWorker::execute(const surgery::Command& command)
{
    RETRACTOR_ASSERT(live_session_ != nullptr);
    changed_ = true;
    KnifeAnswer answer;
    try {
        const Runner runner { *this, *live_session_ };
        answer = std::visit(
            [&](const auto& asked) -> KnifeAnswer {
                if constexpr (std::is_void_v<decltype(runner(asked))>)
                    return runner(asked), KnifeAnswer { true, {} };
                else
                    return runner(asked);
            },
            command);
    } catch (...) {
        answer = { false, to_string(current_failure()) };
    }
    if (!answer.reason.empty())
        set_status(std::move(answer.reason), !answer.done);
    take_remark();
}

void SurgeryWorker::take_remark()
{
    if (std::string remark = live_session_->take_remark(); !remark.empty())
        set_status(std::move(remark), true);
}

/// Computes one frame and shows it at once.
void SurgeryWorker::open_wound()
{
    if (live_session_->waiting()) // there is nothing to draw, and the background work needs the cores
        return;
    const Stopwatch watch;
    Job job;
    job.cancel = &executor_.task_waits();
    live_session_->relax(kFrameMs, job);
    take_remark();
    change_snapshot([&](SurgerySnapshot& next) { next.relax_ms = 1e3 * watch.seconds(); });
    publish(*live_session_);
}

/// After commands: publishes a snapshot of the changes. Otherwise: computes the next frame of an opening wound.
std::optional<std::chrono::steady_clock::time_point> SurgeryWorker::step()
{
    if (live_session_ == nullptr)
        return {};
    try {
        if (std::exchange(changed_, false))
            publish(*live_session_);
        else if (live_session_->moving())
            open_wound();
    } catch (const std::exception& error) { // no memory for the picture: the cuts are made, and the knife goes on
        set_status(std::string("the picture could not be brought up to date: ") + error.what(), true);
        announce();
    }
    if (!live_session_->moving())
        return {};
    const auto now = std::chrono::steady_clock::now();
    return live_session_->hooks_unsettled() ? now + kHandRests : now;
}

} // namespace retractor::planner
