#include "planner/session/wound_hooks.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "planner/session/retractor/blade_bearing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace retractor::planner {

namespace {

    /// A new factorisation pays when cuts and hooks have added this many vertices, and this share, to the system that
    /// is solved online.
    constexpr std::size_t kGrown = 60, kGrownShare = 4;

    /// Distance from the last step of the knife within which the next step changes vertices.
    constexpr double kNextStepMm = 10.0;

    /// Largest residual of a nonlinear frame that is shown; a frame with a larger residual looks torn.
    constexpr double kShowable = 0.05;

    /// Largest error of the linear tissue outside that needs no message, the tolerance of a plan
    /// (OpeningOptions::far_tolerance).
    constexpr double kFarTolerance = 0.01;

    std::string far_in_words(double change)
    {
        if (!std::isfinite(change))
            return "; the linear tissue beyond has inverted elements: a plan can solve the whole wall nonlinearly";
        constexpr double kUseless = 1.0; // the error is as large as the answer
        if (change > kUseless)
            return "; the linear tissue beyond is off by more than 100 %: do not rely on these forces, plan the "
                   "approach";
        return "; the linear tissue beyond has an error of about " + std::to_string(std::lround(100.0 * change))
            + " %: a plan can solve the whole wall nonlinearly";
    }

    fem::OnlineOptions options_of(std::vector<Mat3> stress_of_element)
    {
        fem::OnlineOptions options;
        options.added_vertices = 400; // a new factor is made in the background before this limit
        options.stress_of_element = std::move(stress_of_element);
        return options;
    }

    std::vector<VertexId> wound_vertices(std::span<const LipTriangle> lips)
    {
        std::set<VertexId> on_lips;
        for (const LipTriangle& lip : lips)
            on_lips.insert(lip.vertices.begin(), lip.vertices.end());
        return { on_lips.begin(), on_lips.end() };
    }

    /// Moves new vertices with the vertices that they come from, when there is no solution.
    void carry_along(Eigen::VectorXd& field, const mesh::MeshDelta& delta)
    {
        for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born) {
            const auto at = 3 * static_cast<Eigen::Index>(born.id);
            if (field.size() < at + 3)
                field.conservativeResizeLike(Eigen::VectorXd::Zero(at + 3));
            const Vec3 a = field.segment<3>(3 * born.a), b = field.segment<3>(3 * born.b);
            field.segment<3>(at) = (1.0 - born.t) * a + born.t * b;
        }
        for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone)
            field.segment<3>(3 * gone.id).setZero();
    }

} // namespace

WoundHooks::WoundHooks(const mesh::CutSession& session, std::span<const fem::Material> material_of_label,
    const fem::Supports& supports, std::span<const VertexId> corridor, std::vector<Mat3> stress_of_element)
    : opening_(session, material_of_label, supports, corridor, options_of(std::move(stress_of_element)))
    , materials_(material_of_label.begin(), material_of_label.end())
    , displacement_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(session.vertex_slots())))
    , linear_(displacement_)
    , corridor_(opening_.corridor_vertices())
{
    see_wound(session);
}

void WoundHooks::see_wound(const mesh::CutSession& session)
{
    const std::vector<LipTriangle> lips = lip_triangles(session);
    wound_ = wound_vertices(lips);
    lip_pairs_ = lip_pairs(session, lips);
}

bool WoundHooks::has(fem::HookId hook) const
{
    return std::any_of(
        report_.hooks.begin(), report_.hooks.end(), [&](const HookState& state) { return state.id == hook; });
}

HookState& WoundHooks::state(fem::HookId hook)
{
    const auto found = std::find_if(
        report_.hooks.begin(), report_.hooks.end(), [&](const HookState& state) { return state.id == hook; });
    if (found == report_.hooks.end())
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    return *found;
}

std::optional<double> share_of_plan(std::span<const HookState> hooks)
{
    for (const HookState& hook : hooks)
        if (hook.planned && hook.planned->force_N && hook.drive.force_N)
            return hook.drive.force_N->norm() / hook.planned->force_N->norm();
    return {};
}

