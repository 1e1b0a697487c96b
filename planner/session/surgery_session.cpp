#include "planner/session/surgery_session.h"

#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/hook_patches.h"
#include "planner/session/planned_cuts.h"
#include "planner/session/retractor/blade_bearing.h"
#include "planner/wall/division_cut.h"
#include "planner/wall/wall_tension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <iterator>
#include <map>
#include <numbers>
#include <sstream>
#include <type_traits>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kRadians = std::numbers::pi / 180.0; ///< of a degree

    /// A shorter line is a click and not a cut.
    constexpr double kShortestCutMm = 1.0;
    /// Depth beyond the measured wall of a cut through the wall, because the wall is uneven.
    constexpr double kBeyondWallMm = 3.0;
    /// Longest gap that is bridged where the line leaves the skin and comes back.
    constexpr double kLongestGapMm = 25.0;
    /// The wound first opens within this distance along edges. When this part is at rest, the distance doubles, and at
    /// last the whole wall moves.
    constexpr double kFirstReachMm = 40.0;
    constexpr double kLastReachMm = 80.0;
    /// Unbalanced force, relative to the largest at the lips, that causes no visible motion.
    constexpr double kRestTolerance = 0.01;
    constexpr int kFewestIterations = 60;
    constexpr double kStillMm = 0.03; ///< largest motion of a vertex in a still frame
    constexpr int kStillFrames = 3; ///< number of still frames after which the wound is at rest
    /// Share of the former direction of the knife that a step keeps, because a hand does not turn the blade at every
    /// bump.
    constexpr double kSteadiness = 0.5;

    /// A hand strays from the planned line by about this distance, in edges of the corridor's elements.
    constexpr double kStrayEdges = 1.5;

    /// Vertices that the knife may change when it follows the planned line. A cut elsewhere is equally correct, but
    /// hooks follow it later.
    std::vector<VertexId> along_planned_line(const mesh::CutSession& session, const Approach& approach)
    {
        if (approach.incision.size() < 2)
            return {};
        const mesh::SweptBlade blade(blade_of(approach));
        const double stray = kStrayEdges * approach.sizing.corridor_edge_mm;
        Eigen::AlignedBox3d box = blade.box(0.0, blade.length());
        box.extend(Vec3(box.min() - Vec3::Constant(stray))).extend(Vec3(box.max() + Vec3::Constant(stray)));
        std::vector<VertexId> vertices;
        for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v) {
            if (!session.has_vertex(v) || !box.contains(session.position(v)))
                continue;
            const mesh::BladeCoordinates c = blade.coordinates(session.position(v));
            if (std::abs(c.side) <= stray && c.along >= -stray && c.along <= blade.length() + stray
                && c.depth <= blade.depth() + stray)
                vertices.push_back(v);
        }
        return vertices;
    }

    std::vector<Label> skeleton_labels(const mesh::LabelTable& table)
    {
        std::vector<Label> labels;
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_skeleton(info))
                labels.push_back(info.id);
        return labels;
    }

    std::vector<HookPlacement> placements_of(const HookSet& set)
    {
        std::vector<HookPlacement> placements;
        for (const HookState& hook : set.hooks)
            placements.push_back(hook.placement);
        return placements;
    }

    mesh::CutSession open_session(const mesh::TetMesh& wall, const Job& job)
    {
        const Stopwatch watch;
        mesh::CutSession session(wall);
        record_part(job, "cutting session", watch, session.bytes().mesh);
        return session;
    }

} // namespace

struct SurgerySession::Stroke {
    Touch begin;
    KnifeSettings settings;
    mesh::Blade blade; ///< accepted line and directions, including the first point
    mesh::CutOptions options;
    Vec3 tip = Vec3::Zero(); ///< last drawn point, cut or not
    Vec3 tip_direction = Vec3::UnitY();
    std::string off; ///< why the line is outside the region that can be cut; empty: inside. A short gap is bridged
    bool off_said = false;
    std::string omitted; ///< why a part of the line was not cut; empty: all of it was cut
};

SurgerySession::SurgerySession(SurgerySetup setup, const Job& job)
    : SurgerySession(setup, open_session(setup.wall, job), {}, job)
{
}

SurgerySession::SurgerySession(
    SurgerySetup setup, mesh::CutSession session, const std::vector<mesh::MeshDelta>& cuts, const Job& job)
    : labels_(std::move(setup.labels))
    , materials_(std::move(setup.materials))
    , outward_(setup.outward)
    , first_(std::make_shared<const mesh::TetMesh>(std::move(setup.wall)))
    , skeleton_(skeleton_labels(labels_))
    , session_(std::move(session))
    , follower_(*first_)
    , rest_(first_->vertices)
    , region_(std::move(setup.region))
    , cut_off_(std::move(setup.cut_off))
    , held_(first_->vertex_count(), 0)
    , bed_(first_->vertex_count(), 0.0)
    , hinges_(std::move(setup.hinges))
    , approach_(std::move(setup.approach))
    , find_division_(std::move(setup.find_division))
    , planned_force_(std::move(setup.planned_force))
{
    job_.ledger = job.ledger;
    for (const VertexId v : setup.held)
        held_.at(static_cast<std::size_t>(v)) = 1;
    cut_off_.insert(cut_off_.end(), setup.held.begin(), setup.held.end());
    for (const fem::BeddedVertex& bed : setup.bedded)
        bed_.at(static_cast<std::size_t>(bed.vertex)) = bed.stiffness;
    fem::check_hinges(*first_, hinges_);
    for (const fem::Hinge& hinge : hinges_)
        for (const fem::HingeEdge& edge : hinge.edges)
            hinge_nodes_.insert({ edge.a, edge.b });
    const std::vector<LipsOfCut> lips = cuts.empty() ? std::vector<LipsOfCut> {} : lips_of_cuts(session_, cuts.size());
    const std::vector<CutEntry> planned = recognise_planned_cuts(*first_, approach_, labels_, cuts, job);
    for (std::size_t i = 0; i < cuts.size(); ++i) {
        CutEntry restored = restored_entry(cuts[i], lips[i], labels_, rest_, [&] { (void)take_in(cuts[i]); });
        history_.append(i < planned.size() ? planned[i] : std::move(restored));
    }
}

SurgerySession::~SurgerySession() = default;
SurgerySession::SurgerySession(SurgerySession&&) noexcept = default;

bool SurgerySession::is_skeleton_label(Label label) const
{
    return std::find(skeleton_.begin(), skeleton_.end(), label) != skeleton_.end();
}

