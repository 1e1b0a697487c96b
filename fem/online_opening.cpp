#include "fem/online_opening.h"

#include "fem/condensed_body.h"
#include "fem/cut_change.h"
#include "fem/held_pieces.h"
#include "fem/local_system.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"

#include <cblas.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

namespace retractor {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    std::string vertex_name(VertexId v) { return "vertex " + std::to_string(v); }

    bool lives(const OnlineStiffness& K, VertexId v)
    {
        return v >= 0 && static_cast<std::size_t>(v) < K.slot_count() && K.alive(v);
    }

    void check_vertex(const OnlineStiffness& K, VertexId v, const std::string& where)
    {
        if (!lives(K, v))
            throw InputError("there is no such vertex", where + ", " + vertex_name(v));
    }

    struct Field {
        Eigen::MatrixXd displacement; ///< by vertex id, a column per case
        LocalSystem::Solution local;
    };

} // namespace

struct OnlineOpening::State {
    State(const CutSession& session, std::span<const Material> materials, OnlineOptions given)
        : options(std::move(given))
        , K(session, materials, options.stress_of_label)
    {
    }

    OnlineOptions options;
    OnlineStiffness K;
    std::vector<std::uint8_t> fixed; ///< per vertex id
    std::vector<double> bed; ///< per vertex id
    std::unique_ptr<CondensedBody> body;
    Eigen::VectorXd base_load, base_field; ///< loads of the body when it was condensed, and its field under them
    ReferenceRows reference;
    std::set<VertexId> newborn; ///< alive and free, but not in the body
    std::map<HookId, OnlineHook> hooks;
    HookId next_hook = 0;

    // Made when needed, dropped when what they are made of changes.
    std::vector<HeldVertex> held; ///< living nodes of all hooks
    std::optional<HookCompliance> compliance;
    std::optional<CutChange> change;
    std::optional<LocalSystem> local;
    Eigen::MatrixXd columns; ///< drag: by vertex id, three per hook; the last is the field with no hook moved
    Eigen::MatrixXd column_forces; ///< three rows per hook
    Eigen::VectorXd dragged;

    struct Rebuild {
        std::future<std::unique_ptr<CondensedBody>> result;
        ReferenceRows reference; ///< rows touched since it was begun
        Eigen::VectorXd load;
    };
    std::optional<Rebuild> rebuild;