Vec3 moved_by_hand(const HookReport& report, const HookState& hook)
{
    for (const RetractorState& retractor : report.retractors)
        for (std::size_t blade = 0; blade < 2; ++blade)
            if (retractor.blades[blade] == hook.id)
                return retractor.arm_mm[blade] * hook.placement.pull;
    return hook.drive.force_N ? hook.displacement : hook.drive.displacement;
}

/// Limits a drive by the force at which all hooks slip.
fem::HookDrive WoundHooks::limited(const fem::HookDrive& drive) const
{
    fem::HookDrive limited = drive;
    limited.force_limit_N = std::min(limited.force_limit_N, yield_N_);
    if (limited.force_N && limited.force_N->norm() > yield_N_)
        limited.force_N = yield_N_ * limited.force_N->normalized();
    return limited;
}

fem::HookId WoundHooks::attach(
    HookPlacement placement, std::string name, const fem::HookDrive& drive, std::optional<fem::HookDrive> planned)
{
    HookState hook {
        .name = std::move(name), .placement = std::move(placement), .drive = drive, .planned = std::move(planned)
    };
    hook.id = opening_.attach({ hook.name, hook.placement.side, hook.placement.nodes, limited(drive) });
    const fem::HookId id = hook.id;
    report_.hooks.push_back(std::move(hook));
    // The linear solution already moves the tissue to the hook; adding `since_` would move the tissue twice.
    forget_since();
    outdate_near();
    drive_one(id, drive);
    return id;
}

void WoundHooks::take_off(fem::HookId hook)
{
    (void)state(hook);
    std::vector<fem::HookId> gone { hook };
    if (const Rack* rack = rack_of(hook)) {
        gone.assign(rack->state.blades.begin(), rack->state.blades.end());
        std::erase_if(racks_, [&](const Rack& other) { return other.state.blades[0] == gone[0]; });
    }
    for (const fem::HookId one : gone) {
        opening_.detach(one);
        std::erase_if(report_.hooks, [&](const HookState& state) { return state.id == one; });
        since_hooks_.erase(one);
    }
    stopped_.clear();
    stopped_hooks_.clear();
    outdate_near();
}

void WoundHooks::drive(const std::map<fem::HookId, fem::HookDrive>& asked)
{
    for (const auto& [hook, drive] : asked)
        fem::check_drive(drive, state(hook).name);
    std::vector<Vec3> where;
    std::vector<double> gives_way;
    for (const HookState& hook : report_.hooks) {
        const auto found = asked.find(hook.id);
        const bool drawn = found != asked.end() && !found->second.force_N;
        const bool follows = !hook.drive.force_N && !hook.yielded && std::isinf(hook.drive.grip_N_per_mm);
        where.push_back(drawn ? found->second.displacement : follows ? hook.drive.displacement : hook.displacement);
        if (const std::optional<Vec3>& along = hook.drive.only_along) // across it the tissue has slid
            where.back() = hook.displacement + (where.back() - hook.displacement).dot(*along) * *along;
        gives_way.push_back(drawn ? 1.0 : 0.0);
    }
    const std::vector<Vec3> wanted = where;
    const std::vector<fem::FacingHooks> met = fem::draw_back(opening_.facing_hooks(), gives_way, where);
    for (std::size_t i = 0; i < report_.hooks.size(); ++i) {
        HookState& hook = report_.hooks[i];
        const auto found = asked.find(hook.id);
        if (found == asked.end())
            continue;
        fem::HookDrive drive = found->second;
        if (!drive.force_N && !drive.only_along)
            drive.displacement = where[i];
        else if (const Vec3 back = where[i] - wanted[i]; !drive.force_N && drive.only_along->dot(back) != 0.0)
            // As far back along its own way as takes it off the other lip.
            drive.displacement += back.squaredNorm() / drive.only_along->dot(back) * *drive.only_along;
        opening_.drive(hook.id, limited(drive));
        hook.drive = drive;
    }
    stopped_ = names_of(met);
    stopped_hooks_.clear();
    for (const fem::FacingHooks& pair : met)
        stopped_hooks_.insert({ report_.hooks[pair.a].id, report_.hooks[pair.b].id });
    for (Rack& rack : racks_)
        if (is_stopped(rack))
            read_rack(rack);
    report_.settled = linear_settled_ = false;
}

