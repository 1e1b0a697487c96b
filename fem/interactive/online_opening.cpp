#include "fem/interactive/online_opening.h"

#include "fem/interactive/multifrontal_wound_solver.h"
#include "fem/interactive/schur_wound_solver.h"
#include "fem/linear_algebra/blas_threads.h"
#include "mesh/base/error.h"

#include <cblas.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <set>
#include <sstream>
#include <utility>

namespace retractor::fem {

namespace {

    /// The factored body in one of two representations; the other is null.
    struct Factored {
        std::unique_ptr<CondensedBody> condensed;
        std::unique_ptr<MultifrontalFactor> parts;
    };

    Factored factored(const OnlineStiffness& K, const std::vector<std::uint8_t>& fixed,
        const std::vector<VertexId>& corridor, const OnlineOptions& options)
    {
        constexpr double kWorthAsking = 3e9; // multiplications; less work is done within the time of a solution
        // A dense system takes about twice the work of its factor, because added vertices are condensed onto it.
        constexpr double kDenseExtra = 2.0;
        // Products of large dense matrices are fast, and hooks cost nothing in them. Measured: with 0.7 of the dense
        // work (box of 67,000 elements) the divided body is solved later, with 0.14 (graded chest wall) three times
        // sooner.
        constexpr double kMuchLess = 0.4;
        const double dense = kDenseExtra * dense_work(corridor.size(), 0);
        if (options.body == BodyKept::dissected || (options.body == BodyKept::by_cost && dense > kWorthAsking)) {
            const Dissection dissection = dissect(K, fixed, corridor, options.part_vertices);
            if (options.body == BodyKept::dissected || dissection.work < kMuchLess * dense)
                return { nullptr, std::make_unique<MultifrontalFactor>(K, dissection) };
        }
        return { std::make_unique<CondensedBody>(K, fixed, corridor), nullptr };
    }

    Eigen::MatrixXd stacked(const std::vector<Vec3>& per_hook)
    {
        Eigen::MatrixXd d(3 * static_cast<Eigen::Index>(per_hook.size()), 1);
        for (std::size_t h = 0; h < per_hook.size(); ++h)
            d.col(0).segment<3>(3 * static_cast<Eigen::Index>(h)) = per_hook[h];
        return d;
    }

} // namespace

struct OnlineOpening::State {
    State(const mesh::CutSession& session, std::span<const Material> materials, OnlineOptions given)
        : options(std::move(given))
        , body { OnlineStiffness(session, materials, options.stress_of_element) }
    {
    }

    OnlineOptions options;
    OnlineBody body;
    std::unique_ptr<WoundSolver> solver; ///< solver of `body`
    HookId next_hook = 0;
    std::optional<HookId> lost_hook; ///< the hook because of which there is no solution
    std::optional<std::vector<FacingHooks>> facing; ///< pairs in the present body; none: not computed yet

    struct Rebuild {
        std::future<Factored> result;
        ReferenceRows reference; ///< rows touched since the rebuild was started
        Eigen::VectorXd load;
    };
    std::optional<Rebuild> rebuild;

    /// For drag(): by vertex id, three columns per hook; under loads a last column with no hook moved.
    Eigen::MatrixXd columns;
    Eigen::MatrixXd column_forces; ///< three rows per hook
    double column_residual = 0.0; ///< largest residual of the columns
    Eigen::VectorXd dragged;

    void drop_columns() { columns.resize(0, 0); }
    void hooks_changed()
    {
        solver->hooks_changed();
        drop_columns();
        facing.reset();
    }

    void adopt(Factored fresh, ReferenceRows touched, Eigen::VectorXd load)
    {
        drop_columns();
        if (fresh.parts)
            solver = std::make_unique<MultifrontalWoundSolver>(body, std::move(fresh.parts), touched);
        else
            solver = std::make_unique<SchurWoundSolver>(
                body, std::move(fresh.condensed), std::move(touched), std::move(load), options);
    }

