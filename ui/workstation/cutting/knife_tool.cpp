#include "ui/workstation/cutting/knife_tool.h"

#include "planner/approach/hook_mesh.h"
#include "ui/scene/tissue_colors.h"
#include "ui/workstation/language/stage_words.h"

#include <QLineF>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <variant>

namespace retractor::ui {

namespace {

    /// Distance (pixels) of the points at which the line between two mouse positions follows the skin.
    constexpr double kFeelEveryPx = 3.0;
    constexpr double kLineWidthPx = 2.5;
    constexpr double kPlannedWidthPx = 3.0;
    /// Outline of the region that can be cut: visible, but not conspicuous.
    constexpr Color kOutlineColor { 0.98, 0.93, 0.85 };
    constexpr double kOutlineWidthPx = 1.5;
    /// Skin cut through: the dermis is paler than muscle and redder than skin.
    constexpr Color kCutSkin { 0.80, 0.36, 0.33 };

    /// The present place of the hook's patch: it moves as the tissue that it holds. A blade may reach deeper than that.
    Vec3 shown_centre(const planner::HookState& hook, const planner::WallPicture& picture)
    {
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for (const VertexId v : hook.placement.nodes)
            if (v < picture.shown.rows() && v < picture.surface->rest.rows()) {
                sum += (picture.shown.row(v) - picture.surface->rest.row(v)).transpose();
                ++count;
            }
        return count > 0 ? Vec3(hook.placement.centre + sum / count) : hook.placement.centre;
    }

    const planner::HookState* hook_of(const planner::HookReport& report, fem::HookId id)
    {
        const auto found = std::find_if(
            report.hooks.begin(), report.hooks.end(), [&](const planner::HookState& hook) { return hook.id == id; });
        return found == report.hooks.end() ? nullptr : &*found;
    }

    planner::HookShape shape_of(const planner::HookState& hook, const planner::WallPicture& picture, double shaft_mm)
    {
        return { .name = hook.name,
            .position = shown_centre(hook, picture),
            .pull = hook.placement.pull,
            .outward = -hook.placement.inward,
            .width_mm = hook.placement.width_mm,
            .depth_mm = hook.placement.height_mm,
            .shaft_mm = shaft_mm };
    }

    constexpr double kShaftMm = 60.0; ///< of a hook in a hand
    constexpr double kBladeShaftMm = 10.0; ///< up to the arm of a retractor

    bool is_blade_of(const planner::RetractorState& retractor, fem::HookId id)
    {
        return std::find(retractor.blades.begin(), retractor.blades.end(), id) != retractor.blades.end();
    }

    /// A blade hangs on its arm, turned about it: the steel lies where the rack puts it, while tissue slides along it.
    planner::HookShape blade_shape(
        const planner::HookReport& report, const planner::RetractorState& retractor, std::size_t blade)
    {
        const auto* hook = hook_of(report, retractor.blades[blade]);
        if (hook == nullptr)
            return {};
        const planner::HookPlacement& placement = hook->placement;
        const Eigen::AngleAxisd turn(retractor.turn_rad[blade], placement.pull.cross(placement.inward).normalized());
        const Vec3 inward = turn * placement.inward;
        return { .name = hook->name,
            .position = placement.arm + retractor.arm_mm[blade] * placement.pull + 0.5 * placement.height_mm * inward,
            .pull = turn * placement.pull,
            .outward = -inward,
            .width_mm = placement.width_mm,
            .depth_mm = placement.height_mm,
            .shaft_mm = kBladeShaftMm };
    }

    TriMesh steel_of(const planner::HookState& hook, const planner::SurgerySnapshot& snapshot)
    {
        for (const planner::RetractorState& retractor : snapshot.hooks.retractors)
            for (std::size_t blade = 0; blade < 2; ++blade)
                if (retractor.blades[blade] == hook.id)
                    return planner::hook_mesh(blade_shape(snapshot.hooks, retractor, blade));
        return planner::hook_mesh(shape_of(hook, *snapshot.picture, kShaftMm));
    }