void WoundHooks::drive_one(fem::HookId hook, const fem::HookDrive& asked)
{
    std::map<fem::HookId, fem::HookDrive> one;
    one.emplace(hook, asked);
    drive(one);
}

/// Names of the pairs, such as "hook 1 and hook 2; hook 3 and hook 2".
std::string WoundHooks::names_of(std::span<const fem::FacingHooks> meeting) const
{
    std::string names;
    for (const fem::FacingHooks& pair : meeting)
        names += (names.empty() ? "" : "; ") + report_.hooks[pair.a].name + " and " + report_.hooks[pair.b].name;
    return names;
}

WoundHooks::Rack* WoundHooks::rack_of(fem::HookId hook)
{
    const auto found = std::find_if(racks_.begin(), racks_.end(), [&](const Rack& rack) {
        return std::find(rack.state.blades.begin(), rack.state.blades.end(), hook) != rack.state.blades.end();
    });
    return found == racks_.end() ? nullptr : &*found;
}

void WoundHooks::join(std::array<fem::HookId, 2> blades, std::string kind, double greatest_opening_mm, double play_rad)
{
    if (!(play_rad >= 0.0 && play_rad <= 0.5 * std::numbers::pi))
        throw InputError("the play of a retractor's blades must be between 0 and 90 degrees", kind);
    if (!(greatest_opening_mm > 0.0))
        throw InputError("the greatest opening of a retractor must be positive", kind);
    Rack rack { .state = { .kind = std::move(kind),
                    .blades = blades,
                    .play_rad = play_rad,
                    .greatest_opening_mm = greatest_opening_mm } };
    for (const fem::HookId blade : blades) {
        if (rack_of(blade) != nullptr)
            throw InputError("this hook is the blade of a retractor already", state(blade).name);
        if (state(blade).drive.force_N)
            throw InputError("a hook that pulls with a force has no rack", state(blade).name);
    }
    read_rack(rack);
    racks_.push_back(std::move(rack));
    std::map<fem::HookId, fem::HookDrive> sliding; // steel does not hold tissue that moves along it
    for (const fem::HookId blade : blades) {
        fem::HookDrive& drive = sliding.emplace(blade, state(blade).drive).first->second;
        drive.only_along = state(blade).placement.pull.normalized();
    }
    drive(sliding);
}

/// Reads where a rack is from how its blades are driven.
void WoundHooks::read_rack(Rack& rack)
{
    std::array<double, 2> outward {};
    for (std::size_t i = 0; i < 2; ++i) {
        const HookState& blade = state(rack.state.blades[i]);
        outward[i] = blade.drive.displacement.dot(blade.placement.pull);
        rack.across[i] = blade.drive.displacement - outward[i] * blade.placement.pull;
    }
    const std::array<const HookPlacement*, 2> blades { &state(rack.state.blades[0]).placement,
        &state(rack.state.blades[1]).placement };
    rack.state.opening_mm = opening_of_arms(blades, outward[0] + outward[1], rack.state.play_rad);
    for (std::size_t i = 0; i < 2; ++i)
        outward[i] += behind_arm_mm(*blades[i], rack.state.opening_mm, rack.state.play_rad);
    rack.balance.start_at(0.5 * (outward[0] - outward[1]));
}

bool WoundHooks::is_stopped(const Rack& rack) const
{
    return std::any_of(rack.state.blades.begin(), rack.state.blades.end(),
        [&](fem::HookId blade) { return stopped_hooks_.contains(blade); });
}

/// How far the arm of a blade has moved along the blade's pull.
double WoundHooks::arm_mm(const Rack& rack, std::size_t blade)
{
    return 0.5 * rack.state.opening_mm + (blade == 0 ? 1.0 : -1.0) * rack.balance.shift_mm();
}

std::array<fem::HookDrive, 2> WoundHooks::drives_of(const Rack& rack) const
{
    std::array<fem::HookDrive, 2> drives;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto blade = std::find_if(report_.hooks.begin(), report_.hooks.end(),
            [&](const HookState& hook) { return hook.id == rack.state.blades[i]; });
        RETRACTOR_ASSERT(blade != report_.hooks.end());
        const double arm = arm_mm(rack, i),
                     behind = behind_arm_mm(blade->placement, rack.state.opening_mm, rack.state.play_rad);
        drives[i] = blade->drive;
        drives[i].displacement = rack.across[i] + (arm - behind) * blade->placement.pull;
    }
    return drives;
}