    /// The corridor of a new factorisation: the present corridor, `more`, and the vertices of hooks.
    std::vector<VertexId> corridor_now(const std::vector<VertexId>& more) const
    {
        std::set<VertexId> corridor = hooked_vertices(body);
        if (solver) {
            const std::vector<VertexId> so_far = solver->corridor();
            corridor.insert(so_far.begin(), so_far.end());
        }
        corridor.insert(more.begin(), more.end());
        std::erase_if(corridor, [&](VertexId v) { return !body.is_active(v); });
        return { corridor.begin(), corridor.end() };
    }

    void factor_anew(const std::vector<VertexId>& corridor)
    {
        adopt(factored(body.K, body.fixed, corridor, options), {}, body.K.load());
    }

    void start_rebuild(std::vector<VertexId> corridor)
    {
        rebuild.reset(); // waits for a rebuild that is under way
        rebuild.emplace();
        rebuild->load = body.K.load();
        rebuild->result = std::async(
            std::launch::async, [K = body.K, fixed = body.fixed, corridor = std::move(corridor), how = options] {
                return factored(K, fixed, corridor, how);
            });
    }

    /// Factors the body anew where this is cheaper. The old factor stays where the body is not supported without its
    /// hooks.
    void factor_anew_if_outgrown(const std::vector<VertexId>& needed)
    {
        if (!solver->outgrown(needed))
            return;
        try {
            factor_anew(corridor_now(needed));
        } catch (const SolverError&) { // the body is not supported without its hooks
        }
    }

    /// Brings the solver up to date. @return why there is no solution; empty when there is one
    std::string prepare()
    {
        if (solver->ready())
            return {};
        lost_hook = gather_held(body);
        if (lost_hook)
            return "hook '" + body.hooks.at(*lost_hook).name
                + "' has lost its hold: fewer than three of its vertices are left";
        if (!all_joined_to_something(body))
            return loose_piece(body);
        std::vector<VertexId> needed = solver->changed_elsewhere();
        for (const HeldVertex& h : body.held)
            needed.push_back(h.vertex);
        try {
            factor_anew_if_outgrown(needed);
            solver->prepare(needed);
        } catch (const SolverError& error) {
            const std::string piece = loose_piece(body);
            if (piece.empty())
                throw;
            return piece;
        }
        constexpr double kSuspicious = 1e-11; // a loose piece leaves only round-off in this number
        if (solver->reciprocal_condition() < kSuspicious)
            if (std::string piece = loose_piece(body); !piece.empty()) {
                solver->drop_answer();
                return piece;
            }
        if (solver->reciprocal_condition() == 0.0) {
            solver->drop_answer();
            throw SolverError("a part of the tissue has no support (the stiffness is not positive definite)");
        }
        return {};
    }

    /// One case with a unit displacement per hook and axis; under loads also a last case without displacement.
    Eigen::MatrixXd unit_cases() const
    {
        const auto rows = 3 * static_cast<Eigen::Index>(body.hooks.size());
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rows, rows + (body.K.loaded() ? 1 : 0));
        unit.leftCols(rows).setIdentity();
        return unit;
    }
    /// Subtracts the last case from the other cases, because loads act in all cases of unit_cases().
    void without_loads(Eigen::MatrixXd& cases) const
    {
        if (body.K.loaded())
            for (Eigen::Index c = 0; c + 1 < cases.cols(); ++c)
                cases.col(c) -= cases.rightCols(1);
    }
    /// Sets the displacements and forces of the hooks.
    /// @param forces column_forces where the columns exist; empty: computed here
    void place_hooks(OnlineAnswer& answer, const Eigen::MatrixXd& forces = {})
    {
        std::vector<HookDrive> drives;
        bool prescribed = true;
        for (const auto& [id, hook] : body.hooks) {
            answer.hooks.push_back(id);
            drives.push_back(hook.drive);
            prescribed = prescribed && hook.drive.prescribes();
        }
        Eigen::MatrixXd symmetric;
        Eigen::VectorXd r;
        if (!prescribed) {
            Eigen::MatrixXd R = forces;
            if (R.size() == 0) {
                R = solver->solve(unit_cases()).hook_forces;
                without_loads(R);
            }
            r = body.K.loaded() ? Eigen::VectorXd(R.rightCols(1)) : Eigen::VectorXd::Zero(R.rows());
            symmetric = 0.5 * (R.leftCols(R.rows()) + R.leftCols(R.rows()).transpose());
        }
        RestApart apart = rest_of_hooks_apart(symmetric, r, drives, facing_hooks());
        const HookRest& rest = apart.rest;
        answer.meeting = std::move(apart.meeting);
        if (!rest.converged) {
            answer.status = OnlineStatus::inaccurate;
            answer.hooks_at_rest = false;
            answer.message = "no equilibrium of the hooks was found";
        }
        constexpr double kFarthest = 1e6; // mm; above, the stiffness at the hook is round-off
        if (!prescribed && !(rest.displacement.lpNorm<Eigen::Infinity>() <= kFarthest)) {
            answer.status = OnlineStatus::unsupported;
            answer.message
                = "no equilibrium of the hooks was found: tissue that a hook pulls with a force has no support";
            return;
        }
        answer.hook_yielded = rest.yielded;
        answer.hook_displacements = per_hook(rest.displacement);
    }