KnifeAnswer SurgerySession::begin_stroke(const Touch& at, const KnifeSettings& settings)
{
    if (stroke_open())
        throw InputError("a stroke is open: finish it first");
    if (!settings.through_wall && !(std::isfinite(settings.depth_mm) && settings.depth_mm > 0.0))
        throw InputError("the depth must be positive", "depth_mm");
    if (!region_.can_cut(at.rest))
        return { false, outside_the_outline("the knife cannot cut here") };
    if (at.on_lip)
        return { false, "the knife is in a wound: begin on the skin" };
    if (!settings.cuts_bone && is_skeleton_label(at.label))
        return { false, label_name(labels_, at.label) + " is exposed here: the knife does not cut it" };
    double depth = settings.depth_mm;
    if (settings.through_wall) {
        const auto thickness = thickness_near(*picture()->surface, at);
        if (!thickness)
            return { false, "the wall has no inner side here: set a depth" };
        depth = *thickness + kBeyondWallMm;
    }
    stroke_ = std::make_shared<Stroke>();
    stroke_->begin = at;
    stroke_->settings = settings;
    stroke_->tip = at.rest;
    stroke_->tip_direction = at.inward;
    stroke_->blade.line = { at.rest };
    stroke_->blade.directions = { at.inward };
    stroke_->blade.depth_mm = depth;
    if (!settings.cuts_bone)
        stroke_->options.uncut_labels = skeleton_;
    before_cut_ = hook_set();
    return { true, {} };
}

KnifeAnswer SurgerySession::draw_to(const Touch& at)
{
    if (!stroke_open())
        throw InputError("there is no stroke to draw on");
    if (at.on_lip) // across an earlier wound: the line continues where the skin does
        return { true, {} };
    Stroke& stroke = *stroke_;
    if (!region_.can_cut(at.rest)) {
        stroke.off = "the line left the region that can be cut";
        if (std::exchange(stroke.off_said, true))
            return { false, {} };
        return { false, "the line is not cut here: " + stroke.off };
    }
    if ((at.rest - stroke.tip).norm() > kLongestGapMm) {
        stroke.omitted = "the line jumps: draw on the skin";
        return { false, stroke.omitted };
    }
    stroke.off.clear();
    stroke.tip = at.rest;
    stroke.tip_direction = at.inward;
    const Vec3 from = stroke.blade.line.back();
    const Vec3 way = at.rest - from;
    const auto steps = static_cast<int>(std::floor(way.norm() / kStepMm));
    if (steps < 1)
        return { true, {} };
    std::vector<Vec3> points, directions;
    Vec3 direction = stroke.blade.directions.back();
    for (int i = 1; i <= steps; ++i) {
        points.push_back(from + i * kStepMm / way.norm() * way);
        direction = (kSteadiness * direction + (1.0 - kSteadiness) * at.inward).normalized();
        directions.push_back(direction);
    }
    return cut_to(std::move(points), std::move(directions));
}

void SurgerySession::leave_wall()
{
    if (!stroke_open())
        throw InputError("there is no stroke to draw on");
    stroke_->off = "the line left the wall";
}

KnifeAnswer SurgerySession::cut_to(std::vector<Vec3> points, std::vector<Vec3> directions)
{
    RETRACTOR_ASSERT(stroke_ != nullptr && points.size() == directions.size());
    Stroke& stroke = *stroke_;
    mesh::Blade longer = stroke.blade;
    longer.line.insert(longer.line.end(), points.begin(), points.end());
    longer.directions.insert(longer.directions.end(), directions.begin(), directions.end());
    const auto refused = [&](const Error& error) -> KnifeAnswer {
        stroke.omitted = error.what();
        return { false, stroke.omitted };
    };
    const Stopwatch watch;
    mesh::CutResult result;
    try {
        result = session_.extend_stroke(longer, stroke.options);
    } catch (const InputError& error) {
        return refused(error);
    } catch (const SolverError& error) { // a step may not end here; another point will do
        return refused(error);
    }
    if (result.status != mesh::CutStatus::done)
        return { false, result.message };
    stroke.blade = std::move(longer);
    step_ms_ = 1e3 * watch.seconds();
    follow(result.delta);
    return { true, {} };
}

KnifeAnswer SurgerySession::finish_stroke()
{
    if (!stroke_open())
        throw InputError("there is no stroke to finish");
    Stroke& stroke = *stroke_;
    if ((stroke.tip - stroke.blade.line.back()).norm() >= kShortestCutMm)
        (void)cut_to({ stroke.tip }, { (stroke.blade.directions.back() + stroke.tip_direction).normalized() });
    if (!session_.stroke_open()) {
        const std::string& why = stroke.omitted.empty() ? stroke.off : stroke.omitted;
        const std::string reason
            = why.empty() ? "the knife did not move: draw a line on the skin" : "nothing was cut: " + why;
        stroke_.reset();
        return { false, reason };
    }
    const Stopwatch watch;
    mesh::CutResult result;
    try {
        result = session_.finish_stroke();
    } catch (const SolverError& error) { // finishing would be refused again, and an open stroke blocks everything else
        const std::string reason = std::string("the stroke cannot be finished and was undone: ") + error.what();
        abandon_stroke();
        return { false, reason };
    }
    const std::shared_ptr<Stroke> ended = std::exchange(stroke_, nullptr); // after the session's stroke has ended
    step_ms_ = 1e3 * watch.seconds();
    follow(result.delta);
    if (result.status != mesh::CutStatus::done)
        return { false, result.message };
    CutEntry entry = entry_of(ended->blade, result.report);
    entry.omitted = ended->omitted;
    if (!ended->off.empty())
        entry.omitted += (entry.omitted.empty() ? "" : "; ") + ended->off;
    add_cut(entry);
    if (entry.omitted.empty())
        return { true, {} };
    return { true,
        "cut over " + std::to_string(std::lround(entry.length_mm))
            + " mm; a part of the line was not cut: " + entry.omitted };
}

KnifeAnswer SurgerySession::cut_as_planned()
{
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    if (session_.cut_count() > 0)
        return { false, "the wall is cut already: undo the cuts, then cut as planned" };
    if (approach_.incision.size() < 2)
        return { false, "the approach has no incision" };
    const mesh::Blade blade = blade_of(approach_);
    before_cut_ = hook_set();
    const Stopwatch watch;
    mesh::CutResult result;
    try {
        result = session_.cut(blade, cut_options_of(approach_, labels_), job_);
    } catch (const InputError& error) {
        return { false, std::string("the planned incision cannot be cut: ") + error.what() };
    } catch (const SolverError& error) {
        return { false, std::string("the planned incision cannot be cut: ") + error.what() };
    }
    if (result.status != mesh::CutStatus::done)
        return { false, result.message };
    step_ms_ = 1e3 * watch.seconds();
    follow(result.delta);
    CutEntry entry = entry_of(blade, result.report);
    entry.as_planned = true;
    add_cut(std::move(entry));
    KnifeAnswer answer { true, {} };
    if (approach_.division.extent != DivisionExtent::skin)
        answer.reason = make_strokes(approach_, {}).reason;
    if (!approach_.ablations.empty())
        answer.reason += (answer.reason.empty() ? "" : "; ")
            + std::string("what the plan removes is still there: take it out by hand");
    return answer;
}