void WoundHooks::open_rack(Rack& rack, double opening_mm)
{
    if (!std::isfinite(opening_mm))
        throw InputError("the opening of a retractor must be finite", rack.state.kind);
    const double wanted = std::clamp(opening_mm, 0.0, rack.state.greatest_opening_mm);
    rack.balance.open(std::exchange(rack.state.opening_mm, wanted), wanted);
}

void WoundHooks::crank(fem::HookId blade, double opening_mm)
{
    (void)state(blade);
    Rack* rack = rack_of(blade);
    if (rack == nullptr)
        throw InputError("this hook has no rack", state(blade).name);
    open_rack(*rack, opening_mm);
    const auto drives = drives_of(*rack);
    drive({ { rack->state.blades[0], drives[0] }, { rack->state.blades[1], drives[1] } });
    for (const fem::HookId one : rack->state.blades)
        state(one).planned.reset();
}

HookSet WoundHooks::hook_set() const
{
    HookSet set { report_.hooks, report_.retractors };
    std::vector<VertexId> held = opening_.held_vertices();
    std::sort(held.begin(), held.end());
    for (HookState& hook : set.hooks)
        std::erase_if(
            hook.placement.nodes, [&](VertexId v) { return !std::binary_search(held.begin(), held.end(), v); });
    return set;
}

void WoundHooks::return_to(const HookSet& then)
{
    const auto named = [](const std::vector<HookState>& hooks, const std::string& name) {
        return std::ranges::find(hooks, name, &HookState::name);
    };
    for (const HookState& hook : std::vector<HookState>(report_.hooks))
        if (has(hook.id) && named(then.hooks, hook.name) == then.hooks.end())
            take_off(hook.id);
    std::map<fem::HookId, fem::HookId> now; // from the ids of that time
    for (const HookState& hook : then.hooks) {
        const auto there = named(report_.hooks, hook.name);
        now[hook.id]
            = there != report_.hooks.end() ? there->id : attach(hook.placement, hook.name, hook.drive, hook.planned);
    }
    std::map<fem::HookId, fem::HookDrive> drives;
    for (const HookState& hook : then.hooks)
        drives[now.at(hook.id)] = hook.drive;
    for (const RetractorState& retractor : then.retractors) {
        const std::array blades { now.at(retractor.blades[0]), now.at(retractor.blades[1]) };
        if (rack_of(blades[0]) == nullptr)
            join(blades, retractor.kind, retractor.greatest_opening_mm, retractor.play_rad);
        Rack& rack = *rack_of(blades[0]);
        open_rack(rack, retractor.opening_mm);
        const auto of_rack = drives_of(rack);
        for (std::size_t i = 0; i < 2; ++i)
            drives[blades[i]] = of_rack[i];
    }
    for (const auto& [hook, then_driven] : drives)
        if (state(hook).drive.force_N.has_value() != then_driven.force_N.has_value())
            forget_since(); // as pull() does
    drive(drives);
    for (const HookState& hook : then.hooks)
        state(now.at(hook.id)).planned = hook.planned;
}

/// Forces by which the rack pushes the blades outwards along it.
std::array<double, 2> WoundHooks::rack_forces(const Rack& rack, const std::map<fem::HookId, HookNumbers>& numbers) const
{
    std::array<double, 2> along {};
    for (const HookState& hook : report_.hooks)
        for (std::size_t i = 0; i < 2; ++i)
            if (hook.id == rack.state.blades[i])
                along[i] = numbers.at(hook.id).force_N.dot(hook.placement.pull);
    return along;
}

/// Moves each rack one step towards its balance. @return whether one has moved
bool WoundHooks::step_racks(const std::map<fem::HookId, HookNumbers>& numbers)
{
    std::map<fem::HookId, fem::HookDrive> moved;
    for (Rack& rack : racks_) {
        const auto& [first, second] = rack.state.blades;
        // A blade that slips, or that lips in its way stop, tells nothing of where the rack would go.
        if (is_stopped(rack) || numbers.at(first).yielded || numbers.at(second).yielded)
            continue;
        const auto along = rack_forces(rack, numbers);
        if (!rack.balance.step(along[0], along[1]))
            continue;
        const auto drives = drives_of(rack);
        moved.emplace(first, drives[0]);
        moved.emplace(second, drives[1]);
    }
    if (moved.empty())
        return false;
    drive(moved);
    return true;
}