    /// The arms and the rack of a retractor.
    TriMesh rack_of(const planner::RetractorState& retractor, const planner::SurgerySnapshot& snapshot)
    {
        const auto* first = hook_of(snapshot.hooks, retractor.blades[0]);
        const auto* second = hook_of(snapshot.hooks, retractor.blades[1]);
        return first == nullptr || second == nullptr
            ? TriMesh {}
            : planner::rack_mesh(blade_shape(snapshot.hooks, retractor, 0), blade_shape(snapshot.hooks, retractor, 1));
    }

    void append(TriMesh& all, const TriMesh& mesh)
    {
        const auto first = static_cast<VertexId>(all.vertices.rows());
        all.vertices.conservativeResize(first + mesh.vertices.rows(), 3);
        all.vertices.bottomRows(mesh.vertices.rows()) = mesh.vertices;
        for (const auto& t : mesh.triangles)
            all.triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
    }

    Look lip_look(const Look& tissue)
    {
        Look look = tissue;
        if (look.finish == Finish::skin)
            look.color = kCutSkin;
        if (look.finish != Finish::bone)
            look.finish = Finish::wet;
        return look;
    }

    /// @param hidden per triangle, 1: not drawn; empty: all are
    LiveTopology topology_of(const planner::WallSurface& surface, const std::vector<std::uint8_t>& hidden,
        const std::map<Label, Look>& looks)
    {
        LiveTopology topology;
        topology.rest = surface.rest;
        topology.rims = planner::wound_rims(surface);
        std::map<std::pair<Label, bool>, int> number_of;
        // All looks exist from the start, so that their number stays the same when the first lip appears.
        for (const auto& [label, look] : looks)
            for (const bool lip : { false, true }) {
                number_of[{ label, lip }] = static_cast<int>(topology.looks.size());
                topology.looks.push_back(lip ? lip_look(look) : look);
            }
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            if (hidden.empty() || hidden[t] == 0) {
                topology.triangles.push_back(surface.triangles[t]);
                topology.look_of.push_back(number_of.at({ surface.labels[t], surface.is_lip[t] != 0 }));
            }
        return topology;
    }