KnifeAnswer SurgerySession::divide_beyond_cut()
{
    if (approach_.division.extent == DivisionExtent::skin || !find_division_)
        return { false, "the approach divides nothing beyond the skin" };
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    const std::vector<CutEntry>& cuts = history_.entries();
    const auto in_force = cuts.begin() + static_cast<std::ptrdiff_t>(session_.cut_count());
    const auto cut = std::find_if(std::reverse_iterator(in_force), cuts.rend(),
        [](const CutEntry& entry) { return entry.taken_out.empty() && !entry.divides; });
    if (cut == cuts.rend())
        return { false, "there is no wound beyond which to divide: cut first" };
    std::set<StrokeWay> made;
    for (auto later = cut.base(); later != in_force; ++later)
        if (later->divides)
            made.insert(*later->divides);
    if (cut->blade.line.size() < 2)
        return { false, "the line of a restored cut is not known: undo it, and cut again" };
    const std::size_t middle = cut->blade.line.size() / 2;
    const Touch there { .rest = cut->blade.line[middle], .shown = {}, .inward = cut->blade.directions[middle] };
    constexpr double kNearMm = 5.0;
    if (const auto wall = thickness_near(*picture()->surface, there, kNearMm); wall && cut->depth_mm < *wall)
        return { false, "the last cut does not go through the wall: cut through the wall first" };
    Approach by_hand = approach_;
    by_hand.incision = cut->blade.line;
    by_hand.directions = cut->blade.directions;
    by_hand.depth_mm = cut->blade.depth_mm;
    find_division_(by_hand);
    return make_strokes(by_hand, made);
}

/// Makes the strokes of an approach whose incision is cut, but for the ways that are made already. Those that cannot be
/// made are named in the message.
KnifeAnswer SurgerySession::make_strokes(const Approach& divided, const std::set<StrokeWay>& made)
{
    if (divided.division.strokes.empty())
        return { false, "nothing is divided beyond the skin: " + divided.division.words };
    KnifeAnswer answer;
    bool all = true;
    for (const DivisionStroke& stroke : divided.division.strokes) {
        if (made.contains(stroke.way))
            continue;
        Approach one = divided;
        one.division.strokes = { stroke };
        before_cut_ = hook_set();
        const Stopwatch watch;
        const std::size_t cuts = session_.cut_count();
        DivisionCut cut;
        try {
            cut = divide_beyond_skin(session_, one, labels_, job_);
        } catch (const SolverError& error) {
            all = false;
            while (session_.cut_count() > cuts) // a stroke that severed nothing
                (void)session_.undo();
            hook_steps_.resize(hook_steps_made_); // it took the place of what was undone
            answer.reason += (answer.reason.empty() ? "" : "; ") + std::string(error.what());
            continue;
        }
        if (cut.status != mesh::CutStatus::done)
            return { answer.done, "the division was cancelled" };
        step_ms_ = 1e3 * watch.seconds();
        follow(cut.deltas.front());
        add_cut(entry_of(stroke, *cut.divided));
        answer.done = true;
    }
    if (!answer.done && all)
        return { false, "what the approach divides beyond the skin is divided already" };
    if (all)
        answer.reason = divided.division.words;
    return answer;
}

void SurgerySession::abandon_stroke()
{
    if (!stroke_open())
        return;
    if (!session_.stroke_open()) {
        stroke_.reset();
        return;
    }
    const mesh::MeshDelta delta = session_.abandon_stroke(); // when the journal refuses this, the stroke stays open
    stroke_.reset();
    follow(delta);
    give_hooks_back(before_cut_);
}

std::optional<mesh::Piece> SurgerySession::free_piece_at(const Touch& at, std::string& why_not) const
{
    const auto refuse = [&](const char* text) {
        why_not = text;
        return std::nullopt;
    };
    const std::vector<mesh::SurfaceFace>& faces = follower_.faces();
    const auto touched = std::find_if(
        faces.begin(), faces.end(), [&](const mesh::SurfaceFace& face) { return face.vertices == at.triangle; });
    if (touched == faces.end())
        return refuse("the tissue has changed since the click: click again");
    std::vector<mesh::Piece> pieces = mesh::find_pieces(session_);
    const auto piece = std::find_if(pieces.begin(), pieces.end(), [&](const mesh::Piece& candidate) {
        return std::binary_search(candidate.tets.begin(), candidate.tets.end(), touched->face.tet);
    });
    if (piece == pieces.begin())
        return refuse("this tissue is connected to the wall: cut it free first, or take out a ball of tissue");
    std::vector<TetId> free = piece->tets;
    if (const std::string why = leave_out_what_stays(free); !why.empty()) {
        why_not = "this piece cannot be taken out: " + why;
        return std::nullopt;
    }
    return std::move(*piece);
}

/// Leaves out elements that are held by the unmeshed wall or that carry its drawn surface.
/// @return the reason, when elements were left out
std::string SurgerySession::leave_out_what_stays(std::vector<TetId>& marked) const
{
    bool beyond = false, held = false;
    std::erase_if(marked, [&](TetId t) {
        const auto nodes = session_.tet(t).nodes;
        Vec3 centroid = Vec3::Zero();
        bool fast = false;
        for (const VertexId v : nodes) {
            centroid += 0.25 * rest_.row(v).transpose();
            fast = fast || held_[static_cast<std::size_t>(v)] != 0;
        }
        const bool outside = !region_.can_cut(centroid);
        beyond = beyond || outside;
        held = held || fast;
        return outside || fast;
    });
    std::string why = beyond ? "tissue lies outside the region that can be cut" : "";
    if (held)
        why += (why.empty() ? "" : "; ") + std::string("tissue is held by a support of the wall");
    return why;
}

KnifeAnswer SurgerySession::take_out(const Touch& at, double radius_mm)
{
    if (!(std::isfinite(radius_mm) && radius_mm >= 0.0))
        throw InputError("the radius must be finite and not negative", "radius_mm");
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    if (!region_.can_cut(at.rest))
        return { false, outside_the_outline("nothing can be taken out here") };
    std::vector<TetId> marked;
    CutEntry entry;
    Label kind = at.label;
    if (radius_mm > 0.0) {
        marked = mesh::mark_ball(session_, at.rest, radius_mm, std::array { at.label });
        if (marked.empty())
            return { false, "the ball is smaller than the elements here: set a larger radius" };
        entry.omitted = leave_out_what_stays(marked);
        if (marked.empty())
            return { false, "nothing can be taken out here: " + entry.omitted };
    } else {
        std::string why_not;
        const std::optional<mesh::Piece> piece = free_piece_at(at, why_not);
        if (!piece)
            return { false, why_not };
        marked = piece->tets;
        kind = piece->labels.front().first;
        entry.several_tissues = piece->labels.size() > 1;
    }
    if (marked.size() == session_.tet_count())
        return { false, "this would remove the whole wall" };
    before_cut_ = hook_set();
    const Stopwatch watch;
    const mesh::CutResult result = session_.ablate(marked, job_);
    if (result.status != mesh::CutStatus::done)
        return { false, result.message };
    step_ms_ = 1e3 * watch.seconds();
    follow(result.delta);
    entry.taken_out = label_name(labels_, kind);
    entry.report = result.report;
    add_cut(entry);
    return { true, entry.omitted.empty() ? std::string {} : "a part of the ball was not taken out: " + entry.omitted };
}

