#include "fem/interactive/schur_wound_solver.h"

#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/assert.h"

#include <algorithm>
#include <utility>

namespace retractor::fem {

namespace {

    Vec3 segment_or_zero(const Eigen::VectorXd& by_id, VertexId v)
    {
        return 3 * static_cast<Eigen::Index>(v) < by_id.size() ? Vec3(by_id.segment<3>(3 * v)) : Vec3(Vec3::Zero());
    }

    Eigen::MatrixXd at(const std::vector<VertexId>& vertices, const Eigen::MatrixXd& by_id)
    {
        Eigen::MatrixXd values(3 * static_cast<Eigen::Index>(vertices.size()), by_id.cols());
        for (std::size_t i = 0; i < vertices.size(); ++i)
            values.middleRows(3 * static_cast<Eigen::Index>(i), 3) = by_id.middleRows(3 * vertices[i], 3);
        return values;
    }

    Eigen::Index rows_of(std::size_t vertices) { return 3 * static_cast<Eigen::Index>(vertices); }

    /// Removes the loads on vertices that are gone.
    void clear_inactive(const OnlineBody& body, const std::vector<VertexId>& vertices, Eigen::MatrixXd& load)
    {
        for (std::size_t i = 0; i < vertices.size(); ++i)
            if (!body.is_active(vertices[i]))
                load.middleRows(rows_of(i), 3).setZero();
    }