    const std::vector<FacingHooks>& facing_hooks()
    {
        if (!facing)
            facing = facing_hooks_of(body);
        return *facing;
    }

    /// The weights of the columns: the hooks' displacements, and 1 for the loads.
    Eigen::VectorXd column_weights(std::span<const Vec3> hook_displacements) const
    {
        if (columns.rows() == 0 || hook_displacements.size() != body.hooks.size())
            throw InputError("dragging needs prepare_drag() after the last change, and one displacement per hook");
        Eigen::VectorXd d = Eigen::VectorXd::Ones(columns.cols());
        for (std::size_t h = 0; h < hook_displacements.size(); ++h)
            d.segment<3>(3 * static_cast<Eigen::Index>(h)) = hook_displacements[h];
        return d;
    }
};

OnlineOpening::OnlineOpening(const mesh::CutSession& session, std::span<const Material> material_of_label,
    const Supports& supports, std::span<const VertexId> corridor, OnlineOptions options)
{
    state_ = std::make_unique<State>(session, material_of_label, std::move(options));
    State& s = *state_;
    set_supports(s.body, supports);
    for (const VertexId v : corridor)
        if (v < 0)
            throw InputError("there is no such vertex", "corridor, vertex " + std::to_string(v));
    if (!all_joined_to_something(s.body))
        throw SolverError(loose_piece(s.body));
    try {
        s.factor_anew(s.corridor_now({ corridor.begin(), corridor.end() }));
    } catch (const SolverError&) {
        if (const std::string piece = loose_piece(s.body); !piece.empty())
            throw SolverError(piece);
        throw;
    }
}

OnlineOpening::~OnlineOpening() = default;
OnlineOpening::OnlineOpening(OnlineOpening&&) noexcept = default;

void OnlineOpening::follow(const mesh::MeshDelta& delta, std::span<const mesh::LipFace> lips)
{
    State& s = *state_;
    OnlineStiffness& K = s.body.K;
    K.check(delta);
    s.solver->before_delta();
    std::vector<std::pair<VertexId, OnlineStiffness::Row>> before;
    for (const VertexId v : K.touched_by(delta))
        before.emplace_back(v, K.row(v));
    K.apply(delta);
    carry_supports(s.body, delta);
    for (const auto& [v, row] : before) {
        if (s.rebuild)
            s.rebuild->reference.try_emplace(v, row);
        s.solver->row_touched(v, row);
    }
    for (const mesh::MeshDelta::VertexBorn& vertex : delta.vertices_born)
        s.solver->vertex_born(vertex.id);
    for (const mesh::MeshDelta::VertexBorn& vertex : delta.vertices_gone)
        s.solver->vertex_gone(vertex.id);
    if (carry_hooks(s.body, delta))
        s.solver->hooks_changed();
    K.set_wound(lips);
    s.solver->drop_answer();
    s.drop_columns();
    s.facing.reset();
}

HookId OnlineOpening::attach(OnlineHook hook)
{
    State& s = *state_;
    check_hook(s.body, hook);
    const HookId id = s.next_hook++;
    const auto number = static_cast<std::int32_t>(s.body.hooks.size()); // hook ids rise, so the new hook is the last
    const AttachedHook& attached = s.body.hooks.emplace(id, AttachedHook { std::move(hook) }).first->second;
    for (const VertexId v : attached.nodes)
        s.body.held.push_back({ v, number });
    if (!s.solver->ready() || !s.solver->take_appended(id))
        s.solver->hooks_changed();
    s.drop_columns();
    s.facing.reset();
    return id;
}