    bool is_fixed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < fixed.size() && fixed[static_cast<std::size_t>(v)] != 0;
    }
    bool is_active(VertexId v) const { return lives(K, v) && !is_fixed(v); }
    bool is_held(VertexId v) const
    {
        return std::any_of(hooks.begin(), hooks.end(), [&](const auto& h) {
            return std::find(h.second.nodes.begin(), h.second.nodes.end(), v) != h.second.nodes.end();
        });
    }

    void mesh_changed()
    {
        change.reset();
        local.reset();
        columns.resize(0, 0);
    }
    void hooks_changed()
    {
        compliance.reset();
        mesh_changed(); // newborn vertices may be held now, or free again
    }

    Eigen::MatrixXd load_or_zero() const { return K.loaded() ? Eigen::MatrixXd(K.load()) : Eigen::MatrixXd(); }

    void adopt(std::unique_ptr<CondensedBody> fresh, ReferenceRows touched, Eigen::VectorXd load)
    {
        body = std::move(fresh);
        reference = std::move(touched);
        base_load = std::move(load);
        base_field = K.loaded() ? body->solve(base_load) : Eigen::VectorXd();
        newborn.clear();
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (is_active(v) && !body->has(v))
                newborn.insert(v);
        hooks_changed();
    }

    /// The corridor that a new factorisation should have: what was kept, touched, born and held.
    std::vector<VertexId> corridor_now(const std::vector<VertexId>& more) const
    {
        std::set<VertexId> corridor(newborn.begin(), newborn.end());
        if (body)
            corridor.insert(body->kept().begin(), body->kept().end());
        corridor.insert(more.begin(), more.end());
        for (const auto& [id, hook] : hooks)
            corridor.insert(hook.nodes.begin(), hook.nodes.end());
        std::erase_if(corridor, [&](VertexId v) { return !is_active(v); });
        return { corridor.begin(), corridor.end() };
    }

    void factor_anew(const std::vector<VertexId>& corridor)
    {
        adopt(std::make_unique<CondensedBody>(K, fixed, corridor), {}, K.load());
    }

    /// Sees that the body keeps these. A new factorisation when they are many; where the body cannot stand without its
    /// hooks, it is the old one all the same.
    void keep(const std::vector<VertexId>& vertices)
    {
        std::vector<VertexId> missing;
        for (const VertexId v : vertices)
            if (body->has(v) && body->place(v) < 0)
                missing.push_back(v);
        if (missing.empty())
            return;
        if (body->added() + missing.size() > options.added_vertices) {
            try {
                return factor_anew(corridor_now(missing));
            } catch (const SolverError&) { // not held without hooks
            }
        }
        body->keep_also(missing);
        hooks_changed();
    }

    /// Living nodes of each hook; @return the name of a hook that has lost its hold.
    std::string gather_held()
    {
        held.clear();
        std::int32_t number = 0;
        for (const auto& [id, hook] : hooks) {
            std::size_t living = 0;
            for (const VertexId v : hook.nodes)
                if (is_active(v)) {
                    held.push_back({ v, number });
                    ++living;
                }
            constexpr std::size_t kPatch = 3;
            if (living < kPatch)
                return hook.name;
            ++number;
        }
        return {};
    }

    TetMesh compact(std::vector<VertexId>& place) const
    {
        TetMesh mesh;
        place.assign(K.slot_count(), -1);
        std::vector<Vec3> points;
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (K.alive(v)) {
                place[static_cast<std::size_t>(v)] = static_cast<VertexId>(points.size());
                points.push_back(K.position(v));
            }
        mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.vertices.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
        std::vector<TetId> tets;
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            for (const TetId t : K.elements_round(v))
                if (K.tet(t)[0] == v)
                    tets.push_back(t);
        for (const TetId t : tets)
            for (const VertexId v : K.tet(t))
                mesh.nodes.push_back(place[static_cast<std::size_t>(v)]);
        mesh.labels.assign(tets.size(), 1);
        return mesh;
    }

    bool has_bed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < bed.size() && bed[static_cast<std::size_t>(v)] > 0.0;
    }

    /// Every vertex is joined, by elements, to one that is fixed, bedded or hooked.
    bool all_joined_to_something() const
    {
        std::vector<std::uint8_t> reached(K.slot_count(), 0);
        std::vector<VertexId> front;
        std::size_t count = 0;
        const auto reach = [&](VertexId v) {
            if (reached[static_cast<std::size_t>(v)] == 0) {
                reached[static_cast<std::size_t>(v)] = 1;
                front.push_back(v);
                ++count;
            }
        };
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (K.alive(v) && (is_fixed(v) || has_bed(v)))
                reach(v);
        for (const HeldVertex& h : held)
            reach(h.vertex);
        while (!front.empty()) {
            const VertexId v = front.back();
            front.pop_back();
            for (const VertexId next : K.row(v).column)
                reach(next);
        }
        return count == K.vertex_count();
    }

    /// Names the piece that is not held, if there is one.
    std::string loose_piece() const
    {
        std::vector<VertexId> place, anchors;
        const TetMesh mesh = compact(place);
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (K.alive(v) && (is_fixed(v) || has_bed(v)))
                anchors.push_back(place[static_cast<std::size_t>(v)]);
        for (const HeldVertex& h : held)
            anchors.push_back(place[static_cast<std::size_t>(h.vertex)]);
        try {
            check_pieces_held(mesh, anchors);
        } catch (const SolverError& error) {
            return std::string(error.what()) + ": " + error.where();
        }
        return {};
    }

    /// Brings the local system up to date. @return why there is no answer; empty when there is.
    std::string prepare()
    {
        if (local)
            return {};
        if (const std::string lost = gather_held(); !lost.empty())
            return "hook '" + lost + "' has lost its hold: fewer than three of its vertices are left";
        if (!all_joined_to_something())
            return loose_piece();
        std::vector<VertexId> needed = changed_but_not_kept(K, *body, reference);
        std::set<VertexId> held_vertices;
        for (const HeldVertex& h : held) {
            needed.push_back(h.vertex);
            held_vertices.insert(h.vertex);
        }
        keep(needed);
        try {
            if (!compliance)
                compliance = make_hook_compliance(*body, held);
            if (!change) {
                std::vector<std::uint8_t> active(K.slot_count(), 0);
                for (VertexId v = 0; v < static_cast<VertexId>(active.size()); ++v)
                    active[static_cast<std::size_t>(v)] = is_active(v) ? 1 : 0;
                change = make_cut_change(K, *body, reference, active, newborn, held_vertices);
            }
            local.emplace(K, *body, *change, *compliance, held);
        } catch (const SolverError& error) {
            const std::string piece = loose_piece();
            if (piece.empty())
                throw;
            return piece;
        }
        constexpr double kSuspicious = 1e-11; // a loose piece leaves round-off here
        if (local->reciprocal_condition() < kSuspicious)
            if (std::string piece = loose_piece(); !piece.empty()) {
                local.reset();
                return piece;
            }
        if (local->reciprocal_condition() == 0.0)
            throw SolverError("the stiffness of the cut body is not positive definite");
        return {};
    }

    Eigen::Index kept_rows() const { return body->stiffness().rows(); }
    Eigen::Index newborn_rows() const { return 3 * static_cast<Eigen::Index>(change->newborn.size()); }

    Eigen::MatrixXd at_kept(const Eigen::VectorXd& by_id) const
    {
        Eigen::MatrixXd kept(kept_rows(), 1);
        Eigen::Index row = 0;
        for (const VertexId v : body->kept()) {
            kept.col(0).segment<3>(row) = by_id.segment<3>(3 * v);
            row += 3;
        }
        return kept;
    }
    Eigen::MatrixXd at_newborn(const Eigen::VectorXd& by_id) const
    {
        Eigen::MatrixXd values(newborn_rows(), 1);
        Eigen::Index row = 0;
        for (const VertexId v : change->newborn) {
            values.col(0).segment<3>(row) = by_id.segment<3>(3 * v);
            row += 3;
        }
        return values;
    }
    Eigen::VectorXd grown(const Eigen::VectorXd& by_id) const
    {
        Eigen::VectorXd v = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()));
        v.head(by_id.size()) = by_id;
        return v;
    }

    /// The loads that the local system sees: those now, less those whose field is added at the end, more what holds
    /// this field back.
    LocalSystem::Solution solve_local(const Eigen::MatrixXd& hook_displacement, bool with_loads) const
    {
        const Eigen::Index cases = hook_displacement.cols();
        Eigen::MatrixXd load = Eigen::MatrixXd::Zero(kept_rows(), cases);
        Eigen::MatrixXd newborn_load = Eigen::MatrixXd::Zero(newborn_rows(), cases);
        if (with_loads && K.loaded()) {
            const Eigen::VectorXd base = grown(base_load), field = grown(base_field);
            const Eigen::MatrixXd kept = at_kept(K.load() - base) + product(body->stiffness(), at_kept(field));
            load.colwise() += kept.col(0);
            newborn_load.colwise() += at_newborn(K.load()).col(0);
            for (const VertexId v : body->kept()) // what is gone carries no load
                if (!is_active(v))
                    load.middleRows(3 * body->place(v), 3).setZero();
        }
        return local->solve(load, newborn_load, hook_displacement);
    }

    void put_local(const LocalSystem::Solution& s, const Eigen::MatrixXd& hook_displacement, Eigen::MatrixXd& x) const
    {
        for (const VertexId v : body->kept())
            if (static_cast<std::size_t>(v) < K.slot_count())
                x.middleRows(3 * v, 3) = s.kept.middleRows(3 * body->place(v), 3);
        for (std::size_t n = 0; n < change->newborn.size(); ++n)
            x.middleRows(3 * change->newborn[n], 3) = s.newborn.middleRows(3 * static_cast<Eigen::Index>(n), 3);
        for (const HeldVertex& h : held)
            x.middleRows(3 * h.vertex, 3) = hook_displacement.middleRows(3 * h.hook, 3);
        for (const VertexId v : body->kept())
            if (!is_active(v))
                x.middleRows(3 * v, 3).setZero();
    }

    /// The local solution by vertex id; elsewhere zero.
    Eigen::MatrixXd near_field(const LocalSystem::Solution& s, const Eigen::MatrixXd& hook_displacement) const
    {
        Eigen::MatrixXd x
            = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()), hook_displacement.cols());
        put_local(s, hook_displacement, x);
        return x;
    }

    /// Three rows per hook: the sum over its vertices. @param near_displacement as near_field() gives it.
    Eigen::MatrixXd forces(
        const LocalSystem::Solution& s, const Eigen::MatrixXd& near_displacement, bool with_loads) const
    {
        Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(hooks.size()), s.kept.cols());
        for (std::size_t i = 0; i < held.size(); ++i) {
            const HeldVertex& h = held[i];
            if (body->place(h.vertex) >= 0) {
                sum.middleRows(3 * h.hook, 3) += s.held_forces.middleRows(3 * static_cast<Eigen::Index>(i), 3);
                continue;
            }
            const OnlineStiffness::Row& row = K.row(h.vertex); // all neighbours of a newborn vertex are near
            for (std::size_t k = 0; k < row.column.size(); ++k)
                sum.middleRows(3 * h.hook, 3)
                    += RowBlock(row.value.data() + 9 * k) * near_displacement.middleRows(3 * row.column[k], 3);
            if (with_loads && K.loaded())
                sum.middleRows(3 * h.hook, 3).colwise() -= Vec3(K.load().segment<3>(3 * h.vertex));
        }
        return sum;
    }

    /// Extends local solutions to the whole body.
    Eigen::MatrixXd whole_field(
        const LocalSystem::Solution& s, const Eigen::MatrixXd& hook_displacement, bool with_loads) const
    {
        Eigen::MatrixXd x;
        if (with_loads && K.loaded()) {
            const Eigen::VectorXd field = grown(base_field);
            x = body->field(s.kept.colwise() - at_kept(field).col(0), K.slot_count());
            x.colwise() += field;
        } else {
            x = body->field(s.kept, K.slot_count());
        }
        put_local(s, hook_displacement, x);
        return x;
    }

    /// Right side of the free unknowns: loads, and what moving the hooks pulls on.
    Eigen::VectorXd right_side(const Eigen::VectorXd& hook_displacement) const
    {
        Eigen::VectorXd b
            = K.loaded() ? K.load() : Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()));
        for (const HeldVertex& h : held) {
            const OnlineStiffness::Row& row = K.row(h.vertex);
            for (std::size_t k = 0; k < row.column.size(); ++k)
                b.segment<3>(3 * row.column[k])
                    -= RowBlock(row.value.data() + 9 * k).transpose() * hook_displacement.segment<3>(3 * h.hook);
        }
        return masked(std::move(b));
    }
    Eigen::VectorXd masked(Eigen::VectorXd b) const
    {
        for (std::size_t v = 0; v < fixed.size(); ++v)
            if (fixed[v] != 0)
                b.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
        for (const HeldVertex& h : held)
            b.segment<3>(3 * h.vertex).setZero();
        return b;
    }
    /// Loads less internal forces, everywhere: what supports and hooks take with the sign turned, elsewhere an error.
    Eigen::VectorXd imbalance(const Eigen::VectorXd& x) const
    {
        Eigen::VectorXd r = -K.multiply(x);
        if (K.loaded())
            r += K.load();
        return r;
    }
    Eigen::VectorXd residual(const Eigen::VectorXd& x) const { return masked(imbalance(x)); }

    std::vector<Vec3> hook_forces(const Eigen::VectorXd& imbalance_of_all) const
    {
        std::vector<Vec3> forces(hooks.size(), Vec3::Zero());
        for (const HeldVertex& h : held)
            forces[static_cast<std::size_t>(h.hook)] -= imbalance_of_all.segment<3>(3 * h.vertex);
        return forces;
    }

    /// Solves for a residual on all free unknowns, the hooks held still.
    Eigen::VectorXd correction(const Eigen::VectorXd& r) const
    {
        Eigen::VectorXd condensed = r;
        for (const VertexId v : body->kept())
            condensed.segment<3>(3 * v).setZero();
        const Eigen::VectorXd field = body->solve(condensed);
        const Eigen::MatrixXd field_kept = at_kept(field);
        Eigen::MatrixXd load = at_kept(r) + product(body->stiffness(), field_kept);
        for (const VertexId v : body->kept())
            if (!is_active(v))
                load.middleRows(3 * body->place(v), 3).setZero();
        const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(hooks.size()), 1);
        const LocalSystem::Solution s = local->solve(load, at_newborn(r), still);
        Eigen::MatrixXd x = body->field(s.kept - field_kept, K.slot_count());
        x.col(0) += field;
        put_local(s, still, x);
        return x.col(0);
    }

    Eigen::MatrixXd stacked(const std::vector<Vec3>& per_hook) const
    {
        Eigen::MatrixXd d(3 * static_cast<Eigen::Index>(per_hook.size()), 1);
        for (std::size_t h = 0; h < per_hook.size(); ++h)
            d.col(0).segment<3>(3 * static_cast<Eigen::Index>(h)) = per_hook[h];
        return d;
    }

    /// A unit displacement per hook and axis, and a last case with none for the loads.
    Eigen::MatrixXd unit_cases() const
    {
        const auto rows = 3 * static_cast<Eigen::Index>(hooks.size());
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rows, rows + (K.loaded() ? 1 : 0));
        unit.leftCols(rows).setIdentity();
        return unit;
    }
    /// Loads act in all cases of unit_cases(): takes the last off the others.
    void without_loads(Eigen::MatrixXd& cases) const
    {
        if (K.loaded())
            for (Eigen::Index c = 0; c + 1 < cases.cols(); ++c)
                cases.col(c) -= cases.rightCols(1);
    }

    /// What the hooks do to the tissue under them.
    void place_hooks(OnlineAnswer& answer) const
    {
        std::vector<HookDrive> drives;
        bool prescribed = true;
        for (const auto& [id, hook] : hooks) {
            answer.hooks.push_back(id);
            drives.push_back(hook.drive);
            prescribed = prescribed && hook.drive.prescribes();
        }
        answer.hook_yielded.assign(drives.size(), false);
        if (prescribed) {
            for (const HookDrive& drive : drives)
                answer.hook_displacements.push_back(drive.displacement);
            return;
        }
        const Eigen::MatrixXd unit = unit_cases();
        const LocalSystem::Solution s = solve_local(unit, true);
        Eigen::MatrixXd R = forces(s, near_field(s, unit), true);
        without_loads(R);
        const Eigen::VectorXd r = K.loaded() ? Eigen::VectorXd(R.rightCols(1)) : Eigen::VectorXd::Zero(R.rows());
        const Eigen::MatrixXd symmetric = 0.5 * (R.leftCols(R.rows()) + R.leftCols(R.rows()).transpose());
        const HookRest rest = rest_of_hooks(symmetric, r, drives);
        if (!rest.converged) {
            answer.status = OnlineStatus::inaccurate;
            answer.message = "the hooks' forces did not come to rest";
        }
        answer.hook_yielded = rest.yielded;
        for (std::size_t h = 0; h < drives.size(); ++h)
            answer.hook_displacements.push_back(rest.displacement.segment<3>(3 * static_cast<Eigen::Index>(h)));
    }
};