    void put(const OnlineBody& body, const std::vector<VertexId>& vertices, const Eigen::MatrixXd& values,
        Eigen::MatrixXd& by_id)
    {
        for (std::size_t i = 0; i < vertices.size(); ++i)
            if (body.is_active(vertices[i]))
                by_id.middleRows(3 * vertices[i], 3) = values.middleRows(rows_of(i), 3);
    }

} // namespace

SchurWoundSolver::SchurWoundSolver(const OnlineBody& body, std::unique_ptr<CondensedBody> condensed,
    ReferenceRows touched, Eigen::VectorXd load, const OnlineOptions& options)
    : body_(body)
    , options_(options)
    , condensed_(std::move(condensed))
    , base_load_(std::move(load))
    , base_(condensed_state_of(*condensed_))
{
    base_.reference = std::move(touched);
    if (body_.K.loaded())
        base_field_ = condensed_->solve(base_load_);
    for (VertexId v = 0; v < static_cast<VertexId>(body_.K.slot_count()); ++v)
        if (body_.is_active(v) && !condensed_->has(v))
            added_.insert(v);
}

// ---- Following a delta ----

void SchurWoundSolver::before_delta()
{
    if (pending_update_ && --pending_update_->deltas_left <= 0)
        swap_updated_in();
    if (is_update_worthwhile())
        start_update();
}

/// Once the local system has the size of several steps, its state becomes an updated state for later systems.
bool SchurWoundSolver::is_update_worthwhile() const
{
    if (pending_update_ || !local_ || local_->route() != LocalRoute::low_rank
        || change_->changed.size() < options_.update_vertices)
        return false;
    const std::set<VertexId> hooked = hooked_vertices(body_);
    // False when a hook holds a vertex that the state does not have yet.
    return std::none_of(
        hooked.begin(), hooked.end(), [&](VertexId v) { return body_.is_active(v) && !state_->has(v); });
}

void SchurWoundSolver::start_update()
{
    auto source = std::make_shared<const UpdateSource>(
        update_source(*state_, *change_, body_.K, hooked_vertices(body_), leaving_));
    local_.reset(); // local_ refers to the change, whose work space the update uses up
    auto taken = std::make_shared<const CutChange>(std::move(*change_));
    change_.reset();
    pending_update_.emplace();
    pending_update_->source = source;
    pending_update_->deltas_left = options_.update_deltas;
    pending_update_->result = std::async(options_.update_deltas > 0 ? std::launch::async : std::launch::deferred,
        [source, taken] { return apply_update(*source, *taken); });
    if (options_.update_deltas <= 0)
        swap_updated_in();
}

void SchurWoundSolver::swap_updated_in()
{
    PendingUpdate done = std::move(*pending_update_);
    pending_update_.reset();
    drop_updated();
    updated_ = done.result.get();
    updated_->reference = std::move(done.reference);
    for (const AddedVertices& added : done.added)
        keep_also(*updated_, added);
}

void SchurWoundSolver::drop_updated_state()
{
    updated_compliance_.reset();
    updated_.reset();
}

void SchurWoundSolver::drop_updated()
{
    drop_answer();
    drop_updated_state();
}

void SchurWoundSolver::row_touched(VertexId v, const OnlineStiffness::Row& before)
{
    if (updated_)
        updated_->reference.try_emplace(v, before);
    if (pending_update_)
        pending_update_->reference.try_emplace(v, before);
    base_.reference.try_emplace(v, before);
}

void SchurWoundSolver::vertex_born(VertexId v)
{
    if (updated_ && updated_->has(v))
        drop_updated(); // an id that lives again belongs to another vertex
    if (pending_update_ && pending_update_->source->has(v))
        pending_update_.reset();
    if (!body_.is_fixed(v) && !condensed_->has(v))
        added_.insert(v);
}

void SchurWoundSolver::hooks_changed()
{
    base_compliance_.reset();
    updated_compliance_.reset();
    drop_answer(); // added vertices may have become held or free
}

void SchurWoundSolver::drop_answer()
{
    change_.reset();
    local_.reset();
}

bool SchurWoundSolver::take_appended(HookId hook)
{
    const std::vector<VertexId>& nodes = body_.hooks.at(hook).nodes;
    if (!local_ || local_->route() != LocalRoute::dense
        || !std::all_of(nodes.begin(), nodes.end(), [&](VertexId v) { return state_->place(v) >= 0; }))
        return false;
    local_->hold_appended(); // the factor stays, because it is the most expensive part
    return true;
}

// ---- Retained vertices ----

std::vector<VertexId> SchurWoundSolver::corridor() const
{
    std::vector<VertexId> vertices(added_.begin(), added_.end());
    vertices.insert(vertices.end(), condensed_->kept().begin(), condensed_->kept().end());
    return vertices;
}

std::vector<VertexId> SchurWoundSolver::changed_elsewhere() const
{
    const OnlineStiffness& K = body_.K;
    std::vector<VertexId> found;
    for (const auto& [v, row] : base_.reference)
        if (condensed_->has(v) && condensed_->place(v) < 0
            && (!(K.row(v) == row) || (K.loaded() && K.load().segment<3>(3 * v) != segment_or_zero(base_load_, v))))
            found.push_back(v);
    return found;
}

std::vector<VertexId> SchurWoundSolver::missing_of(const std::vector<VertexId>& vertices) const
{
    std::vector<VertexId> missing;
    for (const VertexId v : vertices)
        if (condensed_->has(v) && condensed_->place(v) < 0)
            missing.push_back(v);
    return missing;
}

bool SchurWoundSolver::outgrown(const std::vector<VertexId>& needed) const
{
    const std::size_t missing = missing_of(needed).size();
    return missing > 0 && condensed_->added() + missing > options_.added_vertices;
}

void SchurWoundSolver::keep_also_here(const std::vector<VertexId>& missing)
{
    if (missing.empty())
        return;
    if ((pending_update_ && pending_update_->source->origin) || (updated_ && updated_->origin)) {
        leaving_ = false; // this stroke goes outside the corridor, so that the next step would need the same again
        pending_update_.reset();
        drop_updated();
    }
    const AddedVertices added = condensed_->keep_also(missing);
    for (const VertexId v : added.vertices)
        base_.keep(v);
    if (updated_)
        keep_also(*updated_, added);
    if (pending_update_)
        pending_update_->added.push_back(added);
    hooks_changed();
}

bool SchurWoundSolver::changed_since(const CondensedState& state, VertexId v) const
{
    const auto was = state.reference.find(v);
    return was != state.reference.end() && !(body_.K.row(v) == was->second);
}

/// The eliminated vertices that a cut or a hook touches again.
std::vector<VertexId> SchurWoundSolver::wanted_back() const
{
    const std::set<VertexId> held = held_vertices(body_);
    std::vector<VertexId> wanted;
    for (const VertexId v : updated_->eliminated_added.vertices)
        if (held.contains(v) || changed_since(*updated_, v))
            wanted.push_back(v);
    return wanted;
}

/// Whether the updated state is still valid: once vertices were dropped, no dropped or eliminated vertex may be touched
/// or held.
bool SchurWoundSolver::updated_state_holds() const
{
    if (updated_->dropped.empty())
        return true;
    const std::set<VertexId> held = held_vertices(body_);
    return wanted_back().empty() && std::none_of(updated_->dropped.begin(), updated_->dropped.end(), [&](VertexId v) {
        return held.contains(v) || changed_since(*updated_, v);
    });
}

// ---- The local system ----

void SchurWoundSolver::prepare(const std::vector<VertexId>& needed)
{
    keep_also_here(missing_of(needed));
    make_local();
}

/// The updated state where it costs less than the other routes, else the body as it was condensed. Drops an updated
/// state that is no longer valid.
const CondensedState& SchurWoundSolver::cheapest_state(double work_from_base)
{
    if (updated_ && !updated_state_holds())
        drop_updated_state();
    if (!updated_)
        return base_;
    fetch_back(*updated_, body_.K, wanted_back());
    const double from_updated = low_rank_work(changed_vertices(body_.K, *updated_).size(), body_.held.size());
    return from_updated < work_from_base ? *updated_ : base_;
}

HookCompliance& SchurWoundSolver::compliance_of_hooks()
{
    std::optional<HookCompliance>& compliance = state_ == &base_ ? base_compliance_ : updated_compliance_;
    std::size_t held_rows = 0;
    for (const HeldVertex& h : body_.held)
        held_rows += state_->place(h.vertex) >= 0 ? 3 : 0;
    if (!compliance || compliance->columns.rows() != state_->compliance().rows()
        || compliance->rows.size() != held_rows) // a hook was attached to the present factor
        compliance = make_hook_compliance(*state_, body_.held);
    return *compliance;
}

/// Sets up the local system against the cheaper state, by the cheaper route.
void SchurWoundSolver::make_local()
{
    const auto held = static_cast<std::size_t>(std::count_if(
        body_.held.begin(), body_.held.end(), [&](const HeldVertex& h) { return condensed_->place(h.vertex) >= 0; }));
    const double low_rank = low_rank_work(changed_vertices(body_.K, base_).size(), held),
                 dense = dense_work(condensed_->kept().size(), held);
    state_ = &cheapest_state(std::min(low_rank, dense));
    const bool by_dense = state_ == &base_ && dense < low_rank;
    std::set<VertexId> fresh;
    for (const VertexId v : added_)
        if (!state_->has(v))
            fresh.insert(v);
    change_ = make_cut_change(body_.K, *state_, active_vertices(body_), fresh, held_vertices(body_));
    if (state_ == &base_)
        drop_updated_state();
    if (by_dense) {
        local_.emplace(body_.K, *state_, *change_, condensed_->stiffness(), body_.held);
        return;
    }
    change_->stiffness = changed_stiffness(*change_);
    local_.emplace(body_.K, *state_, *change_, compliance_of_hooks(), body_.held);
}

std::string SchurWoundSolver::route() const
{
    return !local_ ? "none" : local_->route() == LocalRoute::low_rank ? "low rank" : "dense";
}

// ---- Answers ----

Eigen::VectorXd SchurWoundSolver::grown(const Eigen::VectorXd& by_id) const
{
    RETRACTOR_ASSERT(by_id.size() <= rows_of(body_.K.slot_count()));
    Eigen::VectorXd v = Eigen::VectorXd::Zero(rows_of(body_.K.slot_count()));
    v.head(by_id.size()) = by_id;
    return v;
}

/// Solves near the wound. The near loads are the present loads, less the loads whose field is added at the end, plus
/// the forces that hold this field at the retained vertices.
NearAnswer SchurWoundSolver::solve(const Eigen::MatrixXd& hook_displacement) const
{
    if (!body_.K.loaded())
        return solve_under({}, hook_displacement);
    return solve_under(held_back(body_.K.load() - grown(base_load_), grown(base_field_)), hook_displacement);
}

Eigen::MatrixXd SchurWoundSolver::whole_field(const Eigen::MatrixXd& near) const
{
    return extended(near, body_.K.loaded() ? grown(base_field_) : Eigen::VectorXd());
}

Eigen::VectorXd SchurWoundSolver::held_back(Eigen::VectorXd load, const Eigen::VectorXd& field) const
{
    const Eigen::MatrixXd forces = product(condensed_->stiffness(), at(condensed_->kept(), field));
    for (std::size_t i = 0; i < condensed_->kept().size(); ++i)
        load.segment<3>(3 * condensed_->kept()[i]) += forces.col(0).segment<3>(rows_of(i));
    return load;
}

/// Extends displacements near the wound to the whole body.
/// @param field field of the loads that were subtracted; empty: none
Eigen::MatrixXd SchurWoundSolver::extended(const Eigen::MatrixXd& near, const Eigen::VectorXd& field) const
{
    Eigen::MatrixXd kept = at(condensed_->kept(), near);
    if (field.size() != 0)
        kept.colwise() -= at(condensed_->kept(), field).col(0);
    Eigen::MatrixXd x = condensed_->field(kept, body_.K.slot_count());
    if (field.size() != 0)
        x.colwise() += field;
    for (const VertexId v : condensed_->kept())
        x.middleRows(3 * v, 3) = near.middleRows(3 * v, 3);
    for (const VertexId v : added_)
        x.middleRows(3 * v, 3) = near.middleRows(3 * v, 3);
    return x;
}

/// Corrects only the near part of the residual where the eliminated vertices have almost none of it, as after answers.
/// This costs a fifth of a full correction.
Eigen::VectorXd SchurWoundSolver::correction(const Eigen::VectorXd& residual) const
{
    const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(rows_of(body_.hooks.size()), 1);
    constexpr double kNextToNone = 1e-2;
    Eigen::VectorXd away = residual;
    for (const VertexId v : condensed_->kept())
        away.segment<3>(3 * v).setZero();
    for (const VertexId v : added_)
        away.segment<3>(3 * v).setZero();
    if (away.norm() <= kNextToNone * residual.norm())
        return extended(solve_under(residual - away, still).displacement, {}).col(0);
    const Eigen::VectorXd field = condensed_->solve(away);
    return extended(solve_under(held_back(residual, field), still).displacement, field).col(0);
}

/// @param load by vertex id, the same in all cases, on vertices near the wound; empty: none
NearAnswer SchurWoundSolver::solve_under(const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const
{
    RETRACTOR_ASSERT(ready());
    RETRACTOR_ASSERT(hook_displacement.rows() == rows_of(body_.hooks.size()));
    const Eigen::Index cases = hook_displacement.cols();
    const NearLoads loads = near_loads(load, cases);
    const LocalSystem::Solution solution = local_->solve(
        loads.kept, loads.added, hook_displacement, loads.on_dropped ? loads.on_dropped->response : Eigen::MatrixXd());
    NearAnswer near { Eigen::MatrixXd::Zero(rows_of(body_.K.slot_count()), cases), {} };
    Eigen::MatrixXd& x = near.displacement;
    put(body_, state_->vertices, solution.kept, x);
    put(body_, change_->added, solution.added, x);
    find_dropped(solution.kept_forces, loads, x);
    for (const HeldVertex& h : body_.held)
        x.middleRows(3 * h.vertex, 3) = hook_displacement.middleRows(3 * h.hook, 3);
    find_eliminated_added(load, x);
    near.hook_forces = forces_of_hooks(solution, load, x);
    return near;
}

/// Condenses the loads on eliminated added vertices onto their neighbours.
Eigen::VectorXd SchurWoundSolver::felt_beside_eliminated_added(const Eigen::VectorXd& load) const
{
    Eigen::VectorXd felt = load;
    const EliminatedAdded& eliminated_added = state_->eliminated_added;
    if (eliminated_added.vertices.empty())
        return felt;
    const Eigen::MatrixXd alone = eliminated_added.factor.solve(at(eliminated_added.vertices, load));
    for (std::size_t z = 0; z < eliminated_added.vertices.size(); ++z)
        for_blocks(body_.K, eliminated_added.vertices[z], [&](VertexId v, const auto& block) {
            felt.segment<3>(3 * v) -= block.transpose() * alone.col(0).segment<3>(rows_of(z));
        });
    return felt;
}

SchurWoundSolver::NearLoads SchurWoundSolver::near_loads(const Eigen::VectorXd& load, Eigen::Index cases) const
{
    NearLoads loads { Eigen::MatrixXd::Zero(rows_of(state_->vertices.size()), cases),
        Eigen::MatrixXd::Zero(rows_of(change_->added.size()), cases), {} };
    if (load.size() == 0)
        return loads;
    const Eigen::VectorXd felt = felt_beside_eliminated_added(load);
    loads.kept.colwise() += at(state_->vertices, felt).col(0);
    clear_inactive(body_, state_->vertices, loads.kept);
    loads.added.colwise() += at(change_->added, felt).col(0);
    if (!state_->dropped.empty()) {
        Eigen::MatrixXd on_dropped = at(condensed_->kept(), felt);
        clear_inactive(body_, condensed_->kept(), on_dropped);
        loads.on_dropped = state_->load_on_dropped(*condensed_, Eigen::MatrixXd(on_dropped.replicate(1, cases)));
    }
    return loads;
}

/// Sets the displacements of dropped vertices.
void SchurWoundSolver::find_dropped(
    const Eigen::MatrixXd& kept_forces, const NearLoads& loads, Eigen::MatrixXd& x) const
{
    if (state_->dropped.empty())
        return;
    const Eigen::MatrixXd of_body = state_->carried_back(kept_forces, loads.on_dropped ? &*loads.on_dropped : nullptr);
    for (const VertexId v : state_->dropped)
        x.middleRows(3 * v, 3) = of_body.middleRows(3 * condensed_->place(v), 3);
}

/// Sets the displacements of eliminated added vertices.
/// @param x has the displacements of all other vertices near the wound
void SchurWoundSolver::find_eliminated_added(const Eigen::VectorXd& load, Eigen::MatrixXd& x) const
{
    const EliminatedAdded& eliminated_added = state_->eliminated_added;
    if (eliminated_added.vertices.empty())
        return;
    Eigen::MatrixXd pull = load.size() != 0
        ? Eigen::MatrixXd(at(eliminated_added.vertices, load).replicate(1, x.cols()))
        : Eigen::MatrixXd::Zero(rows_of(eliminated_added.vertices.size()), x.cols());
    for (std::size_t z = 0; z < eliminated_added.vertices.size(); ++z)
        for_blocks(body_.K, eliminated_added.vertices[z], [&](VertexId v, const auto& block) {
            if (!eliminated_added.place.contains(v))
                pull.middleRows(rows_of(z), 3) -= block * x.middleRows(3 * v, 3);
        });
    put(body_, eliminated_added.vertices, eliminated_added.factor.solve(pull), x);
}

Eigen::MatrixXd SchurWoundSolver::forces_of_hooks(
    const LocalSystem::Solution& solution, const Eigen::VectorXd& load, const Eigen::MatrixXd& x) const
{
    Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(rows_of(body_.hooks.size()), x.cols());
    for (std::size_t i = 0; i < body_.held.size(); ++i) {
        const HeldVertex& h = body_.held[i];
        auto sum = forces.middleRows(3 * h.hook, 3);
        if (state_->place(h.vertex) >= 0) {
            sum += solution.held_forces.middleRows(rows_of(i), 3);
            continue;
        }
        for_blocks(body_.K, h.vertex, // all neighbours of an added vertex are near
            [&](VertexId v, const auto& block) { sum += block * x.middleRows(3 * v, 3); });
        if (load.size() != 0)
            sum.colwise() -= Vec3(load.segment<3>(3 * h.vertex));
    }
    return forces;
}

std::size_t SchurWoundSolver::bytes() const
{
    std::size_t sum = condensed_->bytes();
    const auto add = [&](const Eigen::MatrixXd& a) { sum += static_cast<std::size_t>(a.size()) * sizeof(double); };
    for (const auto* compliance : { &base_compliance_, &updated_compliance_ })
        if (*compliance)
            add((*compliance)->columns);
    if (updated_) {
        add(updated_->compliance());
        sum += updated_->eliminated_added.factor.bytes() + updated_->step_bytes();
    }
    if (pending_update_) // upper bound of the state that the update makes
        add(*pending_update_->source->compliance);
    if (change_) {
        add(change_->stiffness);
        add(change_->taken);
        sum += change_->blocks.size() * sizeof(CutChange::Block);
        sum += change_->condensing.bytes();
    }
    if (local_)
        sum += local_->bytes();
    return sum;
}

} // namespace retractor::fem