    LiveTopology topology_of(const TriMesh& body, const std::map<Label, Look>& looks)
    {
        LiveTopology topology;
        topology.triangles = body.triangles;
        topology.rest = body.vertices;
        std::map<Label, int> number_of;
        for (const auto& [label, look] : looks) {
            number_of[label] = static_cast<int>(topology.looks.size());
            topology.looks.push_back(look);
        }
        for (const Label label : body.labels)
            topology.look_of.push_back(number_of.at(label));
        return topology;
    }

} // namespace

std::vector<vtkProp*> KnifeTool::Props::props() const
{
    std::vector<vtkProp*> all = wall.props();
    const std::vector<vtkProp*> more = beyond.props();
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

KnifeTool::KnifeTool(PictureView& view, KnifePanel& panel)
    : view_(view)
    , panel_(panel)
{
    panel_.on_restore = [this](bool wanted) {
        say({}, false); // what was refused before the answer
        if (shown() != nullptr)
            shown()->worker->restore(wanted);
        view_.setFocus(); // takes the focus from the buttons, for looking and undoing
    };
    panel_.on_command = [this](planner::surgery::Command command) { run(std::move(command)); };
    constexpr int kAgeMs = 500;
    age_timer_.setInterval(kAgeMs);
    connect(&age_timer_, &QTimer::timeout, this, [this] { panel_.show_sight(sight_.text()); });
    sight_.on_change = [this] { panel_.show_sight(sight_.text()); };
}

KnifeTool::~KnifeTool()
{
    view_.set_tool(nullptr);
    view_.set_live(nullptr);
}

KnifeTool::Session* KnifeTool::shown() { return shown_ ? &sessions_.at(*shown_) : nullptr; }
const KnifeTool::Session* KnifeTool::shown() const { return shown_ ? &sessions_.at(*shown_) : nullptr; }

void KnifeTool::set_up(std::size_t approach, std::function<SurgeryInput(const Job&)> prepare)
{
    if (shown_ == approach)
        return;
    leave();
    Session& session = sessions_[approach];
    shown_ = approach;
    if (session.worker == nullptr || session.snapshot->phase == planner::SurgerySnapshot::Phase::failed) {
        session.snapshot = std::make_shared<const planner::SurgerySnapshot>();
        session.surroundings = std::make_shared<Scene>();
        session.look = std::make_shared<SightWatch::Look>();
        session.planned_force.reset();
        auto make_setup
            = [prepare = std::move(prepare), surroundings = session.surroundings, look = session.look](const Job& job) {
                  SurgeryInput input = prepare(job);
                  *surroundings = std::move(input.surroundings);
                  *look = std::move(input.look);
                  return std::move(input.setup);
              };
        session.worker = std::make_unique<planner::SurgeryWorker>(std::move(make_setup), [this, approach] {
            QMetaObject::invokeMethod(
                this, [this, approach] { take_snapshot(approach); }, Qt::QueuedConnection);
        });
    }
    answers_ = session.snapshot->answers;
    run(planner::surgery::SetTension { panel_.tension() });
    run(planner::surgery::SetYield { panel_.yield_N() });
    run(planner::surgery::SetNonlinear { panel_.nonlinear() });
    show_picture();
}

void KnifeTool::set_planned_force(std::size_t approach, const std::optional<planner::PlannedForce>& force)
{
    const auto found = sessions_.find(approach);
    if (found == sessions_.end() || (found->second.planned_force && *found->second.planned_force == force))
        return;
    found->second.planned_force = force;
    found->second.worker->run(planner::surgery::SetPlannedForce { force });
}

void KnifeTool::leave()
{
    if (shown_) { // otherwise the picture is not the knife's
        end_stroke();
        drawn_surface_.reset();
        shown_.reset();
        view_.set_live(nullptr);
    }
    sight_.forget();
    age_timer_.stop();
    panel_.show_sight({});
    panel_.show_snapshot(nullptr, 0.0);
}

void KnifeTool::keep_only(const std::vector<std::size_t>& approaches)
{
    if (shown_ && std::find(approaches.begin(), approaches.end(), *shown_) == approaches.end())
        leave();
    std::erase_if(sessions_, [&](const auto& entry) {
        return std::find(approaches.begin(), approaches.end(), entry.first) == approaches.end()
            && entry.second.worker->idle();
    });
}

void KnifeTool::clear()
{
    leave();
    sessions_.clear();
    panel_.offer_case_tension(0.0);
    case_tension_offered_ = false;
}

void KnifeTool::set_mode(KnifeMode mode)
{
    if (mode != mode_) {
        end_stroke();
        say({}, false); // what the tool before refused
    }
    mode_ = mode;
    view_.set_tool(mode == KnifeMode::away ? nullptr : this);
    if (drawn_surface_ != nullptr)
        show_beyond();
    view_.draw_soon();
}

/// Finishes the present stroke, when the mouse is needed elsewhere.
void KnifeTool::end_stroke()
{
    if (std::exchange(drawing_, false))
        run(planner::surgery::FinishStroke {});
    first_.reset();
    grip_.reset();
    line_.clear();
    show_line();
}

bool KnifeTool::abandon()
{
    // A stroke with a refused end is open although no button is down.
    const bool open = std::exchange(drawing_, false) || (snapshot() != nullptr && snapshot()->stroke_open);
    const bool any = open || first_.has_value();
    if (open)
        run(planner::surgery::AbandonStroke {});
    end_stroke();
    return any;
}

void KnifeTool::run(planner::surgery::Command command)
{
    if (!std::holds_alternative<planner::surgery::Crank>(command))
        cranked_.since.invalidate(); // the next notch goes on from what this leaves
    const bool history = std::holds_alternative<planner::surgery::Undo>(command)
        || std::holds_alternative<planner::surgery::Redo>(command)
        || std::holds_alternative<planner::surgery::GoTo>(command);
    if (shown() != nullptr && !(history && drawing_))
        shown()->worker->run(std::move(command));
}

void KnifeTool::say(const std::string& text, bool refused) const
{
    if (on_answer)
        on_answer(text, refused);
}

std::shared_ptr<const Scene> KnifeTool::scene() const
{
    const Session* session = shown();
    return session != nullptr && session->snapshot->phase == planner::SurgerySnapshot::Phase::ready
        ? session->surroundings
        : nullptr;
}

const planner::SurgerySnapshot* KnifeTool::snapshot() const
{
    return shown() != nullptr ? shown()->snapshot.get() : nullptr;
}

QString KnifeTool::waiting_for() const
{
    const planner::SurgerySnapshot* now = snapshot();
    if (now != nullptr && now->phase == planner::SurgerySnapshot::Phase::asking)
        return QString("Restore the cuts of the last session (%1)? Answer on the right.").arg(now->saved_cuts);
    if (now == nullptr || now->phase != planner::SurgerySnapshot::Phase::preparing)
        return {};
    return "Preparing the wall for cutting"
        + (now->stage.empty() ? QString(" …")
                              : QString(": %1 %2 %")
                                    .arg(QString::fromStdString(stage_in_words(now->stage)))
                                    .arg(static_cast<int>(100.0 * now->fraction)));
}

std::string KnifeTool::cuts_not_saved() const
{
    for (const auto& [approach, session] : sessions_)
        if (session.snapshot != nullptr && !session.snapshot->cuts_not_saved.empty())
            return session.snapshot->cuts_not_saved;
    return {};
}

bool KnifeTool::would_lose_cuts() const
{
    return std::any_of(sessions_.begin(), sessions_.end(), [](const auto& entry) {
        const auto& snapshot = entry.second.snapshot;
        return snapshot != nullptr && !snapshot->cuts_not_saved.empty() && !snapshot->cuts.empty();
    });
}

void KnifeTool::save_cuts()
{
    for (const auto& [approach, session] : sessions_)
        if (session.snapshot != nullptr && !session.snapshot->cuts_not_saved.empty())
            session.worker->run(planner::surgery::SaveCuts {});
}

bool KnifeTool::idle() const
{
    return sight_.idle() && std::all_of(sessions_.begin(), sessions_.end(), [](const auto& entry) {
        return entry.second.worker->idle()
            && entry.second.snapshot->phase != planner::SurgerySnapshot::Phase::preparing;
    });
}

void KnifeTool::take_snapshot(std::size_t approach)
{
    const auto found = sessions_.find(approach);
    if (found == sessions_.end()) // the session belongs to a case that was closed
        return;
    const std::string not_saved = cuts_not_saved();
    found->second.snapshot = found->second.worker->snapshot();
    if (shown_ != approach) {
        if (on_change && cuts_not_saved() != not_saved)
            on_change();
        return;
    }
    const planner::SurgerySnapshot& snapshot = *found->second.snapshot;
    if (snapshot.case_tension > 0.0 && !std::exchange(case_tension_offered_, true))
        panel_.offer_case_tension(snapshot.case_tension);
    show_picture();
    if (snapshot.phase == planner::SurgerySnapshot::Phase::failed)
        say(snapshot.failure, true);
    if (std::exchange(answers_, snapshot.answers) != snapshot.answers)
        say(snapshot.answer, snapshot.refused);
    // Ignores the late snapshot of an earlier stroke.
    if (drawing_ && snapshot.refused_stroke == stroke_) {
        drawing_ = false;
        line_.clear();
        show_line();
    }
    if (on_change)
        on_change();
}

void KnifeTool::show_picture()
{
    const planner::SurgerySnapshot& snapshot = *shown()->snapshot;
    panel_.show_snapshot(&snapshot, view_.draw_ms());
    if (snapshot.picture == nullptr)
        return;
    if (drawn_surface_ != snapshot.picture->surface) {
        const planner::WallSurface& surface = *snapshot.picture->surface;
        drawn_.wall.set_topology(topology_of(surface,
            snapshot.beyond != nullptr ? snapshot.beyond->replaces(surface, snapshot.labels)
                                       : std::vector<std::uint8_t> {},
            tissue_looks(snapshot.labels)));
        const bool first = drawn_surface_ == nullptr;
        drawn_surface_ = snapshot.picture->surface;
        if (first) {
            beyond_ = snapshot.beyond != nullptr ? *snapshot.beyond->rest() : TriMesh {};
            drawn_.beyond.set_topology(topology_of(beyond_, tissue_looks(snapshot.labels)));
            view_.set_live(&drawn_);
        }
    }
    drawn_.wall.set_positions(snapshot.picture->shown);
    show_beyond();
    show_steel();
    watch_sight();
    view_.draw_soon();
}

/// Nothing is seen before the wall is cut.
void KnifeTool::watch_sight()
{
    const planner::SurgerySnapshot& snapshot = *shown()->snapshot;
    const bool wound = std::ranges::any_of(snapshot.cuts, &planner::CutEntry::in_force);
    if (snapshot.phase != planner::SurgerySnapshot::Phase::ready || !wound || snapshot.stroke_open) {
        if (!wound && !snapshot.stroke_open)
            sight_.forget();
    } else {
        if (!sight_.watches(snapshot.picture)) {
            TriMesh around = beyond_;
            around.labels.clear(); // steel has none
            append(around, steel_);
            sight_.watch(snapshot.picture, std::move(around), *shown()->look);
        }
        age_timer_.start();
    }
    panel_.show_sight(sight_.text());
}

void KnifeTool::show_beyond()
{
    const planner::SurgerySnapshot& snapshot = *shown()->snapshot;
    if (snapshot.beyond != nullptr) {
        beyond_.vertices = snapshot.beyond->shown(*snapshot.picture);
        drawn_.beyond.set_positions(beyond_.vertices);
    }
    const std::vector<LineItem>& planned = shown()->surroundings->lines;
    const bool show_plan = !planned.empty() && snapshot.hooks.hooks.empty();
    drawn_.beyond.set_line(
        show_plan ? planned.front().points : std::vector<Vec3> {}, incision_color(), kPlannedWidthPx);
    const bool cutting = mode_ == KnifeMode::freehand || mode_ == KnifeMode::line || mode_ == KnifeMode::take_out;
    drawn_.wall.set_outline(cutting && snapshot.outline != nullptr
            ? planner::shown_places(*snapshot.outline, *snapshot.picture)
            : std::vector<Vec3> {},
        kOutlineColor, kOutlineWidthPx);
}

void KnifeTool::show_steel()
{
    const planner::SurgerySnapshot& snapshot = *shown()->snapshot;
    steel_ = {};
    for (const planner::HookState& hook : snapshot.hooks.hooks)
        append(steel_, steel_of(hook, snapshot));
    for (const planner::RetractorState& retractor : snapshot.hooks.retractors)
        append(steel_, rack_of(retractor, snapshot));
    drawn_.wall.set_steel(steel_);
}

void KnifeTool::show_line()
{
    drawn_.wall.set_line(line_, incision_color(), kLineWidthPx);
    view_.draw_soon();
}

bool KnifeTool::wall_is_shown() const
{
    return snapshot() != nullptr && snapshot()->picture != nullptr && view_.scenes().size() == 1;
}

std::string KnifeTool::why_no_wall() const
{
    return snapshot() != nullptr && snapshot()->phase == planner::SurgerySnapshot::Phase::asking
        ? "Answer on the right first: restore the cuts of the last session, or discard them"
        : "the wall is not ready yet";
}

std::optional<planner::Touch> KnifeTool::feel_wall(const QPointF& at) const
{
    if (!wall_is_shown())
        return std::nullopt;
    return touch(*snapshot()->picture, view_.ray_at(at));
}

std::optional<planner::Touch> KnifeTool::feel(const QPointF& at, std::string& why_not) const
{
    const auto refuse = [&](std::string text) {
        why_not = std::move(text);
        return std::nullopt;
    };
    const bool taking_out = mode_ == KnifeMode::take_out;
    if (!wall_is_shown())
        return refuse(why_no_wall());
    const planner::Ray ray = view_.ray_at(at);
    const std::optional<planner::Touch> found = touch(*snapshot()->picture, ray);
    const auto before = [&](const TriMesh& mesh) {
        const auto hit = planner::first_hit(mesh, ray);
        return hit && (!found || *hit < found->distance);
    };
    if (before(beyond_))
        return refuse(
            planner::outside_the_outline(taking_out ? "nothing can be taken out here" : "the knife cannot cut here"));
    for (const SurfaceItem& item : shown()->surroundings->surfaces)
        if (item.target && before(*item.mesh))
            return refuse("this is the target: press on the wall");
    if (!found)
        return refuse(taking_out ? "there is no tissue here: press on the wall"
                                 : "the knife is beside the body: begin on the skin");
    return found;
}

const planner::HookState* KnifeTool::hook_under(
    const planner::Ray& ray, const std::optional<planner::Touch>& touched) const
{
    const planner::SurgerySnapshot& snapshot = *shown()->snapshot;
    const planner::HookState* nearest = nullptr;
    double least = touched ? touched->distance : std::numeric_limits<double>::infinity();
    for (const planner::HookState& hook : snapshot.hooks.hooks)
        if (const auto hit = planner::first_hit(steel_of(hook, snapshot), ray); hit && *hit < least) {
            least = *hit;
            nearest = &hook;
        }
    for (const planner::RetractorState& retractor : snapshot.hooks.retractors)
        if (const auto hit = planner::first_hit(rack_of(retractor, snapshot), ray); hit && *hit < least) {
            least = *hit;
            const Vec3 at = ray.origin + *hit * ray.direction;
            for (const fem::HookId id : retractor.blades) // an arm moves with its blade
                if (const auto* blade = hook_of(snapshot.hooks, id); blade != nullptr
                    && (nearest == nullptr || !is_blade_of(retractor, nearest->id)
                        || (shown_centre(*blade, *snapshot.picture) - at).norm()
                            < (shown_centre(*nearest, *snapshot.picture) - at).norm()))
                    nearest = blade;
        }
    if (nearest != nullptr || !touched)
        return nearest;
    for (const planner::HookState& hook : snapshot.hooks.hooks) // tissue that the hook holds
        for (const VertexId v : touched->triangle)
            if (std::find(hook.placement.nodes.begin(), hook.placement.nodes.end(), v) != hook.placement.nodes.end())
                return &hook;
    return nullptr;
}

void KnifeTool::take_out(const QPointF& at)
{
    std::string why_not;
    const auto touched = feel(at, why_not);
    say(why_not, !why_not.empty());
    if (touched)
        run(planner::surgery::TakeOut { *touched, panel_.removal_radius_mm() });
}

void KnifeTool::take_hook(const QPointF& at)
{
    if (!wall_is_shown())
        return say(why_no_wall(), true);
    const std::optional<planner::Touch> touched = feel_wall(at);
    const planner::Ray ray = view_.ray_at(at);
    say({}, false);
    if (const planner::HookState* hook = hook_under(ray, touched))
        grip_ = Grip { hook->id, shown_centre(*hook, *shown()->snapshot->picture),
            planner::moved_by_hand(shown()->snapshot->hooks, *hook), Vec3::Zero() };
    else if (touched && panel_.instrument())
        return run(planner::surgery::PlaceRetractor { *touched, *panel_.instrument() });
    else if (touched)
        return run(planner::surgery::PlaceHook { *touched });
    else
        return say("the hook is beside the body: set it on the edge of a wound", true);
    grip_->from = in_hand(at);
}

void KnifeTool::drag_hook(const QPointF& to)
{
    run(planner::surgery::PullHook { grip_->hook, grip_->asked + in_hand(to) - grip_->from });
}

/// The position of the mouse in the plane through the hook, across the line of sight.
Vec3 KnifeTool::in_hand(const QPointF& at) const
{
    const Camera camera = view_.camera();
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const planner::Ray ray = view_.ray_at(at);
    return ray.origin + (grip_->centre - ray.origin).dot(sight) / ray.direction.dot(sight) * ray.direction;
}

void KnifeTool::press(const QPointF& at)
{
    if (mode_ == KnifeMode::hooks)
        return take_hook(at);
    if (mode_ == KnifeMode::take_out)
        return take_out(at);
    if (mode_ == KnifeMode::line) {
        if (first_)
            cut_straight(at);
        else
            set_first(at);
        return;
    }
    std::string why_not;
    const auto touched = feel(at, why_not);
    if (!touched) {
        say(why_not, true);
        return;
    }
    say({}, false);
    run(planner::surgery::BeginStroke { *touched, panel_.settings(), ++stroke_ });
    drawing_ = true;
    last_ = at;
    line_ = { touched->shown };
}

bool KnifeTool::wheel(const QPointF& at, double notches)
{
    constexpr double kMmPerNotch = 2.0; // about a tooth of a rack
    constexpr qint64 kSameTurnMs = 1000;
    if (mode_ != KnifeMode::hooks || !wall_is_shown())
        return false;
    // Notches that follow each other crank the same retractor, even when its blade has moved away from the mouse, and
    // go on from the last one: the wound that is shown may be older.
    const bool goes_on = cranked_.since.isValid() && cranked_.since.elapsed() < kSameTurnMs;
    std::optional<fem::HookId> blade;
    if (goes_on)
        blade = cranked_.blade;
    else if (const planner::HookState* under = hook_under(view_.ray_at(at), feel_wall(at)))
        blade = under->id;
    if (!blade)
        return false;
    for (const planner::RetractorState& retractor : snapshot()->hooks.retractors)
        if (is_blade_of(retractor, *blade)) {
            cranked_.blade = *blade;
            cranked_.opening_mm
                = std::clamp((goes_on ? cranked_.opening_mm : retractor.opening_mm) + kMmPerNotch * notches, 0.0,
                    retractor.greatest_opening_mm);
            cranked_.since.start();
            run(planner::surgery::Crank { cranked_.blade, cranked_.opening_mm });
            return true;
        }
    return false;
}

void KnifeTool::move(const QPointF& at, bool held)
{
    if (mode_ == KnifeMode::line && first_) {
        // Draws a straight line over the skin to the mouse.
        line_.clear();
        const int pieces = 24;
        for (int i = 0; i <= pieces; ++i)
            if (const auto touched = feel_wall(*first_ + (at - *first_) * (static_cast<double>(i) / pieces)))
                line_.push_back(touched->shown);
        show_line();
    }
    if (grip_ && held)
        drag_hook(at);
    if (drawing_ && held)
        draw_between(std::exchange(last_, at), at);
}

void KnifeTool::draw_between(const QPointF& from, const QPointF& to)
{
    const int pieces = std::max(1, static_cast<int>(std::ceil(QLineF(from, to).length() / kFeelEveryPx)));
    for (int i = 1; i <= pieces; ++i)
        if (const auto touched = feel_wall(from + (to - from) * (static_cast<double>(i) / pieces))) {
            run(planner::surgery::DrawTo { *touched });
            line_.push_back(touched->shown);
        } else {
            run(planner::surgery::LeaveWall {});
        }
    show_line();
}

void KnifeTool::release(const QPointF& at)
{
    if (std::exchange(grip_, std::nullopt))
        return;
    if (!drawing_)
        return;
    if (at != last_)
        draw_between(last_, at);
    end_stroke();
}

void KnifeTool::set_first(const QPointF& at)
{
    std::string why_not;
    if (feel(at, why_not))
        first_ = at;
    say(why_not, !why_not.empty());
}

void KnifeTool::cut_straight(const QPointF& to)
{
    const QPointF from = *std::exchange(first_, std::nullopt);
    if (const auto touched = feel_wall(from)) {
        run(planner::surgery::BeginStroke { *touched, panel_.settings(), ++stroke_ });
        drawing_ = true;
        line_ = { touched->shown };
        draw_between(from, to);
    }
    end_stroke();
}

} // namespace retractor::ui