/// Whether the linear solution is shown, without a nonlinear one below it. Racks come to rest in what is shown.
bool WoundHooks::linear_alone() const { return !near_usable() && since_.size() == 0; }

/// Brings the racks to rest in the linear solution. @pre exactly, or columns_
void WoundHooks::balance_linear(bool exactly)
{
    constexpr int kMostSteps = 4; // two are enough where nothing slips
    for (int i = 0; i < kMostSteps && answered_ && step_racks(linear_hooks_); ++i) {
        if (exactly)
            linear_settled_ = solve();
        else
            (void)take(opening_.drag_answer());
    }
}

/// Brings the racks to rest in the nonlinear solution, which has settled.
void WoundHooks::balance_nonlinear(const Job& job)
{
    constexpr int kMostSteps = 3; // each settles the nonlinear solution again
    for (int i = 0; i < kMostSteps && near_usable() && near_.settled() && !job.cancelled(); ++i) {
        const fem::NearFrame& frame = near_.frame();
        std::map<fem::HookId, HookNumbers> numbers;
        for (std::size_t h = 0; h < report_.hooks.size(); ++h)
            numbers[report_.hooks[h].id]
                = { frame.hook_displacements[h], frame.hook_forces_N[h], frame.hook_yielded[h] };
        if (!step_racks(numbers))
            return;
        linear_settled_ = solve();
        drag_near();
        near_.settle(job);
    }
}

void WoundHooks::report_racks()
{
    std::map<fem::HookId, HookNumbers> numbers;
    for (const HookState& hook : report_.hooks)
        numbers[hook.id] = { hook.displacement, hook.force_N, hook.yielded };
    report_.retractors.clear();
    for (Rack& rack : racks_) {
        rack.state.blade_N = rack_forces(rack, numbers);
        for (std::size_t i = 0; i < 2; ++i) {
            rack.state.arm_mm[i] = arm_mm(rack, i);
            rack.state.turn_rad[i]
                = blade_turn(state(rack.state.blades[i]).placement, rack.state.opening_mm, rack.state.play_rad);
        }
        const auto [first, second] = rack.state.blade_N;
        rack.state.force_N = 0.5 * (first + second);
        const double larger = std::max(std::abs(first), std::abs(second));
        rack.state.imbalance = larger > 0.0 ? std::abs(first - second) / larger : 0.0;
        report_.retractors.push_back(rack.state);
    }
}

void WoundHooks::pull(fem::HookId hook, const Vec3& asked)
{
    if (const Rack* rack = rack_of(hook)) {
        // The shift grows with the opening: this blade moves by this share of it.
        constexpr double kLeastMm = 1.0, kLeastShare = 0.1, kMostShare = 0.9;
        const double shift = (hook == rack->state.blades[0] ? 1.0 : -1.0) * rack->balance.shift_mm();
        const double open = rack->state.opening_mm;
        const double share = open > kLeastMm ? std::clamp(0.5 + shift / open, kLeastShare, kMostShare) : 0.5;
        return crank(hook, asked.dot(state(hook).placement.pull) / share);
    }
    fem::HookDrive drawn = state(hook).drive;
    if (drawn.force_N)
        forget_since(); // the displacement by a force has no relation to the displacement by the hand
    drawn.force_N.reset();
    drawn.displacement = asked;
    drive_one(hook, drawn);
    state(hook).planned.reset();
}

void WoundHooks::pull_all(double mm)
{
    std::map<fem::HookId, fem::HookDrive> drawn;
    for (Rack& rack : racks_) {
        open_rack(rack, 2.0 * mm);
        const auto drives = drives_of(rack);
        for (std::size_t i = 0; i < 2; ++i)
            drawn.emplace(rack.state.blades[i], drives[i]);
    }
    for (const HookState& hook : report_.hooks) {
        if (rack_of(hook.id) != nullptr)
            continue;
        fem::HookDrive& drive = drawn.emplace(hook.id, hook.drive).first->second;
        if (drive.force_N)
            forget_since();
        drive.force_N.reset();
        drive.displacement = mm * hook.placement.pull;
    }
    drive(drawn);
    for (HookState& hook : report_.hooks)
        hook.planned.reset();
}