void OnlineOpening::detach(HookId hook)
{
    if (state_->body.hooks.erase(hook) == 0)
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    state_->hooks_changed();
}

void OnlineOpening::drive(HookId hook, const HookDrive& drive)
{
    const auto found = state_->body.hooks.find(hook);
    if (found == state_->body.hooks.end())
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    check_drive(drive, found->second.name);
    found->second.drive = drive;
}

OnlineAnswer OnlineOpening::answer()
{
    State& s = *state_;
    OnlineAnswer answer;
    answer.message = s.prepare();
    if (!answer.message.empty()) {
        answer.status = OnlineStatus::unsupported;
        answer.lost_hook = s.lost_hook;
        return answer;
    }
    answer.message = partly_lost(s.body);
    s.place_hooks(answer);
    if (answer.status == OnlineStatus::unsupported)
        return answer;
    const NearAnswer near = s.solver->solve(stacked(answer.hook_displacements));
    for (std::size_t h = 0; h < answer.hooks.size(); ++h)
        answer.hook_forces_N.push_back(near.hook_forces.col(0).segment<3>(3 * static_cast<Eigen::Index>(h)));
    answer.displacement = near.displacement.col(0);
    answer.reciprocal_condition = s.solver->reciprocal_condition();
    return answer;
}

void OnlineOpening::complete(OnlineAnswer& answer)
{
    State& s = *state_;
    if (answer.status == OnlineStatus::unsupported)
        return;
    if (!s.solver->ready() || answer.displacement.size() != 3 * static_cast<Eigen::Index>(s.body.K.slot_count()))
        throw InputError("the solution belongs to an earlier state: compute a new solution");
    answer.displacement = s.solver->whole_field(answer.displacement).col(0);
    answer.whole = true;
    const double load = right_side(s.body, stacked(answer.hook_displacements).col(0)).norm();
    Eigen::VectorXd all = imbalance(s.body, answer.displacement);
    Eigen::VectorXd r = on_free(s.body, all);
    const auto relative = [&] { return load > 0.0 ? r.norm() / load : r.norm(); };
    answer.residual = relative();
    constexpr int kRefinements = 10; // each refinement gains several digits, or the factor is useless
    while (answer.residual > s.options.residual && answer.refinements < kRefinements) {
        const Eigen::VectorXd refined = answer.displacement + s.solver->correction(r);
        const Eigen::VectorXd all_refined = imbalance(s.body, refined);
        r = on_free(s.body, all_refined);
        const double was = std::exchange(answer.residual, relative());
        ++answer.refinements;
        if (!(answer.residual < was)) {
            answer.residual = was;
            break;
        }
        answer.displacement = refined;
        all = all_refined;
    }
    answer.hook_forces_N = hook_forces(s.body, all);
    if (!(answer.residual <= s.options.residual)) {
        std::ostringstream text;
        text << "the residual " << answer.residual << " is above the limit " << s.options.residual;
        answer.status = OnlineStatus::inaccurate;
        answer.message = text.str();
    }
}

double OnlineOpening::prepare_drag()
{
    State& s = *state_;
    if (const std::string refused = s.prepare(); !refused.empty())
        throw SolverError(refused);
    const Eigen::MatrixXd unit = s.unit_cases();
    const NearAnswer near = s.solver->solve(unit);
    s.columns = s.solver->whole_field(near.displacement);
    s.column_forces = near.hook_forces;
    double worst = 0.0;
    const Eigen::MatrixXd internal = s.body.K.multiply(s.columns);
    for (Eigen::Index c = 0; c < unit.cols(); ++c) {
        const double load = right_side(s.body, unit.col(c)).norm();
        Eigen::VectorXd r = -internal.col(c);
        if (s.body.K.loaded())
            r += s.body.K.load();
        if (load > 0.0)
            worst = std::max(worst, on_free(s.body, std::move(r)).norm() / load);
    }
    s.without_loads(s.columns);
    s.without_loads(s.column_forces);
    s.dragged.resize(s.columns.rows());
    s.column_residual = worst;
    return worst;
}

