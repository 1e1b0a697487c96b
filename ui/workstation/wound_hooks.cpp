#include "ui/workstation/wound_hooks.h"

#include "mesh/base/error.h"
#include "mesh/base/job.h"

#include <algorithm>
#include <set>

namespace retractor {

namespace {

    /// Cuts and hooks have added so many vertices to the system solved online that a new factorisation pays.
    constexpr std::size_t kGrown = 60;

    /// The next step of the knife changes vertices about so far from what the last has made.
    constexpr double kNextStepMm = 10.0;

    OnlineOptions options_of(std::vector<Mat3> stress_of_element)
    {
        OnlineOptions options;
        options.added_vertices = 400; // a new one is made in the background before it comes to that
        options.stress_of_element = std::move(stress_of_element);
        return options;
    }

} // namespace

WoundHooks::WoundHooks(const CutSession& session, std::span<const Material> material_of_label, const Supports& supports,
    std::span<const VertexId> corridor, std::vector<Mat3> stress_of_element)
    : opening_(session, material_of_label, supports, corridor, options_of(std::move(stress_of_element)))
    , displacement_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(session.vertex_slots())))
    , corridor_(opening_.corridor_vertices())
{
}

bool WoundHooks::has(HookId hook) const
{
    return std::any_of(
        report_.hooks.begin(), report_.hooks.end(), [&](const HookState& state) { return state.id == hook; });
}

HookState& WoundHooks::state(HookId hook)
{
    const auto found = std::find_if(
        report_.hooks.begin(), report_.hooks.end(), [&](const HookState& state) { return state.id == hook; });
    if (found == report_.hooks.end())
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    return *found;
}

HookDrive WoundHooks::drive_of(const HookState& hook) const
{
    return { .displacement = hook.asked, .force_limit_N = yield_N_ };
}

HookId WoundHooks::attach(HookSeat seat, std::string name, const Vec3& opened)
{
    HookState hook { .name = std::move(name), .seat = std::move(seat), .asked = opened };
    hook.id = opening_.attach({ hook.name, hook.seat.side, hook.seat.nodes, drive_of(hook) });
    report_.hooks.push_back(std::move(hook));
    columns_ = false;
    report_.settled = false;
    return report_.hooks.back().id;
}

void WoundHooks::take_off(HookId hook)
{
    (void)state(hook);
    opening_.detach(hook);
    std::erase_if(report_.hooks, [&](const HookState& state) { return state.id == hook; });
    columns_ = false;
    report_.settled = false;
}

void WoundHooks::pull(HookId hook, const Vec3& asked)
{
    HookState changed = state(hook);
    changed.asked = asked;
    opening_.drive(hook, drive_of(changed));
    state(hook) = changed;
    report_.settled = false;
}

void WoundHooks::pull_all(double mm)
{
    for (const HookState& hook : std::vector<HookState>(report_.hooks))
        pull(hook.id, mm * hook.seat.pull);
}

void WoundHooks::set_yield(double force_N)
{
    const double was = std::exchange(yield_N_, force_N);
    try {
        for (const HookState& hook : report_.hooks)
            opening_.drive(hook.id, drive_of(hook));
    } catch (const InputError&) {
        yield_N_ = was;
        throw;
    }
    report_.settled = false;
}

/// Where there is no answer, new vertices go with those that they come from.
void WoundHooks::carry(const MeshDelta& delta)
{
    for (const MeshDelta::VertexBorn& born : delta.vertices_born) {
        const auto at = 3 * static_cast<Eigen::Index>(born.id);
        if (displacement_.size() < at + 3)
            displacement_.conservativeResizeLike(Eigen::VectorXd::Zero(at + 3));
        const Vec3 a = displacement_.segment<3>(3 * born.a), b = displacement_.segment<3>(3 * born.b);
        displacement_.segment<3>(at) = (1.0 - born.t) * a + born.t * b;
    }
    for (const MeshDelta::VertexBorn& gone : delta.vertices_gone)
        displacement_.segment<3>(3 * gone.id).setZero();
}

void WoundHooks::follow(const MeshDelta& delta, const CutSession& session)
{
    const Stopwatch watch;
    swap_factor();
    opening_.follow(delta, session.lips());
    carry(delta);
    columns_ = false;
    report_.settled = false;
    take_off_lost(session);
    (void)solve();
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

void WoundHooks::renew_factor(const MeshDelta& delta)
{
    if (opening_.rebuilding() || opening_.corridor_vertices() <= corridor_ + kGrown)
        return;
    std::vector<VertexId> near;
    const OnlineStiffness& K = opening_.stiffness();
    for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
        if (K.alive(v) && std::any_of(delta.vertices_born.begin(), delta.vertices_born.end(), [&](const auto& born) {
                return (born.position - K.position(v)).norm() < kNextStepMm;
            }))
            near.push_back(v);
    opening_.start_rebuild(near);
}

void WoundHooks::take_off_lost(const CutSession& session)
{
    std::set<VertexId> on_lips;
    for (const LipTriangle& lip : lip_triangles(session))
        on_lips.insert(lip.vertices.begin(), lip.vertices.end());
    for (const HookState& hook : std::vector<HookState>(report_.hooks)) {
        const auto left = std::count_if(
            hook.seat.nodes.begin(), hook.seat.nodes.end(), [&](VertexId v) { return on_lips.contains(v); });
        if (left >= 3)
            continue;
        lost(hook.name);
        take_off(hook.id);
    }
}

void WoundHooks::lost(const std::string& name)
{
    remark_ += (remark_.empty() ? "" : "; ") + name + " has lost its hold and is taken off";
}

/// The exact answer; @return false when there is none: it is said why.
bool WoundHooks::solve()
{
    OnlineAnswer answer = opening_.answer();
    while (answer.lost_hook) {
        lost(state(*answer.lost_hook).name);
        take_off(*answer.lost_hook);
        answer = opening_.answer();
    }
    opening_.complete(answer);
    return take(answer);
}

bool WoundHooks::take(const OnlineAnswer& answer)
{
    report_.refusal = answer.status == OnlineStatus::solved ? std::string {} : answer.message;
    if (answer.status == OnlineStatus::unsupported)
        return false;
    displacement_ = answer.displacement;
    report_.residual = answer.residual;
    report_.side_N = {};
    for (std::size_t i = 0; i < answer.hooks.size(); ++i) {
        HookState& hook = state(answer.hooks[i]);
        hook.displacement = answer.hook_displacements[i];
        hook.force_N = answer.hook_forces_N[i];
        hook.yielded = answer.hook_yielded[i];
        report_.side_N[hook.seat.side > 0 ? 0 : 1] += hook.force_N.norm();
    }
    return true;
}

void WoundHooks::frame()
{
    const Stopwatch watch;
    report_.settled = false;
    if (!columns_) {
        if (!solve()) { // refused: there are no columns
            report_.frame_ms = 1e3 * watch.seconds();
            return;
        }
        opening_.prepare_drag();
        columns_ = true;
    }
    (void)take(opening_.drag_answer());
    report_.frame_ms = 1e3 * watch.seconds();
}

void WoundHooks::settle()
{
    swap_factor();
    if (solve())
        report_.strain = strain_peak(opening_.stiffness(), displacement_, opening_.held_vertices());
    report_.settled = true;
}

} // namespace retractor