OnlineOpening::OnlineOpening(const CutSession& session, std::span<const Material> material_of_label,
    const Supports& supports, std::span<const VertexId> corridor, OnlineOptions options)
{
    state_ = std::make_unique<State>(session, material_of_label, std::move(options));
    State& s = *state_;
    s.fixed.assign(s.K.slot_count(), 0);
    for (const VertexId v : supports.fixed) {
        check_vertex(s.K, v, "supports");
        s.fixed[static_cast<std::size_t>(v)] = 1;
    }
    if (!supports.bedded.empty()) {
        s.bed.assign(s.K.slot_count(), 0.0);
        for (const BeddedVertex& bedded : supports.bedded) {
            check_vertex(s.K, bedded.vertex, "supports");
            s.bed[static_cast<std::size_t>(bedded.vertex)] = bedded.stiffness;
        }
        s.K.set_bed(s.bed);
    }
    for (const VertexId v : corridor)
        if (v < 0)
            throw InputError("there is no such vertex", "corridor, " + vertex_name(v));
    if (!s.all_joined_to_something())
        throw SolverError(s.loose_piece());
    try {
        s.factor_anew(s.corridor_now({ corridor.begin(), corridor.end() }));
    } catch (const SolverError&) {
        if (const std::string piece = s.loose_piece(); !piece.empty())
            throw SolverError(piece);
        throw;
    }
}