/// Adds a cut that was made, which takes the place of all that is undone.
void SurgerySession::add_cut(CutEntry entry)
{
    history_.add(std::move(entry));
    hook_steps_.resize(hook_steps_made_);
    hooks_before_cut_.resize(session_.cut_count());
    hooks_before_cut_.back() = std::move(before_cut_);
}

/// Sets hooks again that a cut took off, when the cut is undone.
void SurgerySession::give_hooks_back(const HookSet& before)
{
    const HookSet now = hook_set();
    const bool lost = std::ranges::any_of(before.hooks, [&](const HookState& hook) {
        return std::ranges::find(now.hooks, hook.name, &HookState::name) == now.hooks.end();
    });
    if (lost)
        return_hooks_to(before);
}

void SurgerySession::undo()
{
    follow(session_.undo());
    history_.set_in_force(session_.cut_count(), false);
    while (hook_steps_made_ > 0 && hook_steps_[hook_steps_made_ - 1].cuts > session_.cut_count())
        --hook_steps_made_; // they came after this cut
}

void SurgerySession::redo()
{
    const mesh::MeshDelta delta = session_.redo();
    const std::size_t count = session_.cut_count();
    if (history_.entries().size() < count) // the cut was undone before the journal was opened again
        history_.append(
            restored_entry(delta, lips_of_cuts(session_, count).back(), labels_, rest_, [&] { follow(delta); }));
    else
        follow(delta);
    history_.set_in_force(count - 1, true);
    while (hook_steps_made_ < hook_steps_.size() && hook_steps_[hook_steps_made_].cuts < count)
        ++hook_steps_made_; // they came before this cut
}

/// Null: the last step is a cut, or there is none.
const SurgerySession::HookStep* SurgerySession::hook_step_to_undo() const
{
    const bool is_last = hook_steps_made_ > 0 && hook_steps_[hook_steps_made_ - 1].cuts == session_.cut_count();
    return is_last && !stroke_open() ? &hook_steps_[hook_steps_made_ - 1] : nullptr;
}

const SurgerySession::HookStep* SurgerySession::hook_step_to_redo() const
{
    const bool is_next
        = hook_steps_made_ < hook_steps_.size() && hook_steps_[hook_steps_made_].cuts == session_.cut_count();
    return is_next && !stroke_open() ? &hook_steps_[hook_steps_made_] : nullptr;
}

std::string SurgerySession::step_to_undo() const
{
    const HookStep* const step = hook_step_to_undo();
    return step != nullptr ? step->what : can_undo() ? "cut" : "";
}

std::string SurgerySession::step_to_redo() const
{
    const HookStep* const step = hook_step_to_redo();
    return step != nullptr ? step->what : can_redo() ? "cut" : "";
}

void SurgerySession::undo_step()
{
    const HookStep* const step = hook_step_to_undo();
    if (step == nullptr) {
        undo();
        if (const std::size_t cut = session_.cut_count(); cut < hooks_before_cut_.size())
            give_hooks_back(hooks_before_cut_[cut]);
        return;
    }
    return_hooks_to(step->before);
    --hook_steps_made_;
}

void SurgerySession::redo_step()
{
    const HookStep* const step = hook_step_to_redo();
    if (step == nullptr)
        return redo();
    return_hooks_to(step->after);
    ++hook_steps_made_;
}

/// Where the hooks cannot be set again, the remark says why; this must not block the steps before.
void SurgerySession::return_hooks_to(const HookSet& then)
{
    if (then.hooks.empty())
        return take_hooks_off();
    if (hooks_ == nullptr) {
        try {
            make_hooks(placements_of(then));
        } catch (const Error& error) {
            remark_ = std::string("the wall cannot be opened: ") + error.what();
            return;
        }
    }
    with_hooks([&] {
        hooks_->return_to(then);
        hooks_->frame();
    });
}

namespace {

    /// Whether a hook is the same, and is driven to the same place.
    bool are_set_alike(const HookState& a, const HookState& b)
    {
        return a.name == b.name && a.drive.displacement == b.drive.displacement && a.drive.force_N == b.drive.force_N;
    }

} // namespace

/// Makes a change of the hooks that can be undone. A change that changes nothing leaves no step.
template <class Change>
auto SurgerySession::hook_step(const std::string& what, const std::string& moved, const Change& change)
{
    HookSet before = hook_set();
    const auto note = [&] {
        HookSet after = hook_set();
        if (before.hooks.empty() && after.hooks.empty())
            return;
        if (moved.empty() && std::ranges::equal(before.hooks, after.hooks, are_set_alike))
            return;
        hook_steps_.resize(hook_steps_made_);
        const HookStep* const last = hook_step_to_undo();
        if (last != nullptr && !moved.empty() && last->moved == moved)
            hook_steps_.back().after = std::move(after);
        else
            hook_steps_.push_back({ .cuts = session_.cut_count(),
                .what = what,
                .moved = moved,
                .before = std::move(before),
                .after = std::move(after) });
        hook_steps_made_ = hook_steps_.size();
    };
    if constexpr (std::is_void_v<decltype(change())>) {
        change();
        note();
    } else {
        const auto answer = change();
        note();
        return answer;
    }
}

std::shared_ptr<const WallSurface> SurgerySession::make_surface() const
{
    auto surface = std::make_shared<WallSurface>();
    surface->rest = rest_;
    const std::vector<mesh::SurfaceFace>& faces = follower_.faces();
    surface->triangles.reserve(faces.size());
    surface->labels.reserve(faces.size());
    std::vector<std::uint8_t> lips_of(session_.tet_slots(), 0); // one bit per corner
    for (const mesh::LipFace& lip : session_.lips())
        lips_of[static_cast<std::size_t>(lip.face.tet)] |= static_cast<std::uint8_t>(1U << lip.face.corner);
    for (const mesh::SurfaceFace& face : faces) {
        surface->triangles.push_back(face.vertices);
        surface->labels.push_back(face.label);
        surface->is_lip.push_back(lips_of[static_cast<std::size_t>(face.face.tet)] >> face.face.corner & 1U);
    }
    return surface;
}