const Eigen::VectorXd& OnlineOpening::drag(std::span<const Vec3> hook_displacements)
{
    State& s = *state_;
    const Eigen::VectorXd d = s.column_weights(hook_displacements);
    if (d.size() == 0) {
        s.dragged.setZero();
        return s.dragged;
    }
    const auto rows = static_cast<int>(s.columns.rows());
    cblas_dgemv(CblasColMajor, CblasNoTrans, rows, static_cast<int>(s.columns.cols()), 1.0, s.columns.data(), rows,
        d.data(), 1, 0.0, s.dragged.data(), 1);
    return s.dragged;
}

std::vector<Vec3> OnlineOpening::drag_forces(std::span<const Vec3> hook_displacements) const
{
    const State& s = *state_;
    const Eigen::VectorXd f = s.column_forces * s.column_weights(hook_displacements);
    std::vector<Vec3> forces;
    for (std::size_t h = 0; h < hook_displacements.size(); ++h)
        forces.push_back(f.segment<3>(3 * static_cast<Eigen::Index>(h)));
    return forces;
}

OnlineAnswer OnlineOpening::drag_answer()
{
    State& s = *state_;
    if (s.columns.rows() == 0)
        throw InputError("dragging needs prepare_drag() after the last change");
    OnlineAnswer answer;
    answer.message = partly_lost(s.body);
    s.place_hooks(answer, s.column_forces);
    if (answer.status == OnlineStatus::unsupported)
        return answer;
    answer.displacement = drag(answer.hook_displacements);
    answer.hook_forces_N = drag_forces(answer.hook_displacements);
    answer.whole = true;
    answer.residual = s.column_residual;
    answer.reciprocal_condition = s.solver->reciprocal_condition();
    return answer;
}

const std::vector<FacingHooks>& OnlineOpening::facing_hooks() { return state_->facing_hooks(); }

std::vector<VertexId> OnlineOpening::held_vertices() const
{
    std::vector<VertexId> vertices;
    for (const auto& [id, hook] : state_->body.hooks)
        for (const VertexId v : hook.nodes)
            if (!hook.lost.contains(v) && state_->body.is_active(v))
                vertices.push_back(v);
    return vertices;
}

void OnlineOpening::start_rebuild()
{
    state_->start_rebuild(state_->corridor_now(state_->solver->changed_elsewhere()));
}

void OnlineOpening::start_rebuild(std::span<const VertexId> corridor)
{
    std::set<VertexId> wanted = hooked_vertices(state_->body);
    wanted.insert(corridor.begin(), corridor.end());
    std::erase_if(wanted, [&](VertexId v) { return !state_->body.is_active(v); });
    state_->start_rebuild({ wanted.begin(), wanted.end() });
}

bool OnlineOpening::rebuilding() const { return state_->rebuild.has_value(); }

bool OnlineOpening::rebuild_ready() const
{
    return state_->rebuild && state_->rebuild->result.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

bool OnlineOpening::adopt_rebuild()
{
    State& s = *state_;
    if (!s.rebuild)
        return false;
    State::Rebuild rebuild = std::move(*s.rebuild);
    s.rebuild.reset();
    try {
        s.adopt(rebuild.result.get(), std::move(rebuild.reference), std::move(rebuild.load));
    } catch (const SolverError&) { // the body is not supported without its hooks
        return false;
    }
    return true;
}

const OnlineStiffness& OnlineOpening::stiffness() const { return state_->body.K; }
bool OnlineOpening::fixed(VertexId v) const { return state_->body.is_fixed(v); }
std::size_t OnlineOpening::corridor_vertices() const { return state_->solver->corridor_vertices(); }
std::string OnlineOpening::route() const { return state_->solver->route(); }
bool OnlineOpening::is_updated() const { return state_->solver->is_updated(); }
std::size_t OnlineOpening::dropped_vertices() const { return state_->solver->dropped_vertices(); }

std::size_t OnlineOpening::bytes() const
{
    const State& s = *state_;
    return s.body.K.bytes() + s.solver->bytes() + static_cast<std::size_t>(s.columns.size()) * sizeof(double);
}

} // namespace retractor::fem