OnlineOpening::~OnlineOpening() = default;
OnlineOpening::OnlineOpening(OnlineOpening&&) noexcept = default;

void OnlineOpening::follow(const MeshDelta& delta)
{
    State& s = *state_;
    std::vector<std::pair<VertexId, OnlineStiffness::Row>> before;
    for (const VertexId v : s.K.touched_by(delta))
        before.emplace_back(v, s.K.row(v));
    s.K.apply(delta);
    s.fixed.resize(s.K.slot_count(), 0);
    for (auto& [v, row] : before) {
        if (s.rebuild)
            s.rebuild->reference.try_emplace(v, row);
        s.reference.try_emplace(v, std::move(row));
    }
    for (const MeshDelta::VertexBorn& vertex : delta.vertices_born) {
        s.fixed[static_cast<std::size_t>(vertex.id)] = s.is_fixed(vertex.a) && s.is_fixed(vertex.b) ? 1 : 0;
        if (!s.is_fixed(vertex.id) && !s.body->has(vertex.id))
            s.newborn.insert(vertex.id);
    }
    for (const MeshDelta::VertexBorn& vertex : delta.vertices_gone) {
        s.newborn.erase(vertex.id);
        s.fixed[static_cast<std::size_t>(vertex.id)] = 0;
    }
    s.mesh_changed();
}