SurgerySession::Returned SurgerySession::take_in(const mesh::MeshDelta& delta)
{
    Returned returned;
    surface_.reset();
    picture_.reset();
    for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born) {
        const auto id = static_cast<std::size_t>(born.id);
        held_.resize(std::max(held_.size(), id + 1), 0);
        bed_.resize(held_.size(), 0.0);
        if (rest_.rows() <= born.id) // spare rows get values too, because whole fields are compared
            rest_.conservativeResizeLike(
                Points::Zero(std::max<Eigen::Index>(born.id + 1, rest_.rows() + rest_.rows() / 8), 3));
        rest_.row(born.id) = born.position.transpose();
        if (born.origin == mesh::MeshDelta::Origin::restored) {
            const Ablated kept = ablated_.give_back(born.id).value_or(Ablated {});
            held_[id] = kept.held;
            bed_[id] = kept.bed;
            if (kept.held != 0)
                returned.held.push_back(born.id);
            if (kept.hooks_made != hooks_made_ && (kept.held != 0 || kept.bed > 0.0 || hinge_nodes_.contains(born.id)))
                returned.unknown_to_hooks = true;
            parted_.insert(parted_.end(), kept.parted.begin(), kept.parted.end());
            continue;
        }
        held_[id] = held_[static_cast<std::size_t>(born.a)] != 0 && held_[static_cast<std::size_t>(born.b)] != 0;
        bed_[id] = 0.0; // the same choice as in the hooks' solver
        if (born.origin == mesh::MeshDelta::Origin::copy)
            parted_.emplace_back(born.a, born.id);
    }
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved)
        rest_.row(moved.id) = moved.to.transpose();
    follower_.follow(delta);
    for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone) {
        const auto id = static_cast<std::size_t>(gone.id);
        Ablated lost { .held = held_[id], .bed = bed_[id], .hooks_made = hooks_made_, .parted = {} };
        bed_[id] = 0.0;
        std::erase_if(parted_, [&](const auto& pair) {
            const bool ends = pair.first == gone.id || pair.second == gone.id;
            if (ends)
                lost.parted.push_back(pair);
            return ends;
        });
        if (gone.origin == mesh::MeshDelta::Origin::restored)
            ablated_.keep(gone.id, std::move(lost));
    }
    return returned;
}

void SurgerySession::follow(const mesh::MeshDelta& delta)
{
    const Returned returned = take_in(delta);
    if (hooks_ != nullptr) {
        with_hooks([&] { hooks_->follow(delta, session_); });
        if (hooks_ != nullptr && returned.unknown_to_hooks)
            with_hooks([&] {
                renew_hooks();
                hooks_->frame();
            });
        return;
    }
    if (springs_ == nullptr)
        return;
    try {
        springs_->apply(delta);
        springs_->fix(returned.held); // they may have been absent when the springs were made
        springs_->set_wound(session_.lips());
        start_moving();
    } catch (const std::exception& error) { // the cut is made, even when the springs fail
        renew_springs(error.what());
    }
}

void SurgerySession::renew_springs(const std::string& why)
{
    try {
        const Points was = springs_->displacement();
        springs_ = make_springs(tension_);
        lie_as(was);
        start_moving();
        remark_ = "the springs could not follow the knife and were replaced: " + why;
    } catch (const std::exception& error) {
        drop_tension(error.what());
    }
}

void SurgerySession::drop_tension(const std::string& why)
{
    springs_.reset();
    picture_.reset();
    tension_ = 0.0;
    moving_ = false;
    remark_ = "the tension was switched off: " + why;
}

/// Continues from this displacement. The two fields may have different row counts, because ids of undone cuts may have
/// a row in only one of them.
void SurgerySession::lie_as(const Points& displacement)
{
    RETRACTOR_ASSERT(springs_ != nullptr);
    Points start = springs_->displacement();
    const Eigen::Index common = std::min(start.rows(), displacement.rows());
    start.topRows(common) = displacement.topRows(common);
    springs_->set_displacement(start);
}

void SurgerySession::start_moving()
{
    RETRACTOR_ASSERT(springs_ != nullptr);
    moving_ = session_.cut_count() > 0 || session_.stroke_open();
    reach_mm_ = kFirstReachMm;
    still_frames_ = 0;
    if (!moving_) // the wall is whole again and returns to rest
        springs_->set_displacement(Points::Zero(springs_->displacement().rows(), 3));
}

void SurgerySession::set_tension(double strain)
{
    if (!(strain >= 0.0 && strain <= fem::kLargestPreStrain))
        throw InputError("the tension must lie between 0 and " + std::to_string(fem::kLargestPreStrain), "tension");
    if (strain == tension_)
        return;
    force_factors_ = {}; // of a wall under another tension
    if (hooks_ != nullptr) { // the same hooks on a wall under another tension
        const double former = std::exchange(tension_, strain);
        try {
            renew_hooks();
        } catch (const std::exception& error) {
            tension_ = former;
            drop_hooks(error.what());
            return;
        }
        show_hooks();
        return;
    }
    std::unique_ptr<fem::SpringNetwork> springs = strain > 0.0 ? make_springs(strain) : nullptr;
    std::swap(springs, springs_);
    tension_ = strain;
    picture_.reset();
    moving_ = false;
    if (springs_ == nullptr)
        return;
    if (springs != nullptr)
        lie_as(springs->displacement());
    start_moving();
}

/// The present vertices that do not move.
std::vector<VertexId> SurgerySession::held_vertices() const
{
    std::vector<VertexId> held;
    for (VertexId v = 0; v < static_cast<VertexId>(held_.size()); ++v)
        if (held_[static_cast<std::size_t>(v)] != 0 && session_.has_vertex(v))
            held.push_back(v);
    return held;
}

std::unique_ptr<fem::SpringNetwork> SurgerySession::make_springs(double strain) const
{
    const Stopwatch watch;
    auto springs = std::make_unique<fem::SpringNetwork>(session_, materials_, tension_stresses(strain));
    springs->fix(held_vertices());
    springs->set_wound(session_.lips());
    record_part(job_, "springs", watch, springs->bytes());
    return springs;
}

std::vector<Mat3> SurgerySession::tension_stresses(double strain) const
{
    std::vector<fem::Material> materials = materials_;
    const double of_case = case_tension();
    for (std::size_t label = 0; label < materials.size(); ++label) {
        fem::PreStrain& tension = materials[label].pre_strain;
        if (of_case > 0.0) {
            tension.strain *= strain / of_case;
            tension.across *= strain / of_case;
        } else if (!is_skeleton_label(static_cast<Label>(label))) {
            tension = { .kind = fem::PreStrainKind::equibiaxial, .strain = strain };
        }
    }
    return wall_tension(*first_, materials, labels_, cut_off_, outward_).stress_of_element;
}

double SurgerySession::case_tension() const
{
    double largest = 0.0;
    for (const fem::Material& material : materials_)
        if (material.pre_strain.kind != fem::PreStrainKind::none)
            largest = std::max({ largest, material.pre_strain.strain, material.pre_strain.across });
    return largest;
}

/// The hinges with the edges that no cut has parted, by ids of the session.
std::vector<fem::Hinge> SurgerySession::present_hinges() const
{
    std::vector<fem::Hinge> hinges = hinges_;
    const auto in_place = [&](VertexId v) { // an id that is used again belongs to another vertex
        return session_.has_vertex(v) && session_.position(v) == point_at(first_->vertices, v);
    };
    const auto joined = [&](VertexId a, VertexId b) {
        return std::ranges::any_of(session_.tets_at(a), [&](TetId t) {
            const auto nodes = session_.tet(t).nodes;
            return std::ranges::find(nodes, b) != nodes.end();
        });
    };
    for (fem::Hinge& hinge : hinges)
        std::erase_if(hinge.edges, [&](const fem::HingeEdge& edge) {
            return !in_place(edge.a) || !in_place(edge.b) || !joined(edge.a, edge.b);
        });
    std::erase_if(hinges, [](const fem::Hinge& hinge) { return hinge.edges.empty(); });
    return hinges;
}