void WoundHooks::plan(fem::HookId hook, const fem::HookDrive& planned) { state(hook).planned = planned; }

void WoundHooks::pull_share(double share)
{
    if (!std::isfinite(share))
        throw InputError("the share of the planned opening must be finite", "hooks");
    std::map<fem::HookId, fem::HookDrive> driven;
    for (Rack& rack : racks_) {
        double planned_mm = 0.0; // the plan drives the arms
        for (const fem::HookId blade : rack.state.blades)
            if (const HookState& held = state(blade); held.planned)
                planned_mm += held.planned->displacement.dot(held.placement.pull);
        if (!(planned_mm > 0.0))
            continue; // a retractor that was cranked by hand stays
        open_rack(rack, share * planned_mm);
        const auto drives = drives_of(rack);
        for (std::size_t i = 0; i < 2; ++i)
            driven.emplace(rack.state.blades[i], drives[i]);
    }
    for (const HookState& hook : report_.hooks)
        if (hook.planned && rack_of(hook.id) == nullptr)
            driven.emplace(hook.id, fem::between({}, *hook.planned, share));
    drive(driven);
}

void WoundHooks::set_yield(double force_N)
{
    if (!(force_N > 0.0))
        throw InputError("the force at which hooks yield must be positive", "yield");
    yield_N_ = force_N;
    for (const HookState& hook : report_.hooks)
        opening_.drive(hook.id, limited(hook.drive));
    forget_since(); // `since_` would include forces beyond the new limit
    report_.settled = linear_settled_ = false;
}

void WoundHooks::follow(const mesh::MeshDelta& delta, const mesh::CutSession& session)
{
    const Stopwatch watch;
    swap_factor();
    opening_.follow(delta, session.lips());
    carry_along(displacement_, delta);
    carry_along(linear_, delta);
    if (since_.size() > 0)
        carry_along(since_, delta);
    see_wound(session);
    outdate_near();
    take_off_lost();
    stopped_.clear();
    stopped_hooks_.clear();
    (void)solve();
    show();
    renew_factor(delta);
    report_.frame_ms = 1e3 * watch.seconds();
}

void WoundHooks::swap_factor()
{
    if (!opening_.rebuild_ready() || !opening_.adopt_rebuild())
        return;
    corridor_ = opening_.corridor_vertices();
    columns_ = false;
    ++report_.factors_swapped;
}

void WoundHooks::renew_factor(const mesh::MeshDelta& delta)
{
    if (opening_.rebuilding() || opening_.corridor_vertices() <= corridor_ + std::max(kGrown, corridor_ / kGrownShare))
        return;
    std::vector<VertexId> near;
    const fem::OnlineStiffness& K = opening_.stiffness();
    for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
        if (K.alive(v) && std::any_of(delta.vertices_born.begin(), delta.vertices_born.end(), [&](const auto& born) {
                return (born.position - K.position(v)).norm() < kNextStepMm;
            }))
            near.push_back(v);
    opening_.start_rebuild(near);
}

void WoundHooks::take_off_lost()
{
    for (const HookState& hook : std::vector<HookState>(report_.hooks)) {
        const auto left = std::count_if(hook.placement.nodes.begin(), hook.placement.nodes.end(),
            [&](VertexId v) { return std::binary_search(wound_.begin(), wound_.end(), v); });
        if (left < 3 && has(hook.id)) // the other blade of a lost one has gone with it
            lose(hook.id);
    }
}

/// Takes a hook off that has lost its tissue, and says so.
void WoundHooks::lose(fem::HookId hook)
{
    const Rack* rack = rack_of(hook);
    remark_ += (remark_.empty() ? "" : "; ")
        + (rack != nullptr ? "the " + instrument_name(rack->state.kind) : state(hook).name)
        + " has lost its tissue and was removed";
    take_off(hook);
}

/// Computes the exact linear solution. @return false, with a message, when there is none to show
bool WoundHooks::solve()
{
    fem::OnlineAnswer answer = opening_.answer();
    while (answer.lost_hook) {
        lose(*answer.lost_hook);
        answer = opening_.answer();
    }
    opening_.complete(answer);
    return take(answer);
}