HookId OnlineOpening::attach(OnlineHook hook)
{
    State& s = *state_;
    const std::string where = "hook '" + hook.name + "'";
    check_drive(hook.drive, hook.name);
    std::set<VertexId> nodes;
    for (const VertexId v : hook.nodes) {
        check_vertex(s.K, v, where);
        if (s.is_fixed(v))
            throw InputError("a hook holds a vertex that is fixed", where + ", " + vertex_name(v));
        if (s.is_held(v))
            throw InputError("two hooks hold one vertex", where + ", " + vertex_name(v));
        if (!nodes.insert(v).second)
            throw InputError("a hook names a vertex twice", where + ", " + vertex_name(v));
    }
    constexpr std::size_t kPatch = 3;
    if (nodes.size() < kPatch)
        throw InputError("a hook is a patch of three vertices at least, never a point", where);
    const HookId id = s.next_hook++;
    s.hooks.emplace(id, std::move(hook));
    s.hooks_changed();
    return id;
}

void OnlineOpening::detach(HookId hook)
{
    if (state_->hooks.erase(hook) == 0)
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    state_->hooks_changed();
}

void OnlineOpening::drive(HookId hook, const HookDrive& drive)
{
    const auto found = state_->hooks.find(hook);
    if (found == state_->hooks.end())
        throw InputError("there is no such hook", "hook " + std::to_string(hook));
    check_drive(drive, found->second.name);
    found->second.drive = drive;
}