/// Replaces the solver by a solver without hooks. Its corridor has the vertices that the hooks will hold and the
/// vertices where the knife will continue.
void SurgerySession::make_hooks(std::span<const HookPlacement> placements)
{
    const Stopwatch watch;
    fem::Supports supports { .fixed = held_vertices(), .bedded = {} };
    for (VertexId v = 0; v < static_cast<VertexId>(bed_.size()); ++v)
        if (bed_[static_cast<std::size_t>(v)] > 0.0)
            supports.bedded.push_back({ v, bed_[static_cast<std::size_t>(v)] });
    supports.hinges = present_hinges();
    std::vector<VertexId> corridor = along_planned_line(session_, approach_);
    for (const HookPlacement& placement : placements)
        corridor.insert(corridor.end(), placement.nodes.begin(), placement.nodes.end());
    auto hooks = std::make_unique<WoundHooks>(
        session_, materials_, supports, corridor, tension_ > 0.0 ? tension_stresses(tension_) : std::vector<Mat3> {});
    hooks->set_yield(yield_N_);
    hooks->set_nonlinear(nonlinear_);
    record_part(job_, "online opening", watch, hooks->bytes());
    hooks_ = std::move(hooks);
    ++hooks_made_;
    springs_.reset();
}

/// Attaches the same hooks, with the vertices that they hold now, to a solver of the present wall and supports.
void SurgerySession::renew_hooks()
{
    RETRACTOR_ASSERT(hooks_ != nullptr);
    const HookSet set = hooks_->hook_set();
    make_hooks(placements_of(set));
    hooks_->return_to(set);
}

/// Runs a call of the solver that may fail; the cut stays when it fails.
template <class Call> void SurgerySession::with_hooks(const Call& call)
{
    RETRACTOR_ASSERT(hooks_ != nullptr);
    picture_.reset();
    try {
        call();
    } catch (const std::exception& error) {
        drop_hooks(error.what());
        return;
    }
    if (std::string said = hooks_->take_remark(); !said.empty())
        remark_ = std::move(said);
    if (hooks_->empty())
        hooks_taken_off();
    else
        moving_ = true; // the hooks must be settled
}

void SurgerySession::drop_hooks(const std::string& why)
{
    hooks_taken_off();
    remark_ = "all hooks were removed: " + why;
}

/// Returns the wound to the state without hooks: springs, when there is tension.
void SurgerySession::hooks_taken_off()
{
    hooks_.reset();
    picture_.reset();
    moving_ = false;
    if (tension_ == 0.0)
        return;
    try {
        springs_ = make_springs(tension_);
        start_moving();
    } catch (const std::exception& error) {
        drop_tension(error.what());
    }
}

/// Runs a change of the hooks, and opens the wound again; does nothing without hooks.
/// @throws as the change, and nothing is solved then
template <class Call> void SurgerySession::change_hooks(const Call& change)
{
    if (hooks_ == nullptr)
        return;
    change();
    show_hooks();
}

/// Opens the wound for the present hooks, as long as there are any.
void SurgerySession::show_hooks()
{
    with_hooks([&] {
        if (!hooks_->empty())
            hooks_->frame();
    });
    match_forces();
}

/// Whether the planned incision is cut, whatever was cut after it.
bool SurgerySession::has_planned_cut() const
{
    return std::ranges::any_of(history_.entries(), [](const CutEntry& cut) { return cut.in_force && cut.as_planned; });
}

/// Whether the wound is that of the plan: the planned incision with all that it divides, and nothing else.
bool SurgerySession::is_cut_as_planned() const
{
    std::size_t strokes = 0;
    bool all_planned = approach_.ablations.empty() && has_planned_cut();
    for (const CutEntry& cut : history_.entries())
        if (cut.in_force) {
            strokes += cut.divides ? 1 : 0;
            all_planned = all_planned && (cut.divides || cut.as_planned) && cut.omitted.empty();
        }
    return all_planned && strokes == approach_.division.strokes.size();
}

bool SurgerySession::set_planned_force(const std::optional<PlannedForce>& force)
{
    if (planned_force_ == force)
        return false;
    const bool same_opening = force && planned_force_ && force->retractor == planned_force_->retractor
        && force->opening_mm == planned_force_->opening_mm;
    for (std::optional<double>& factor : force_factors_)
        factor
            = same_opening && factor ? std::optional(*factor * force->force_N / planned_force_->force_N) : std::nullopt;
    planned_force_ = force;
    match_forces();
    return true;
}

void SurgerySession::match_forces()
{
    if (!planned_force_ || hooks_ == nullptr || stroke_open() || std::isfinite(yield_N_) || !is_cut_as_planned())
        return;
    const HookReport report = hooks_->report();
    const bool linear = report.shown == ShownAnswer::linear;
    if (!linear && (report.shown != ShownAnswer::nonlinear || !hooks_->settled()))
        return;
    if (const auto factor = force_match(report, *planned_force_))
        force_factors_[linear ? 0 : 1] = factor;
}

HookReport SurgerySession::hooks() const
{
    if (hooks_ == nullptr)
        return {};
    HookReport report = hooks_->report();
    const auto& factor = force_factors_[report.shown == ShownAnswer::linear ? 0 : 1];
    if (factor && !std::isfinite(yield_N_) && has_planned_cut() && is_planned_retractor(report, *planned_force_))
        multiply_forces(report, *factor);
    return report;
}

bool SurgerySession::has_hook(fem::HookId hook) const { return hooks_ != nullptr && hooks_->has(hook); }

KnifeAnswer SurgerySession::attach(std::vector<HookPlacement> placements, const std::vector<std::string>& names,
    const std::vector<fem::HookDrive>& drives, bool planned, std::string omitted)
{
    RETRACTOR_ASSERT(names.size() == placements.size() && drives.size() == placements.size());
    try {
        if (hooks_ == nullptr)
            make_hooks(placements);
    } catch (const Error& error) {
        return { false, std::string("the wall cannot be opened: ") + error.what() };
    }
    std::size_t attached = 0;
    for (std::size_t i = 0; i < placements.size(); ++i)
        try {
            hooks_->attach(
                std::move(placements[i]), names[i], drives[i], planned ? std::optional(drives[i]) : std::nullopt);
            ++attached;
        } catch (const InputError& error) {
            omitted += (omitted.empty() ? "" : "; ") + error.where() + ": " + error.what();
        }
    show_hooks();
    return { attached > 0, std::move(omitted) };
}

namespace {

    constexpr const char* kHeldAlready
        = "a hook or blade already holds the wound here: drag it, or press farther away from it";

} // namespace

KnifeAnswer SurgerySession::place_hook(const Touch& at)
{
    return hook_step("setting the hook", {}, [&] { return attach_hook(at); });
}