bool WoundHooks::take(const fem::OnlineAnswer& answer)
{
    report_.refusal = answer.status == fem::OnlineStatus::solved ? std::string {} : answer.message;
    held_ = answer.status != fem::OnlineStatus::unsupported;
    answered_ = held_ && answer.hooks_at_rest && answer.residual <= kShowable;
    if (!answered_)
        return false;
    linear_ = answer.displacement;
    linear_residual_ = answer.residual;
    linear_meeting_ = names_of(answer.meeting);
    for (std::size_t i = 0; i < answer.hooks.size(); ++i) {
        linear_hooks_[answer.hooks[i]]
            = { answer.hook_displacements[i], answer.hook_forces_N[i], answer.hook_yielded[i] };
    }
    return true;
}

void WoundHooks::frame()
{
    const Stopwatch watch;
    report_.settled = linear_settled_ = false;
    if (!columns_) {
        (void)solve();
        if (held_)
            opening_.prepare_drag();
        columns_ = held_;
    }
    if (columns_)
        (void)take(opening_.drag_answer());
    if (columns_ && linear_alone())
        balance_linear(false);
    drag_near();
    show();
    report_.frame_ms = 1e3 * watch.seconds();
}

void WoundHooks::settle(bool cutting, const Job& job)
{
    swap_factor();
    linear_settled_ = linear_settled_ || solve();
    if (near_.take()) {
        ++report_.near_swapped;
        drag_near();
    }
    if (near_missing() && !near_.building() && !cutting)
        begin_near();
    if (near_usable() && !near_.settled())
        near_.settle(job);
    if (!cutting) {
        if (linear_alone())
            balance_linear(true);
        balance_nonlinear(job);
    }
    if (show())
        report_.strain = fem::strain_peak(opening_.stiffness(), displacement_, opening_.held_vertices());
    report_.settled = true;
}

bool WoundHooks::settled() const { return report_.settled && !near_pending(); }

bool WoundHooks::waits(bool cutting) const
{
    return report_.settled && !near_.build_ready() && (near_.building() || (near_missing() && cutting));
}

void WoundHooks::set_nonlinear(bool wanted)
{
    if (std::exchange(nonlinear_, wanted) == wanted)
        return;
    outdate_near();
    forget_since();
}

void WoundHooks::forget_since()
{
    since_.resize(0);
    since_hooks_.clear();
}

std::vector<fem::HookDrive> WoundHooks::drives() const
{
    std::vector<fem::HookDrive> drives;
    for (const HookState& hook : report_.hooks)
        drives.push_back(limited(hook.drive));
    return drives;
}

/// Called when the mesh or the hooks have changed.
void WoundHooks::outdate_near()
{
    for (Rack& rack : racks_)
        rack.balance.forget();
    near_.outdate();
    near_begun_ = false;
    columns_ = false;
    report_.settled = linear_settled_ = false;
}

/// Whether the nonlinear solution belongs to this mesh and these hooks.
bool WoundHooks::near_usable() const { return nonlinear_ && near_.ready() && held_; }

/// Whether the nonlinear solution is wanted but not being made.
bool WoundHooks::near_missing() const
{
    return nonlinear_ && !near_begun_ && !empty() && held_ && near_.refusal().empty();
}

bool WoundHooks::near_pending() const
{
    return near_.building() || near_missing() || (near_usable() && !near_.settled());
}

void WoundHooks::begin_near()
{
    std::vector<VertexId> held = opening_.held_vertices();
    std::sort(held.begin(), held.end());
    std::vector<fem::HookPatch> hooks;
    for (const HookState& hook : report_.hooks) {
        hooks.push_back({ hook.name, hook.placement.side, hook.placement.nodes, Vec3::Zero() });
        std::erase_if(hooks.back().nodes, [&](VertexId v) { return !std::binary_search(held.begin(), held.end(), v); });
    }
    NearProblem problem = near_problem(opening_, materials_, std::move(hooks), wound_);
    problem.drives = drives();
    near_.begin(std::move(problem));
    near_begun_ = true;
}