OnlineAnswer OnlineOpening::answer()
{
    State& s = *state_;
    const Stopwatch watch;
    OnlineAnswer answer;
    answer.message = s.prepare();
    if (!answer.message.empty()) {
        answer.status = OnlineStatus::unsupported;
        return answer;
    }
    s.place_hooks(answer);
    const Eigen::MatrixXd d = s.stacked(answer.hook_displacements);
    const LocalSystem::Solution solution = s.solve_local(d, true);
    const Eigen::MatrixXd near = s.near_field(solution, d);
    const Eigen::MatrixXd forces = s.forces(solution, near, true);
    for (std::size_t h = 0; h < answer.hooks.size(); ++h)
        answer.hook_forces_N.push_back(forces.col(0).segment<3>(3 * static_cast<Eigen::Index>(h)));
    answer.displacement = near.col(0);
    answer.reciprocal_condition = s.local->reciprocal_condition();
    answer.corridor_seconds = watch.seconds();
    return answer;
}

void OnlineOpening::complete(OnlineAnswer& answer)
{
    State& s = *state_;
    if (answer.status == OnlineStatus::unsupported)
        return;
    if (!s.local || answer.displacement.size() != 3 * static_cast<Eigen::Index>(s.K.slot_count()))
        throw InputError("the answer is of an earlier state: ask for another");
    const Stopwatch watch;
    const Eigen::MatrixXd d = s.stacked(answer.hook_displacements);
    LocalSystem::Solution near;
    near.kept = s.at_kept(answer.displacement);
    near.newborn = s.at_newborn(answer.displacement);
    answer.displacement = s.whole_field(near, d, true).col(0);
    answer.whole = true;
    const double load = s.right_side(d.col(0)).norm();
    Eigen::VectorXd all = s.imbalance(answer.displacement);
    Eigen::VectorXd r = s.masked(all);
    const auto relative = [&] { return load > 0.0 ? r.norm() / load : r.norm(); };
    answer.residual = relative();
    constexpr int kRefinements = 10; // each takes off several digits, or the factor is of no use
    while (answer.residual > s.options.residual && answer.refinements < kRefinements) {
        const Eigen::VectorXd refined = answer.displacement + s.correction(r);
        const Eigen::VectorXd all_refined = s.imbalance(refined);
        r = s.masked(all_refined);
        const double was = std::exchange(answer.residual, relative());
        ++answer.refinements;
        if (!(answer.residual < was)) {
            answer.residual = was;
            break;
        }
        answer.displacement = refined;
        all = all_refined;
    }
    answer.hook_forces_N = s.hook_forces(all);
    if (!(answer.residual <= s.options.residual)) {
        std::ostringstream text;
        text << "the residual stays at " << answer.residual << ", asked for " << s.options.residual;
        answer.status = OnlineStatus::inaccurate;
        answer.message = text.str();
    }
    answer.whole_seconds = watch.seconds();
}