KnifeAnswer SurgerySession::attach_hook(const Touch& at)
{
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    std::string why_not;
    HookPlacement placement
        = find_hook_placement(*picture()->surface, lip_triangles(session_), held_, outward_, at, why_not);
    if (placement.nodes.empty())
        return { false, why_not };
    if (is_held(placement))
        return { false, kHeldAlready };
    const std::vector<HookState> there = hooks().hooks;
    std::string name;
    do // a planned hook may have such a name too
        name = "hook " + std::to_string(++hooks_placed_);
    while (std::ranges::find(there, name, &HookState::name) != there.end());
    const Vec3 lies = present_place(placement);
    KnifeAnswer answer = attach({ std::move(placement) }, { name }, { { .displacement = lies } }, false, {});
    if (!answer.done)
        --hooks_placed_;
    return answer;
}

/// Whether a hook already holds tissue under a patch.
bool SurgerySession::is_held(const HookPlacement& placement) const
{
    const std::vector<VertexId> held = hooks_ != nullptr ? hooks_->held_vertices() : std::vector<VertexId> {};
    return std::any_of(placement.nodes.begin(), placement.nodes.end(),
        [&](VertexId v) { return std::find(held.begin(), held.end(), v) != held.end(); });
}

/// Mean displacement of the lip under a patch: under tension, or with other hooks, the lip has moved.
Vec3 SurgerySession::present_place(const HookPlacement& placement)
{
    Vec3 lies = Vec3::Zero();
    for (const VertexId v : placement.nodes)
        lies += (picture()->shown.row(v) - picture()->surface->rest.row(v)).transpose()
            / static_cast<double>(placement.nodes.size());
    return lies;
}

KnifeAnswer SurgerySession::place_retractor(const Touch& at, const RetractorKind& kind)
{
    return hook_step("setting the retractor", {}, [&] { return attach_retractor(at, kind); });
}

namespace {

    /// The blades of a retractor that is set by hand.
    struct PlacedBlades {
        std::array<HookPlacement, 2> blades; ///< without nodes where there is no lip
        bool on_bone = false; ///< one of them bears on bone
        bool held = false; ///< something holds one of the lips there already
    };

} // namespace

KnifeAnswer SurgerySession::attach_retractor(const Touch& at, const RetractorKind& kind)
{
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    std::string why_not;
    const auto placed = [&](double depth_mm, std::string& reason) {
        PlacedBlades found { .blades = find_blade_placements(*picture()->surface, lip_triangles(session_), held_,
                                 outward_, at, kind.blade_width_mm, depth_mm, reason) };
        for (HookPlacement& blade : found.blades)
            if (!blade.nodes.empty()) {
                found.held = found.held || is_held(blade);
                found.on_bone = bear_on_bone(blade, session_, skeleton_) || found.on_bone;
            }
        return found;
    };
    PlacedBlades set = placed(kind.blade_depth_mm, why_not);
    if (!set.on_bone && kind.deepest_blade_mm > kind.blade_depth_mm) { // the wall may be thicker than the blades
        std::string ignored;
        if (PlacedBlades deeper = placed(kind.deepest_blade_mm, ignored); deeper.on_bone)
            set = std::move(deeper);
    }
    std::array<HookPlacement, 2>& blades = set.blades;
    if (blades[0].nodes.empty())
        return { false, why_not };
    if (set.held)
        return { false, kHeldAlready };
    const std::string number = retractors_placed_ == 0 ? std::string {} : " " + std::to_string(retractors_placed_ + 1);
    std::vector<std::string> names;
    std::vector<fem::HookDrive> drives;
    for (HookPlacement& blade : blades) {
        names.push_back(readable(blade_name(blade.pull)) + number);
        drives.push_back({ .displacement = present_place(blade) });
    }
    KnifeAnswer answer = attach({ blades.begin(), blades.end() }, names, drives, false, {});
    std::vector<fem::HookId> attached; // opening the wound may have taken off what found no hold
    for (const HookState& hook : hooks().hooks)
        if (std::ranges::find(names, hook.name) != names.end())
            attached.push_back(hook.id);
    if (attached.size() == 2) {
        change_hooks([&] {
            hooks_->join({ attached[0], attached[1] }, kind.kind, kind.greatest_opening_mm, kind.play_deg * kRadians);
        });
        ++retractors_placed_;
        return answer;
    }
    for (const fem::HookId one : attached)
        if (has_hook(one))
            change_hooks([&] { hooks_->take_off(one); });
    return { false, "both blades must find a hold: " + (answer.reason.empty() ? take_remark() : answer.reason) };
}

void SurgerySession::crank(fem::HookId blade, double opening_mm)
{
    if (has_hook(blade))
        hook_step("cranking the retractor", moved_name(blade),
            [&] { change_hooks([&] { hooks_->crank(blade, opening_mm); }); });
}

/// Gives the blades of a planned retractor that is opened by a distance their rack.
void SurgerySession::join_planned_blades()
{
    if (hooks_ == nullptr || !approach_.retractor || approach_.retractor->force_N)
        return;
    std::vector<fem::HookId> blades;
    for (const HookState& hook : hooks_->report().hooks)
        if (hook.planned && std::ranges::none_of(hooks_->report().retractors, [&](const RetractorState& retractor) {
                return std::ranges::find(retractor.blades, hook.id) != retractor.blades.end();
            }))
            blades.push_back(hook.id);
    if (blades.size() == 2)
        change_hooks([&] {
            const RetractorSpec& retractor = *approach_.retractor;
            hooks_->join(
                { blades[0], blades[1] }, retractor.kind, retractor.greatest_opening_mm, retractor.play_deg * kRadians);
            hooks_->pull_share(1.0);
        });
}

namespace {

    /// Takes hooks that are in the wound out of those to place, whether they were pulled by hand since or not.
    /// @return those hooks and their planned drives
    std::vector<std::pair<fem::HookId, fem::HookDrive>> take_out_those_there(
        PlannedPlacements& planned, const std::vector<HookState>& there)
    {
        std::vector<std::pair<fem::HookId, fem::HookDrive>> found;
        PlannedPlacements missing {
            .placements = {}, .names = {}, .drives = {}, .omitted = std::move(planned.omitted)
        };
        for (std::size_t i = 0; i < planned.placements.size(); ++i) {
            if (const auto same = std::ranges::find(there, planned.names[i], &HookState::name); same != there.end()) {
                found.emplace_back(same->id, planned.drives[i]);
                continue;
            }
            missing.placements.push_back(std::move(planned.placements[i]));
            missing.names.push_back(std::move(planned.names[i]));
            missing.drives.push_back(planned.drives[i]);
        }
        planned = std::move(missing);
        return found;
    }

    std::string tension_unlike_the_plan(double here, double planned)
    {
        const auto text = [](double strain) {
            std::ostringstream percent;
            percent << 100.0 * strain << " % tension";
            return strain == 0.0 ? std::string("no tension") : percent.str();
        };
        return "Here the tissue is under " + text(here) + ", in the plan under " + text(planned)
            + ": the wound opens differently";
    }

} // namespace

KnifeAnswer SurgerySession::take_planned_hooks()
{
    return hook_step("opening as planned", {}, [&] { return attach_planned_hooks(); });
}