void WoundHooks::drag_near()
{
    if (near_usable() && !near_.drawn_to(drives()))
        near_.drag(drives());
}

/// Shows the best solution. @return false when there is none, and the shown solution stays
bool WoundHooks::show()
{
    if (!near_.refusal().empty())
        forget_since();
    as_before_ = false;
    if (near_usable() && near_.frame().residual <= kShowable)
        show_near();
    else if (answered_)
        show_linear();
    else
        as_before_ = true;
    report_.side_N = {};
    for (HookState& hook : report_.hooks) {
        if (hook.drive.force_N && hook.drive.force_N->norm() > yield_N_)
            hook.yielded = true; // the solver knows the limited force only
        report_.side_N[hook.placement.side > 0 ? 0 : 1] += hook.force_N.norm();
    }
    if (!as_before_) {
        const bool near = report_.shown == ShownAnswer::nonlinear;
        const std::string met = near ? names_of(near_.frame().meeting) : linear_meeting_;
        report_.meeting = stopped_.empty() ? met : stopped_;
        report_.lip_overlap_mm = retractor::planner::lip_overlap_mm(lip_pairs_, displacement_);
    }
    constexpr double kRough = 0.2;
    report_.rough_forces = report_.shown == ShownAnswer::nonlinear && near_usable() && near_.far_change()
        && !(*near_.far_change() <= kRough);
    report_.linear_only = nonlinear_ && !near_pending()
        && (report_.shown != ShownAnswer::nonlinear
            || (near_usable() && near_.frame().status == fem::NearStatus::not_settled));
    report_racks();
    report_.shown_text = shown_in_words();
    return !as_before_;
}

void WoundHooks::show_linear()
{
    displacement_ = linear_;
    report_.shown = since_.size() > 0 ? ShownAnswer::linear_since : ShownAnswer::linear;
    if (since_.size() > 0) {
        const Eigen::Index common = std::min(since_.size(), displacement_.size());
        displacement_.head(common) += since_.head(common);
    }
    for (HookState& hook : report_.hooks) {
        const HookNumbers& linear = linear_hooks_[hook.id];
        const HookNumbers since = since_hooks_.contains(hook.id) ? since_hooks_[hook.id] : HookNumbers {};
        hook.displacement = linear.displacement + since.displacement;
        hook.force_N = linear.force_N + since.force_N;
        hook.yielded = linear.yielded;
    }
    report_.residual = linear_residual_;
}

void WoundHooks::show_near()
{
    const fem::NearFrame& frame = near_.frame();
    RETRACTOR_ASSERT(frame.hook_displacements.size() == report_.hooks.size());
    displacement_ = near_.displacement(linear_.size());
    forget_since();
    if (answered_)
        since_ = displacement_ - linear_;
    for (std::size_t i = 0; i < report_.hooks.size(); ++i) {
        HookState& hook = report_.hooks[i];
        hook.displacement = frame.hook_displacements[i];
        hook.force_N = frame.hook_forces_N[i];
        hook.yielded = frame.hook_yielded[i];
        if (!answered_)
            continue;
        const HookNumbers& linear = linear_hooks_[hook.id];
        since_hooks_[hook.id] = { hook.displacement - linear.displacement, hook.force_N - linear.force_N, false };
    }
    report_.residual = frame.residual;
    report_.shown = ShownAnswer::nonlinear;
}

std::string WoundHooks::shown_in_words() const
{
    if (report_.shown == ShownAnswer::nonlinear && !as_before_) {
        std::string within = "nonlinear within " + std::to_string(std::lround(near_.within_mm())) + " mm";
        if (near_.far_change() && *near_.far_change() > kFarTolerance)
            within += far_in_words(*near_.far_change());
        return near_.frame().status == fem::NearStatus::not_settled ? within + ", not in equilibrium" : within;
    }
    const std::string shown = as_before_       ? "last solution"
        : report_.shown == ShownAnswer::linear ? "linear"
                                               : "nonlinear plus linear change";
    if (!nonlinear_)
        return shown;
    if (!near_.refusal().empty())
        return shown + ": " + near_.refusal();
    if (near_pending())
        return shown + ": the nonlinear solution is computed";
    return near_usable() ? shown + ": no nonlinear equilibrium was found" : shown;
}

} // namespace retractor::planner