double OnlineOpening::prepare_drag()
{
    State& s = *state_;
    if (const std::string refused = s.prepare(); !refused.empty())
        throw SolverError(refused);
    const Eigen::MatrixXd unit = s.unit_cases();
    const LocalSystem::Solution local = s.solve_local(unit, true);
    s.columns = s.whole_field(local, unit, true);
    s.column_forces = s.forces(local, s.near_field(local, unit), true);
    double worst = 0.0;
    for (Eigen::Index c = 0; c < unit.cols(); ++c) {
        const double load = s.right_side(unit.col(c)).norm();
        if (load > 0.0)
            worst = std::max(worst, s.residual(s.columns.col(c)).norm() / load);
    }
    s.without_loads(s.columns);
    s.without_loads(s.column_forces);
    s.dragged.resize(s.columns.rows());
    return worst;
}

const Eigen::VectorXd& OnlineOpening::drag(std::span<const Vec3> hook_displacements)
{
    State& s = *state_;
    const auto moved = 3 * static_cast<Eigen::Index>(hook_displacements.size());
    if (s.columns.rows() == 0 || hook_displacements.size() != s.hooks.size())
        throw InputError("dragging needs prepare_drag() after the last change, and one displacement per hook");
    Eigen::VectorXd d = Eigen::VectorXd::Ones(s.columns.cols());
    for (std::size_t h = 0; h < hook_displacements.size(); ++h)
        d.segment<3>(3 * static_cast<Eigen::Index>(h)) = hook_displacements[h];
    if (moved == 0 && s.columns.cols() == 0) {
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
    if (s.columns.rows() == 0 || hook_displacements.size() != s.hooks.size())
        throw InputError("dragging needs prepare_drag() after the last change, and one displacement per hook");
    Eigen::VectorXd d = Eigen::VectorXd::Ones(s.column_forces.cols());
    for (std::size_t h = 0; h < hook_displacements.size(); ++h)
        d.segment<3>(3 * static_cast<Eigen::Index>(h)) = hook_displacements[h];
    const Eigen::VectorXd f = s.column_forces * d;
    std::vector<Vec3> forces;
    for (std::size_t h = 0; h < hook_displacements.size(); ++h)
        forces.push_back(f.segment<3>(3 * static_cast<Eigen::Index>(h)));
    return forces;
}

void OnlineOpening::start_rebuild()
{
    State& s = *state_;
    s.rebuild.reset();
    s.rebuild.emplace();
    s.rebuild->load = s.K.load();
    s.rebuild->result = std::async(std::launch::async,
        [K = s.K, fixed = s.fixed, corridor = s.corridor_now(changed_but_not_kept(s.K, *s.body, s.reference))] {
            return std::make_unique<CondensedBody>(K, fixed, corridor);
        });
}

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
    } catch (const SolverError&) { // the body does not stand without its hooks
        return false;
    }
    return true;
}

const OnlineStiffness& OnlineOpening::stiffness() const { return state_->K; }
std::size_t OnlineOpening::corridor_vertices() const { return state_->body->kept().size(); }
std::string OnlineOpening::route() const
{
    return !state_->local ? "none" : state_->local->route() == LocalRoute::low_rank ? "low rank" : "dense";
}
double OnlineOpening::factor_entries() const { return state_->body->factor_entries(); }

std::size_t OnlineOpening::bytes() const
{
    const State& s = *state_;
    std::size_t sum = s.K.bytes() + s.body->bytes();
    const auto add = [&](const Eigen::MatrixXd& a) { sum += static_cast<std::size_t>(a.size()) * sizeof(double); };
    add(s.columns);
    if (s.compliance)
        add(s.compliance->columns);
    if (s.change) {
        add(s.change->stiffness);
        add(s.change->newborn_by_beside);
        add(s.change->coupling);
        sum += s.change->newborn_factor.bytes();
    }
    if (s.local)
        sum += s.local->bytes();
    return sum;
}

} // namespace retractor