KnifeAnswer SurgerySession::attach_planned_hooks()
{
    if (stroke_open())
        return { false, "a stroke is open: finish it first" };
    if (approach_.hooks.empty())
        return { false, "the approach has no hooks" };
    const std::vector<mesh::LipFace> lips = session_.lips();
    if (lips.empty())
        return { false, "there is no wound to open: cut first" };
    PlannedPlacements planned = planned_placements(session_, approach_, labels_, held_);
    if (planned.placements.empty() || (approach_.retractor && planned.placements.size() < 2))
        return { false, planned.omitted }; // a retractor needs both blades
    if (approach_.retractor)
        for (std::size_t n = 0; n < planned.placements.size(); ++n) { // as a retractor's that is set by hand
            planned.names[n] = std::string(kPlannedBlade) + readable(blade_name(planned.placements[n].pull));
            bear_on_bone(planned.placements[n], session_, skeleton_);
        }
    const auto there = take_out_those_there(planned, hooks().hooks);
    KnifeAnswer answer { true, planned.omitted };
    if (!planned.placements.empty())
        answer = attach(std::move(planned.placements), planned.names, planned.drives, true, std::move(planned.omitted));
    if (!there.empty())
        change_hooks([&] {
            for (const auto& [hook, drive] : there)
                if (hooks_->has(hook)) // what was attached may have taken it off
                    hooks_->plan(hook, drive);
            hooks_->pull_share(1.0);
            answer.done = true;
        });
    join_planned_blades();
    if (answer.done && approach_.retractor && approach_.retractor->force_N)
        answer.reason += (answer.reason.empty() ? "" : "; ")
            + std::string("each blade pulls with its force by itself, without a rack");
    if (answer.done && tension_ != case_tension())
        answer.reason += (answer.reason.empty() ? "" : "; ") + tension_unlike_the_plan(tension_, case_tension());
    return answer;
}

void SurgerySession::pull_hook(fem::HookId hook, const Vec3& asked)
{
    if (has_hook(hook))
        hook_step(moved_name(hook) == hook_name(hook) ? "moving the " + hook_name(hook) : "cranking the retractor",
            moved_name(hook), [&] { change_hooks([&] { hooks_->pull(hook, asked); }); });
}

void SurgerySession::pull_all_hooks(double mm)
{
    hook_step("opening all hooks", "all", [&] { change_hooks([&] { hooks_->pull_all(mm); }); });
}

void SurgerySession::pull_hooks_by_share(double share)
{
    hook_step("opening all hooks", "all", [&] { change_hooks([&] { hooks_->pull_share(share); }); });
}

void SurgerySession::set_yield(double force_N)
{
    if (!(force_N > 0.0))
        throw InputError("the force at which hooks yield must be positive", "yield");
    yield_N_ = force_N;
    change_hooks([&] { hooks_->set_yield(force_N); });
}

void SurgerySession::set_nonlinear(bool wanted)
{
    if (std::exchange(nonlinear_, wanted) != wanted)
        change_hooks([&] { hooks_->set_nonlinear(wanted); });
}

void SurgerySession::take_off_hook(fem::HookId hook)
{
    if (has_hook(hook))
        hook_step("taking off the " + hook_name(hook), {}, [&] { change_hooks([&] { hooks_->take_off(hook); }); });
}

void SurgerySession::take_off_hooks()
{
    hook_step("taking off all hooks", {}, [&] { take_hooks_off(); });
}

void SurgerySession::take_hooks_off()
{
    if (hooks_ != nullptr)
        hooks_taken_off();
}

/// What a move of this hook moves: the hook, or the retractor whose blade it is.
std::string SurgerySession::moved_name(fem::HookId hook) const
{
    for (const RetractorState& retractor : hooks_->report().retractors)
        if (std::ranges::find(retractor.blades, hook) != retractor.blades.end())
            return "retractor with the " + hook_name(retractor.blades[0]);
    return hook_name(hook);
}

std::string SurgerySession::hook_name(fem::HookId hook) const
{
    const std::vector<HookState>& there = hooks_->report().hooks;
    const auto found = std::ranges::find(there, hook, &HookState::id);
    return found == there.end() ? std::string {} : found->name;
}

void SurgerySession::relax(double milliseconds, const Job& job)
{
    if (!moving_ || waiting())
        return;
    if (hooks_ != nullptr) {
        moving_ = false;
        with_hooks([&] { hooks_->settle(stroke_open(), job); });
        moving_ = moving_ && hooks_unsettled();
        match_forces();
        return;
    }
    fem::RelaxOptions options;
    RETRACTOR_ASSERT(springs_ != nullptr); // what moves without hooks are springs
    options.tolerance = kRestTolerance;
    options.max_iterations = std::max(kFewestIterations, static_cast<int>(milliseconds * iterations_per_ms_));
    options.reach_mm = reach_mm_ > kLastReachMm ? 0.0 : reach_mm_;
    const Points before = springs_->displacement();
    fem::RelaxResult result;
    try {
        result = retractor::fem::relax(*springs_, options);
    } catch (const std::exception& error) {
        drop_tension(error.what());
        return;
    }
    if (result.iterations > 0 && result.seconds > 0.0)
        iterations_per_ms_ = static_cast<double>(result.iterations) / (1e3 * result.seconds);
    picture_.reset();
    // Conjugate gradients restart in every frame, and a few flat elements never converge. The wound is therefore at
    // rest when no motion is visible.
    const double moved = (springs_->displacement() - before).rowwise().norm().maxCoeff();
    still_frames_ = moved < kStillMm ? still_frames_ + 1 : 0;
    if (result.status == fem::RelaxStatus::out_of_iterations && still_frames_ < kStillFrames)
        return;
    // The tissue near the wound has opened; next the tissue farther away moves along.
    still_frames_ = 0;
    moving_ = options.reach_mm > 0.0;
    reach_mm_ *= 2.0;
}

double SurgerySession::gape_mm() const
{
    double widest = 0.0;
    if (hooks_ != nullptr) {
        const Eigen::VectorXd& u = hooks_->displacement();
        for (const auto& [a, b] : parted_)
            widest = std::max(widest, (u.segment<3>(3 * a) - u.segment<3>(3 * b)).norm());
    } else if (springs_ != nullptr) {
        for (const auto& [a, b] : parted_)
            widest = std::max(widest, (springs_->displacement().row(a) - springs_->displacement().row(b)).norm());
    }
    return widest;
}

std::shared_ptr<const WallPicture> SurgerySession::picture()
{
    if (picture_ != nullptr)
        return picture_;
    if (surface_ == nullptr)
        surface_ = make_surface();
    auto made = std::make_shared<WallPicture>();
    made->surface = surface_;
    made->shown = surface_->rest;
    if (hooks_ != nullptr) {
        const Eigen::Map<const Points> moved(hooks_->displacement().data(), hooks_->displacement().size() / 3, 3);
        const Eigen::Index rows = std::min(made->shown.rows(), moved.rows());
        made->shown.topRows(rows) += moved.topRows(rows);
    } else if (springs_ != nullptr) {
        const Eigen::Index rows = std::min(made->shown.rows(), springs_->displacement().rows());
        made->shown.topRows(rows) += springs_->displacement().topRows(rows);
    }
    picture_ = std::move(made);
    return picture_;
}

} // namespace retractor::planner
