#include "planner/session/knife_worker.h"

#include "mesh/base/error.h"
#include "mesh/mesh_io.h"
#include "planner/words.h"

#include <chrono>
#include <exception>
#include <utility>

namespace retractor {

namespace {

    /// The wound opens in frames of this length: short enough that the knife never waits long for one.
    constexpr double kFrameMs = 40.0;

    /// A hook that has not moved for so long lies still: its numbers are worked out.
    constexpr std::chrono::milliseconds kHandRests { 150 };

} // namespace

KnifeWorker::KnifeWorker(std::function<OperatingTable(const Job&)> prepare, std::function<void()> on_news)
    : on_news_(std::move(on_news))
    , executor_({ .step = [this] { return step(); },
          .on_progress = [this] { announce(); },
          .when_destroyed = WaitingTasks::run })
{
    executor_.post([this, prepare = std::move(prepare)](const Job& job) { prepare_desk(prepare, job); });
}

KnifeWorker::~KnifeWorker()
{
    executor_.post([this](const Job&) {
        if (desk_ != nullptr && desk_->stroke_open())
            carry_out([](CuttingDesk& desk) { return desk.finish_stroke(); });
        desk_.reset(); // on the thread that it was used on
    });
}

void KnifeWorker::post(Order order) { post_latest({}, std::move(order)); }

void KnifeWorker::post_latest(const std::string& key, Order order)
{
    executor_.post_latest(key, [this, order = std::move(order)](const Job&) {
        if (desk_ != nullptr) {
            carry_out(order);
        } else if (question_) {
            const std::lock_guard lock(mutex_);
            deferred_.push_back(order);
        }
    });
}

void KnifeWorker::restore(bool wanted)
{
    {
        const std::lock_guard lock(mutex_);
        if (news_.phase != KnifeNews::Phase::asking)
            return;
    }
    executor_.post([this, wanted](const Job& job) {
        if (!question_) // answered already
            return;
        {
            const std::lock_guard lock(mutex_);
            news_.phase = KnifeNews::Phase::preparing;
        }
        Question asked = std::move(*std::exchange(question_, std::nullopt));
        make_ready([&] { return lay_desk(std::move(asked.table), std::move(asked.kept), wanted, job); });
    });
}

std::size_t KnifeWorker::begin_stroke(const Touch& at, const KnifeSettings& settings)
{
    const std::size_t number = ++strokes_;
    post([this, at, settings, number](CuttingDesk& desk) {
        refused_stroke_ = number; // until it has begun
        if (desk.stroke_open()) // its end was refused, by a full disk for example: once more
            if (KnifeAnswer former = finish(desk); !former.reason.empty()) {
                say(std::move(former.reason), !former.done);
                if (desk.stroke_open())
                    return KnifeAnswer { true, {} }; // it is said
            }
        KnifeAnswer begun = desk.begin_stroke(at, settings);
        if (begun.done)
            refused_stroke_ = 0;
        return begun;
    });
    return number;
}

void KnifeWorker::draw_to(const Touch& at)
{
    // A stroke that was refused has no line to draw on.
    post([this, at, number = strokes_](CuttingDesk& desk) {
        return desk.stroke_open() && refused_stroke_ != number ? desk.draw_to(at) : KnifeAnswer { true, {} };
    });
}

void KnifeWorker::leave_wall()
{
    post([this, number = strokes_](CuttingDesk& desk) {
        if (desk.stroke_open() && refused_stroke_ != number)
            desk.leave_wall();
        return KnifeAnswer { true, {} };
    });
}

void KnifeWorker::finish_stroke()
{
    post([this, number = strokes_](CuttingDesk& desk) {
        return desk.stroke_open() && refused_stroke_ != number ? finish(desk) : KnifeAnswer { true, {} };
    });
}

KnifeAnswer KnifeWorker::finish(CuttingDesk& desk)
{
    try {
        return desk.finish_stroke();
    } catch (const Error&) {
        return { false, to_string(current_failure()) + "; the stroke is still open: Esc takes it back" };
    }
}

void KnifeWorker::abandon_stroke()
{
    post([](CuttingDesk& desk) -> KnifeAnswer {
        desk.abandon_stroke();
        return { true, {} };
    });
}

void KnifeWorker::take_out(const Touch& at, double radius_mm)
{
    post([at, radius_mm](CuttingDesk& desk) { return desk.take_out(at, radius_mm); });
}

void KnifeWorker::undo()
{
    post([](CuttingDesk& desk) -> KnifeAnswer {
        if (desk.can_undo())
            desk.undo();
        return { true, {} };
    });
}

void KnifeWorker::redo()
{
    post([](CuttingDesk& desk) -> KnifeAnswer {
        if (desk.can_redo())
            desk.redo();
        return { true, {} };
    });
}

void KnifeWorker::go_to(std::size_t cuts)
{
    post([cuts](CuttingDesk& desk) -> KnifeAnswer {
        while (desk.can_undo() && desk.session().cut_count() > cuts)
            desk.undo();
        while (desk.can_redo() && desk.session().cut_count() < cuts)
            desk.redo();
        return { true, {} };
    });
}

void KnifeWorker::set_tension(double strain)
{
    post([strain](CuttingDesk& desk) -> KnifeAnswer {
        desk.set_tension(strain);
        return { true, {} };
    });
}

void KnifeWorker::place_hook(const Touch& at)
{
    post([at](CuttingDesk& desk) { return desk.place_hook(at); });
}

void KnifeWorker::take_planned_hooks()
{
    post([](CuttingDesk& desk) { return desk.take_planned_hooks(); });
}

void KnifeWorker::pull_hook(HookId hook, const Vec3& asked)
{
    post_latest("hook " + std::to_string(hook), [hook, asked](CuttingDesk& desk) -> KnifeAnswer {
        desk.pull_hook(hook, asked);
        return { true, {} };
    });
}

void KnifeWorker::pull_all_hooks(double mm)
{
    post_latest("all hooks", [mm](CuttingDesk& desk) -> KnifeAnswer {
        desk.pull_all_hooks(mm);
        return { true, {} };
    });
}

void KnifeWorker::pull_hooks_by_share(double share)
{
    post_latest("all hooks", [share](CuttingDesk& desk) -> KnifeAnswer {
        desk.pull_hooks_by_share(share);
        return { true, {} };
    });
}

void KnifeWorker::set_yield(double force_N)
{
    post([force_N](CuttingDesk& desk) -> KnifeAnswer {
        desk.set_yield(force_N);
        return { true, {} };
    });
}

void KnifeWorker::set_nonlinear(bool wanted)
{
    post([wanted](CuttingDesk& desk) -> KnifeAnswer {
        desk.set_nonlinear(wanted);
        return { true, {} };
    });
}

void KnifeWorker::take_off_hook(HookId hook)
{
    post([hook](CuttingDesk& desk) -> KnifeAnswer {
        desk.take_off_hook(hook);
        return { true, {} };
    });
}

void KnifeWorker::take_off_hooks()
{
    post([](CuttingDesk& desk) -> KnifeAnswer {
        desk.take_off_hooks();
        return { true, {} };
    });
}

void KnifeWorker::export_wall(const std::filesystem::path& path)
{
    post([path](CuttingDesk& desk) -> KnifeAnswer {
        if (desk.stroke_open())
            return { false, "a stroke is open: finish it first" };
        write_vtu(path, desk.session().compact_mesh());
        return { true, "Saved " + path.string() };
    });
}

KnifeNews KnifeWorker::news()
{
    const SerialExecutor::Progress progress = executor_.progress();
    const std::lock_guard lock(mutex_);
    announced_ = false;
    KnifeNews news = news_;
    news.stage = progress.stage;
    news.fraction = progress.fraction;
    return news;
}

bool KnifeWorker::idle() const
{
    if (!executor_.idle())
        return false;
    const std::lock_guard lock(mutex_);
    return deferred_.empty();
}

void KnifeWorker::announce()
{
    {
        const std::lock_guard lock(mutex_);
        if (std::exchange(announced_, true))
            return;
    }
    on_news_();
}

void KnifeWorker::say(std::string answer, bool refused)
{
    const std::lock_guard lock(mutex_);
    news_.answer = std::move(answer);
    news_.refused = refused;
    ++news_.answers;
}

void KnifeWorker::say_too(const std::string& more)
{
    const std::lock_guard lock(mutex_);
    remark(news_.answer, more);
    ++news_.answers;
}

void KnifeWorker::ask_to_restore(OperatingTable table, KeptCuts kept)
{
    {
        const std::lock_guard lock(mutex_);
        news_.phase = KnifeNews::Phase::asking;
        news_.kept_cuts = kept.deltas.size();
    }
    question_ = Question { std::move(table), std::move(kept) };
    announce();
}

/// With the cuts of the last time where there are some and they are wanted. Nothing on disk is lost: what is not
/// restored is set aside.
/// @param kept nothing: still to be read. @param wanted the answer to the question; nothing: it was not asked.
/// @return null: the question has to be answered first.
std::unique_ptr<CuttingDesk> KnifeWorker::lay_desk(
    OperatingTable table, std::optional<KeptCuts> kept, std::optional<bool> wanted, const Job& job)
{
    if (table.journal.empty())
        return std::make_unique<CuttingDesk>(std::move(table), job);
    try {
        if (std::filesystem::exists(table.journal)) {
            try {
                if (!kept)
                    kept = read_kept_cuts(table.journal, table.wall, job);
                if (!wanted && kept->worth_asking()) {
                    ask_to_restore(std::move(table), std::move(*kept));
                    return nullptr;
                }
                if (wanted.value_or(true)) {
                    if (!kept->note.empty())
                        say(kept->note, false);
                    return std::make_unique<CuttingDesk>(restore_desk(table, *kept, job));
                }
                const std::filesystem::path other = set_aside(table.journal);
                say("The former cuts are set aside in " + other.string(), false);
            } catch (const InputError&) {
                if (job.cancelled())
                    throw;
                const std::filesystem::path other = set_aside(table.journal);
                say("the former cuts do not fit and are set aside in " + other.string() + " ("
                        + to_string(current_failure()) + ")",
                    true);
            }
        }
        return std::make_unique<CuttingDesk>(fresh_desk(table, job));
    } catch (const IoError&) {
        say("cuts are not kept on disk: " + to_string(current_failure()), true);
        return std::make_unique<CuttingDesk>(std::move(table), job);
    }
}

void KnifeWorker::prepare_desk(const std::function<OperatingTable(const Job&)>& prepare, const Job& job)
{
    make_ready([&] {
        OperatingTable table = prepare(job);
        caution_ = table.caution;
        auto outline = std::make_shared<const std::vector<EdgePlace>>(
            region_outline(table.wall, table.region, table.labels, table.outward));
        std::shared_ptr<const BeyondSurface> beyond;
        if (table.beyond != nullptr && !table.beyond->triangles.empty())
            beyond = std::make_shared<const BeyondSurface>(table.beyond, table.wall, table.region);
        {
            const std::lock_guard lock(mutex_);
            news_.labels = table.labels;
            news_.outline = std::move(outline);
            news_.beyond = std::move(beyond);
        }
        return lay_desk(std::move(table), {}, {}, job);
    });
}

/// Takes the desk that was laid, and what was ordered while the question was open; says why there is none.
/// @param lay null: the question is asked.
void KnifeWorker::make_ready(const std::function<std::unique_ptr<CuttingDesk>()>& lay)
{
    try {
        std::unique_ptr<CuttingDesk> desk = lay();
        if (question_)
            return;
        if (!caution_.empty())
            say_too(caution_);
        tell(*desk);
        desk_ = std::move(desk);
    } catch (...) {
        {
            const std::lock_guard lock(mutex_);
            news_.phase = KnifeNews::Phase::failed;
            news_.failure = to_string(current_failure());
        }
        announce();
    }
    std::vector<Order> orders;
    {
        const std::lock_guard lock(mutex_);
        std::swap(orders, deferred_);
    }
    if (desk_ != nullptr)
        for (const Order& order : orders)
            carry_out(order);
}

void KnifeWorker::tell(CuttingDesk& desk)
{
    const Stopwatch watch;
    const std::shared_ptr<const WallPicture> picture = desk.picture();
    const double picture_ms = 1e3 * watch.seconds();
    {
        const std::lock_guard lock(mutex_);
        news_.phase = KnifeNews::Phase::ready;
        if (news_.picture != picture)
            news_.picture_ms = picture_ms;
        news_.picture = picture;
        news_.cuts = desk.cuts();
        news_.can_undo = desk.can_undo();
        news_.can_redo = desk.can_redo();
        news_.stroke_open = desk.stroke_open();
        news_.refused_stroke = refused_stroke_;
        news_.step_ms = desk.step_ms();
        news_.tension = desk.tension();
        news_.case_tension = desk.case_tension();
        news_.gape_mm = desk.gape_mm();
        news_.moving = desk.moving();
        news_.hooks = desk.hooks();
        news_.planned_hooks = desk.planned_hooks();
    }
    announce();
}

/// @pre there is a desk
void KnifeWorker::carry_out(const Order& order)
{
    changed_ = true;
    KnifeAnswer said;
    try {
        said = order(*desk_);
    } catch (...) {
        said = { false, to_string(current_failure()) };
    }
    if (!said.reason.empty())
        say(std::move(said.reason), !said.done);
    say_remark(*desk_);
}

void KnifeWorker::say_remark(CuttingDesk& desk)
{
    if (std::string remark = desk.take_remark(); !remark.empty())
        say(std::move(remark), true);
}

/// One frame, shown at once.
void KnifeWorker::open_wound(CuttingDesk& desk)
{
    if (desk.waiting()) // there is nothing to draw: the cores are left to what is waited for
        return;
    const Stopwatch watch;
    Job job;
    job.cancel = &executor_.task_waits();
    desk.relax(kFrameMs, job);
    say_remark(desk);
    {
        const std::lock_guard lock(mutex_);
        news_.relax_ms = 1e3 * watch.seconds();
    }
    tell(desk);
}

/// After orders: tells what has become of them. Else: the next frame of a wound that opens.
std::optional<std::chrono::steady_clock::time_point> KnifeWorker::step()
{
    if (desk_ == nullptr)
        return {};
    try {
        if (std::exchange(changed_, false))
            tell(*desk_);
        else if (desk_->moving())
            open_wound(*desk_);
    } catch (const std::exception& error) { // no memory for the picture: the cuts stand, and the knife goes on
        say(std::string("the picture could not be brought up to date: ") + error.what(), true);
        announce();
    }
    if (!desk_->moving())
        return {};
    const auto now = std::chrono::steady_clock::now();
    return desk_->hooks_unsettled() ? now + kHandRests : now;
}

} // namespace retractor
