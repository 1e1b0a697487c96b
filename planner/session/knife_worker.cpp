#include "planner/session/knife_worker.h"

#include "mesh/base/error.h"
#include "mesh/mesh_io.h"
#include "planner/session/kept_cuts.h"
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

    struct Stopped { };

} // namespace

KnifeWorker::KnifeWorker(std::function<OperatingTable(const Job&)> prepare, std::function<void()> on_news)
    : on_news_(std::move(on_news))
    , thread_([this, prepare = std::move(prepare)] { run(prepare); })
{
}

KnifeWorker::~KnifeWorker()
{
    cancel_.store(true);
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        called_.store(true);
    }
    wake_.notify_one();
    thread_.join();
}

void KnifeWorker::post(Order order)
{
    {
        const std::lock_guard lock(mutex_);
        orders_.push_back(std::move(order));
        called_.store(true);
    }
    wake_.notify_one();
}

void KnifeWorker::restore(bool wanted)
{
    {
        const std::lock_guard lock(mutex_);
        if (news_.phase != KnifeNews::Phase::asking)
            return;
        restore_ = wanted;
    }
    wake_.notify_one();
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

void KnifeWorker::post_pull(const std::function<void()>& note)
{
    bool waits = false;
    {
        const std::lock_guard lock(mutex_);
        waits = pulls_.has_value();
        if (!waits)
            pulls_.emplace();
        note();
    }
    if (!waits)
        post([this](CuttingDesk& desk) { return pull_newest(desk); });
}

void KnifeWorker::pull_hook(HookId hook, const Vec3& asked)
{
    post_pull([&] { pulls_->of_hook[hook] = asked; });
}

void KnifeWorker::pull_all_hooks(double mm)
{
    post_pull([&] { *pulls_ = { .all = [mm](CuttingDesk& desk) { desk.pull_all_hooks(mm); }, .of_hook = {} }; });
}

void KnifeWorker::pull_hooks_by_share(double share)
{
    post_pull([&] { // what single hooks were drawn to before stays theirs
        pulls_->all = [share](CuttingDesk& desk) { desk.pull_hooks_by_share(share); };
    });
}

KnifeAnswer KnifeWorker::pull_newest(CuttingDesk& desk)
{
    Pulls pulls;
    {
        const std::lock_guard lock(mutex_);
        pulls = *std::exchange(pulls_, std::nullopt);
    }
    if (pulls.all)
        pulls.all(desk);
    for (const auto& [hook, asked] : pulls.of_hook)
        desk.pull_hook(hook, asked);
    return { true, {} };
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
    const std::lock_guard lock(mutex_);
    announced_ = false;
    return news_;
}

bool KnifeWorker::idle() const
{
    const std::lock_guard lock(mutex_);
    return !busy_ && orders_.empty();
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

bool KnifeWorker::ask_to_restore(std::size_t kept_cuts)
{
    {
        const std::lock_guard lock(mutex_);
        news_.phase = KnifeNews::Phase::asking;
        news_.kept_cuts = kept_cuts;
        busy_ = false;
    }
    announce();
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return stop_ || restore_.has_value(); });
    if (stop_)
        throw Stopped {};
    busy_ = true;
    news_.phase = KnifeNews::Phase::preparing;
    return *restore_;
}

/// With the cuts of the last time where there are some and they are wanted. Nothing on disk is lost: what is not
/// restored is set aside.
std::unique_ptr<CuttingDesk> KnifeWorker::lay_desk(OperatingTable table, const Job& job)
{
    if (table.journal.empty())
        return std::make_unique<CuttingDesk>(std::move(table), job);
    try {
        if (std::filesystem::exists(table.journal)) {
            try {
                const KeptCuts kept = read_kept_cuts(table.journal, table.wall, job);
                if (!kept.worth_asking() || ask_to_restore(kept.deltas.size())) {
                    if (!kept.note.empty())
                        say(kept.note, false);
                    return std::make_unique<CuttingDesk>(restore_desk(table, kept, job));
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

std::unique_ptr<CuttingDesk> KnifeWorker::prepare_desk(const std::function<OperatingTable(const Job&)>& prepare)
{
    Job job;
    job.cancel = &cancel_;
    job.on_progress = [this](std::string_view stage, double fraction) {
        {
            const std::lock_guard lock(mutex_);
            news_.stage = stage;
            news_.fraction = fraction;
        }
        announce();
    };
    std::string failure;
    try {
        OperatingTable table = prepare(job);
        const std::string caution = table.caution;
        LabelTable labels = table.labels;
        auto outline = std::make_shared<const std::vector<EdgePlace>>(
            region_outline(table.wall, table.region, table.labels, table.outward));
        std::shared_ptr<const BeyondSurface> beyond;
        if (table.beyond != nullptr && !table.beyond->triangles.empty())
            beyond = std::make_shared<const BeyondSurface>(table.beyond, table.wall, table.region);
        auto desk = lay_desk(std::move(table), job);
        if (!caution.empty())
            say_too(caution);
        {
            const std::lock_guard lock(mutex_);
            news_.labels = std::move(labels);
            news_.outline = std::move(outline);
            news_.beyond = std::move(beyond);
        }
        tell(*desk);
        return desk;
    } catch (const Stopped&) {
        return nullptr;
    } catch (...) {
        failure = to_string(current_failure());
    }
    const std::lock_guard lock(mutex_);
    news_.phase = KnifeNews::Phase::failed;
    news_.failure = std::move(failure);
    return nullptr;
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

void KnifeWorker::carry_out(CuttingDesk& desk, const std::deque<Order>& orders)
{
    for (const Order& order : orders) {
        KnifeAnswer said;
        try {
            said = order(desk);
        } catch (...) {
            said = { false, to_string(current_failure()) };
        }
        if (!said.reason.empty())
            say(std::move(said.reason), !said.done);
        say_remark(desk);
    }
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
    job.cancel = &called_;
    desk.relax(kFrameMs, job);
    say_remark(desk);
    {
        const std::lock_guard lock(mutex_);
        news_.relax_ms = 1e3 * watch.seconds();
    }
    tell(desk);
}

void KnifeWorker::work(CuttingDesk& desk, const std::deque<Order>& orders, bool stop)
{
    try {
        carry_out(desk, orders);
        if (stop) {
            if (desk.stroke_open())
                carry_out(desk, { [](CuttingDesk& open) { return open.finish_stroke(); } });
        } else if (orders.empty())
            open_wound(desk);
        else
            tell(desk);
    } catch (const std::exception& error) { // no memory for the picture: the cuts stand, and the knife goes on
        say(std::string("the picture could not be brought up to date: ") + error.what(), true);
        announce();
    }
}

void KnifeWorker::run(const std::function<OperatingTable(const Job&)>& prepare)
{
    const std::unique_ptr<CuttingDesk> desk = prepare_desk(prepare);
    if (desk == nullptr)
        announce();
    while (true) {
        std::deque<Order> orders;
        bool stop = false;
        {
            std::unique_lock lock(mutex_);
            const bool moving = desk != nullptr && desk->moving();
            busy_ = moving;
            const auto called = [&] { return stop_ || !orders_.empty(); };
            if (moving && desk->hooks_unsettled())
                wake_.wait_for(lock, kHandRests, called);
            else
                wake_.wait(lock, [&] { return moving || called(); });
            std::swap(orders, orders_);
            called_.store(false);
            stop = stop_;
            busy_ = true;
        }
        if (desk != nullptr)
            work(*desk, orders, stop);
        if (stop)
            return;
    }
}

} // namespace retractor
