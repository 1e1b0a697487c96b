#include "fem/online_opening.h"

#include "fem/condensed_body.h"
#include "fem/cut_change.h"
#include "fem/dense_algebra.h"
#include "fem/held_pieces.h"
#include "fem/kept_view.h"
#include "fem/local_system.h"
#include "mesh/ablated_values.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"

#include <cblas.h>
#include <malloc.h>

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

    /// With those of its vertices that are gone: where they were. A vertex that comes back to the very place is the
    /// same.
    struct AttachedHook : OnlineHook {
        std::map<VertexId, Vec3> lost {};

        bool holds(VertexId v) const
        {
            return std::find(nodes.begin(), nodes.end(), v) != nodes.end() && !lost.contains(v);
        }
    };

} // namespace

struct OnlineOpening::State {
    State(const CutSession& session, std::span<const Material> materials, OnlineOptions given)
        : options(std::move(given))
        , K(session, materials, options.stress_of_element)
    {
    }

    OnlineOptions options;
    OnlineStiffness K;
    std::vector<std::uint8_t> fixed; ///< per vertex id
    AblatedValues<std::uint8_t> ablated_fixed;
    std::unique_ptr<CondensedBody> body; ///< or
    std::unique_ptr<DissectedBody> parts;
    bool parts_ready = false; ///< they are up to date
    Eigen::VectorXd base_load, base_field; ///< loads of the body when it was condensed, and its field under them
    KeptView base; ///< of the body
    bool leaving = true; ///< vertices behind the knife may leave the folded state
    std::optional<KeptView> folded; ///< what a stroke has changed so far is in it
    std::set<VertexId> newborn; ///< alive and free, but not in the body
    std::map<HookId, AttachedHook> hooks;
    HookId next_hook = 0;

    // Made when needed, dropped when what they are made of changes.
    std::vector<HeldVertex> held; ///< living nodes of all hooks
    std::optional<HookId> lost_hook; ///< why there is no answer
    std::optional<HookCompliance> base_compliance, folded_compliance;
    const KeptView* view = nullptr; ///< that the next two are set up against
    std::optional<CutChange> change;
    std::optional<LocalSystem> local;
    Eigen::MatrixXd columns; ///< drag: by vertex id, three per hook; the last is the field with no hook moved
    Eigen::MatrixXd column_forces; ///< three rows per hook
    double column_residual = 0.0; ///< the worst
    Eigen::VectorXd dragged;

    /// One of the two.
    struct Factored {
        std::unique_ptr<CondensedBody> body;
        std::unique_ptr<DissectedBody> parts;
    };
    struct Rebuild {
        std::future<Factored> result;
        ReferenceRows reference; ///< rows touched since it was begun
        Eigen::VectorXd load;
    };
    std::optional<Rebuild> rebuild;

    struct Folding {
        std::shared_ptr<const FoldSource> source;
        std::future<KeptView> result;
        ReferenceRows reference; ///< rows touched since it was begun
        std::vector<AddedVertices> added; ///< kept in addition since
        int deltas_left = 0;
    };
    std::optional<Folding> folding;

    bool is_fixed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < fixed.size() && fixed[static_cast<std::size_t>(v)] != 0;
    }
    bool is_active(VertexId v) const { return lives(K, v) && !is_fixed(v); }
    bool is_held(VertexId v) const
    {
        return std::any_of(hooks.begin(), hooks.end(), [&](const auto& h) { return h.second.holds(v); });
    }

    void mesh_changed()
    {
        parts_ready = false;
        change.reset();
        local.reset();
        columns.resize(0, 0);
    }
    void hooks_changed()
    {
        base_compliance.reset();
        folded_compliance.reset();
        mesh_changed(); // newborn vertices may be held now, or free again
    }
    void drop_folded_state()
    {
        folded_compliance.reset();
        folded.reset();
    }
    void drop_folded()
    {
        mesh_changed();
        drop_folded_state();
    }

    /// Vertices whose displacement a hook gives.
    std::set<VertexId> hooked() const
    {
        std::set<VertexId> vertices;
        for (const auto& [id, hook] : hooks)
            for (const VertexId v : hook.nodes)
                if (!hook.lost.contains(v))
                    vertices.insert(v);
        return vertices;
    }

    /// What hooks lose and get back.
    void carry_hooks(const MeshDelta& delta)
    {
        bool changed = false;
        for (auto& [id, hook] : hooks) {
            for (const MeshDelta::VertexBorn& born : delta.vertices_born)
                if (const auto lost = hook.lost.find(born.id);
                    lost != hook.lost.end() && lost->second == born.position) {
                    hook.lost.erase(lost);
                    changed = true;
                }
            for (const MeshDelta::VertexBorn& gone : delta.vertices_gone)
                if (hook.holds(gone.id)) {
                    hook.lost.emplace(gone.id, gone.position);
                    changed = true;
                }
        }
        if (changed)
            hooks_changed();
    }
    /// Names the hooks that hold less than they did.
    std::string partly_lost() const
    {
        std::string text;
        for (const auto& [id, hook] : hooks)
            if (!hook.lost.empty())
                text += (text.empty() ? "hook '" : "; hook '") + hook.name + "' holds "
                    + std::to_string(hook.nodes.size() - hook.lost.size()) + " of its "
                    + std::to_string(hook.nodes.size()) + " vertices: the others are gone";
        return text;
    }

    /// Before the mesh moves on: once the local system has grown to several steps' size, what it stands for becomes a
    /// state for later ones to be set up against.
    void fold_when_worth_it()
    {
        if (folding && --folding->deltas_left <= 0)
            swap_folded_in();
        if (folding || !local || local->route() != LocalRoute::low_rank
            || change->changed.size() < options.fold_vertices)
            return;
        const std::set<VertexId> hooked_now = hooked();
        if (std::any_of(
                hooked_now.begin(), hooked_now.end(), [&](VertexId v) { return is_active(v) && !view->has(v); }))
            return; // a hook on a lip that is not in the view yet
        auto source = std::make_shared<const FoldSource>(fold_source(*view, *change, K, hooked_now, leaving));
        local.reset(); // it refers to the change, which the fold uses up
        auto taken = std::make_shared<const CutChange>(std::move(*change));
        change.reset();
        folding.emplace();
        folding->source = source;
        folding->deltas_left = options.fold_deltas;
        folding->result = std::async(options.fold_deltas > 0 ? std::launch::async : std::launch::deferred,
            [source, taken] { return fold(*source, *taken); });
        if (options.fold_deltas <= 0)
            swap_folded_in();
    }

    void swap_folded_in()
    {
        Folding done = std::move(*folding);
        folding.reset();
        drop_folded();
        folded = done.result.get();
        folded->reference = std::move(done.reference);
        for (const AddedVertices& added : done.added)
            keep_also(*folded, added);
    }

    void adopt(Factored fresh, ReferenceRows touched, Eigen::VectorXd load)
    {
        folding.reset();
        drop_folded();
        body = std::move(fresh.body);
        parts = std::move(fresh.parts);
        if (parts) {
            base = KeptView();
            base_load.resize(0);
            base_field.resize(0);
            newborn.clear();
            for (const auto& [v, row] : touched)
                parts->touch(v, row);
            for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
                if (is_active(v) && !parts->has(v))
                    parts->touch(v, {});
            hooks_changed();
            return;
        }
        leaving = true;
        base = view_of(*body);
        base.reference = std::move(touched);
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
        if (parts) {
            const std::vector<VertexId> open = parts->open_vertices();
            corridor.insert(open.begin(), open.end());
        }
        corridor.insert(more.begin(), more.end());
        corridor.merge(hooked());
        std::erase_if(corridor, [&](VertexId v) { return !is_active(v); });
        return { corridor.begin(), corridor.end() };
    }

    static Factored factored(const OnlineStiffness& K, const std::vector<std::uint8_t>& fixed,
        const std::vector<VertexId>& corridor, const OnlineOptions& options)
    {
        constexpr double kWorthAsking = 3e9; // multiplications: less is done in the time of an answer
        // Against a dense system that, with the newborn condensed onto it, takes about twice its factor's work.
        constexpr double kDenseExtra = 2.0;
        // Products of large dense matrices are the fastest work there is, and a hook costs them nothing: measured, at
        // 0.7 of the work (a box of 67,000 elements) parts answer later, at 0.14 (a graded chest wall) three times
        // sooner.
        constexpr double kMuchLess = 0.4;
        const double dense = kDenseExtra * dense_work(corridor.size(), 0);
        if (options.body == BodyKept::dissected || (options.body == BodyKept::by_cost && dense > kWorthAsking)) {
            const Dissection dissection = dissect(K, fixed, corridor, options.part_vertices);
            if (options.body == BodyKept::dissected || dissection.work < kMuchLess * dense)
                return { nullptr, std::make_unique<DissectedBody>(K, dissection) };
        }
        return { std::make_unique<CondensedBody>(K, fixed, corridor), nullptr };
    }

    void factor_anew(const std::vector<VertexId>& corridor)
    {
        adopt(factored(K, fixed, corridor, options), {}, K.load());
    }

    void start_rebuild(std::vector<VertexId> corridor)
    {
        rebuild.reset(); // waits for one that goes on
        rebuild.emplace();
        rebuild->load = K.load();
        rebuild->result
            = std::async(std::launch::async, [K = K, fixed = fixed, corridor = std::move(corridor), how = options] {
                  return factored(K, fixed, corridor, how);
              });
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
        if ((folding && folding->source->origin) || (folded && folded->origin)) {
            leaving = false; // such a stroke goes outside the corridor; the next step would do the same again
            folding.reset();
            drop_folded();
        }
        const AddedVertices added = body->keep_also(missing);
        for (const VertexId v : added.vertices)
            base.keep(v);
        if (folded)
            keep_also(*folded, added);
        if (folding)
            folding->added.push_back(added);
        hooks_changed();
    }

    /// Free vertices of the body that are condensed away although a cut has changed their rows or loads.
    std::vector<VertexId> changed_but_condensed() const
    {
        if (parts)
            return parts->changed_but_closed(K);
        std::vector<VertexId> found;
        for (const auto& [v, row] : base.reference)
            if (body->has(v) && body->place(v) < 0
                && (!(K.row(v) == row) || (K.loaded() && K.load().segment<3>(3 * v) != grown_segment(base_load, v))))
                found.push_back(v);
        return found;
    }
    static Vec3 grown_segment(const Eigen::VectorXd& by_id, VertexId v)
    {
        return 3 * static_cast<Eigen::Index>(v) < by_id.size() ? Vec3(by_id.segment<3>(3 * v)) : Vec3(Vec3::Zero());
    }

    /// Those that were left behind and that a cut or a hook has come back to.
    std::vector<VertexId> wanted_back() const
    {
        std::vector<VertexId> wanted;
        for (const VertexId v : folded->behind.vertices) {
            const auto was = folded->reference.find(v);
            if (is_held_now(v) || (was != folded->reference.end() && !(K.row(v) == was->second)))
                wanted.push_back(v);
        }
        return wanted;
    }
    bool is_held_now(VertexId v) const
    {
        return std::any_of(held.begin(), held.end(), [&](const HeldVertex& h) { return h.vertex == v; });
    }

    /// The folded state still stands for all that has left it.
    bool folded_holds() const
    {
        if (folded->left.empty())
            return true;
        const auto changed = [&](VertexId v) {
            const auto was = folded->reference.find(v);
            return was != folded->reference.end() && !(K.row(v) == was->second);
        };
        return wanted_back().empty() && std::none_of(folded->left.begin(), folded->left.end(), [&](VertexId v) {
            return is_held_now(v) || changed(v);
        });
    }

    /// Sets the local system up against the state, and by the route, that cost least.
    void make_local()
    {
        std::set<VertexId> held_vertices;
        for (const HeldVertex& h : held)
            held_vertices.insert(h.vertex);
        std::vector<std::uint8_t> active(K.slot_count(), 0);
        for (VertexId v = 0; v < static_cast<VertexId>(active.size()); ++v)
            active[static_cast<std::size_t>(v)] = is_active(v) ? 1 : 0;
        const double dense = dense_work(body->kept().size(), held.size());
        double from_base = low_rank_work(changed_vertices(K, base).size(), held.size());
        double from_folded = std::numeric_limits<double>::infinity();
        if (folded && !folded_holds())
            drop_folded_state();
        if (folded) {
            fetch_back(*folded, K, wanted_back());
            from_folded = low_rank_work(changed_vertices(K, *folded).size(), held.size());
        }
        const bool use_folded = folded && from_folded < std::min(from_base, dense);
        view = use_folded ? &*folded : &base;
        std::optional<HookCompliance>& hook_compliance = use_folded ? folded_compliance : base_compliance;
        std::size_t held_rows = 0;
        for (const HeldVertex& h : held)
            held_rows += view->place(h.vertex) >= 0 ? 3 : 0;
        if (!hook_compliance || hook_compliance->columns.rows() != view->compliance().rows()
            || hook_compliance->rows.size() != held_rows) // one was attached to the factor as it was
            hook_compliance = make_hook_compliance(*view, held);
        std::set<VertexId> fresh;
        for (const VertexId v : newborn)
            if (!view->has(v))
                fresh.insert(v);
        change = make_cut_change(K, *view, active, fresh, held_vertices);
        if (folded && !use_folded)
            drop_folded_state();
        const bool low_rank = use_folded || from_base <= dense;
        local.emplace(K, *view, low_rank ? nullptr : &body->stiffness(), *change, *hook_compliance, held);
        if (!low_rank)
            change->stiffness.resize(0, 0); // it is in the factor
    }

    /// Living nodes of each hook; @return a hook that has lost its hold.
    std::optional<HookId> gather_held()
    {
        held.clear();
        std::int32_t number = 0;
        for (const auto& [id, hook] : hooks) {
            std::size_t living = 0;
            for (const VertexId v : hook.nodes)
                if (is_active(v) && !hook.lost.contains(v)) {
                    held.push_back({ v, number });
                    ++living;
                }
            constexpr std::size_t kPatch = 3;
            if (living < kPatch)
                return id;
            ++number;
        }
        return std::nullopt;
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

    bool has_bed(VertexId v) const { return K.bed(v) > 0.0; }
    /// Of one that a delta brings.
    bool born_fixed(const MeshDelta::VertexBorn& born)
    {
        if (born.origin == MeshDelta::Origin::restored)
            return ablated_fixed.give_back(born.id).value_or(0) != 0;
        return is_fixed(born.a) && is_fixed(born.b);
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

    /// Displacements near the wound and the hooks, by vertex id, and elsewhere zero; a column per case.
    struct Near {
        Eigen::MatrixXd displacement;
        Eigen::MatrixXd hook_forces; ///< three rows per hook
    };

    bool ready() const { return local.has_value() || parts_ready; }
    double reciprocal_condition() const
    {
        return parts ? parts->reciprocal_condition() : local->reciprocal_condition();
    }

    /// Factors what cuts and hooks have touched.
    void update_parts(const std::vector<VertexId>& needed)
    {
        parts->open(K, needed);
        std::vector<std::uint8_t> active(K.slot_count(), 0);
        for (VertexId v = 0; v < static_cast<VertexId>(active.size()); ++v)
            active[static_cast<std::size_t>(v)] = is_active(v) ? 1 : 0;
        std::set<VertexId> still;
        for (const HeldVertex& h : held)
            still.insert(h.vertex);
        if (!parts->update(K, active, still))
            throw SolverError("the stiffness of the cut body is not positive definite");
        parts_ready = true;
    }

    /// With the body taken apart: displacements of all vertices.
    Near solve_parts(const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const
    {
        const Eigen::Index cases = hook_displacement.cols(), rows = 3 * static_cast<Eigen::Index>(K.slot_count());
        Eigen::MatrixXd b = Eigen::MatrixXd::Zero(rows, cases);
        if (load.size() != 0)
            b.colwise() += load;
        for (const HeldVertex& h : held)
            for_blocks(h.vertex, [&](VertexId v, const RowBlock& block) {
                b.middleRows(3 * v, 3) -= block.transpose() * hook_displacement.middleRows(3 * h.hook, 3);
            });
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (!is_active(v))
                b.middleRows(3 * v, 3).setZero();
        Near near { parts->solve(b), Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(hooks.size()), cases) };
        for (const HeldVertex& h : held)
            near.displacement.middleRows(3 * h.vertex, 3) = hook_displacement.middleRows(3 * h.hook, 3);
        for (const HeldVertex& h : held) {
            auto sum = near.hook_forces.middleRows(3 * h.hook, 3);
            for_blocks(h.vertex,
                [&](VertexId v, const RowBlock& block) { sum += block * near.displacement.middleRows(3 * v, 3); });
            if (load.size() != 0)
                sum.colwise() -= Vec3(load.segment<3>(3 * h.vertex));
        }
        return near;
    }

    /// Brings the local system up to date. @return why there is no answer; empty when there is.
    std::string prepare()
    {
        if (ready())
            return {};
        lost_hook = gather_held();
        if (lost_hook)
            return "hook '" + hooks.at(*lost_hook).name
                + "' has lost its hold: fewer than three of its vertices are left";
        if (!all_joined_to_something())
            return loose_piece();
        std::vector<VertexId> needed = changed_but_condensed();
        for (const HeldVertex& h : held)
            needed.push_back(h.vertex);
        try {
            if (parts) {
                update_parts(needed);
            } else {
                keep(needed);
                make_local();
            }
        } catch (const SolverError& error) {
            const std::string piece = loose_piece();
            if (piece.empty())
                throw;
            return piece;
        }
        constexpr double kSuspicious = 1e-11; // a loose piece leaves round-off here
        if (reciprocal_condition() < kSuspicious)
            if (std::string piece = loose_piece(); !piece.empty()) {
                local.reset();
                parts_ready = false;
                return piece;
            }
        if (reciprocal_condition() == 0.0)
            throw SolverError("the stiffness of the cut body is not positive definite");
        return {};
    }

    static Eigen::MatrixXd at(const std::vector<VertexId>& vertices, const Eigen::MatrixXd& by_id)
    {
        Eigen::MatrixXd values(3 * static_cast<Eigen::Index>(vertices.size()), by_id.cols());
        for (std::size_t i = 0; i < vertices.size(); ++i)
            values.middleRows(3 * static_cast<Eigen::Index>(i), 3) = by_id.middleRows(3 * vertices[i], 3);
        return values;
    }
    Eigen::VectorXd grown(const Eigen::VectorXd& by_id) const
    {
        Eigen::VectorXd v = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()));
        v.head(by_id.size()) = by_id;
        return v;
    }

    /// @param load by vertex id, the same in all cases, on vertices near by; empty: none.
    Near solve_near(const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const
    {
        if (parts)
            return solve_parts(load, hook_displacement);
        const Eigen::Index cases = hook_displacement.cols();
        const bool loaded = load.size() != 0;
        Eigen::MatrixXd kept_load = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(view->vertices.size()), cases);
        Eigen::MatrixXd newborn_load
            = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(change->newborn.size()), cases);
        std::optional<LoadOnLeft> on_left;
        const LeftBehind& behind = view->behind;
        if (loaded) {
            Eigen::VectorXd felt = load;
            if (!behind.vertices.empty()) { // what they take hands its load on to its neighbours
                const Eigen::MatrixXd alone = behind.factor.solve(at(behind.vertices, load));
                for (std::size_t z = 0; z < behind.vertices.size(); ++z)
                    for_blocks(behind.vertices[z], [&](VertexId v, const RowBlock& block) {
                        felt.segment<3>(3 * v)
                            -= block.transpose() * alone.col(0).segment<3>(3 * static_cast<Eigen::Index>(z));
                    });
            }
            kept_load.colwise() += at(view->vertices, felt).col(0);
            if (!view->left.empty()) {
                Eigen::MatrixXd left_load = at(body->kept(), felt);
                for (std::size_t i = 0; i < body->kept().size(); ++i)
                    if (!is_active(body->kept()[i]))
                        left_load.middleRows(3 * static_cast<Eigen::Index>(i), 3).setZero();
                on_left = view->load_on_left(*body, Eigen::MatrixXd(left_load.replicate(1, cases)));
            }
            newborn_load.colwise() += at(change->newborn, felt).col(0);
            for (std::size_t i = 0; i < view->vertices.size(); ++i) // what is gone carries no load
                if (!is_active(view->vertices[i]))
                    kept_load.middleRows(3 * static_cast<Eigen::Index>(i), 3).setZero();
        }
        const LocalSystem::Solution s
            = local->solve(kept_load, newborn_load, hook_displacement, on_left ? on_left->response : Eigen::MatrixXd());
        Near near { Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()), cases),
            Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(hooks.size()), cases) };
        Eigen::MatrixXd& x = near.displacement;
        const auto put = [&](const std::vector<VertexId>& vertices, const Eigen::MatrixXd& values) {
            for (std::size_t i = 0; i < vertices.size(); ++i)
                if (is_active(vertices[i]))
                    x.middleRows(3 * vertices[i], 3) = values.middleRows(3 * static_cast<Eigen::Index>(i), 3);
        };
        put(view->vertices, s.kept);
        put(change->newborn, s.newborn);
        if (!view->left.empty()) {
            const Eigen::MatrixXd of_body = view->carried_back(s.kept_forces, on_left ? &*on_left : nullptr);
            for (const VertexId v : view->left)
                x.middleRows(3 * v, 3) = of_body.middleRows(3 * body->place(v), 3);
        }
        for (const HeldVertex& h : held)
            x.middleRows(3 * h.vertex, 3) = hook_displacement.middleRows(3 * h.hook, 3);
        if (!behind.vertices.empty()) {
            Eigen::MatrixXd pull = loaded
                ? Eigen::MatrixXd(at(behind.vertices, load).replicate(1, cases))
                : Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(behind.vertices.size()), cases);
            for (std::size_t z = 0; z < behind.vertices.size(); ++z)
                for_blocks(behind.vertices[z], [&](VertexId v, const RowBlock& block) {
                    if (!behind.place.contains(v))
                        pull.middleRows(3 * static_cast<Eigen::Index>(z), 3) -= block * x.middleRows(3 * v, 3);
                });
            put(behind.vertices, behind.factor.solve(pull));
        }
        for (std::size_t i = 0; i < held.size(); ++i) {
            const HeldVertex& h = held[i];
            auto sum = near.hook_forces.middleRows(3 * h.hook, 3);
            if (view->place(h.vertex) >= 0) {
                sum += s.held_forces.middleRows(3 * static_cast<Eigen::Index>(i), 3);
                continue;
            }
            for_blocks(h.vertex, // all neighbours of a newborn vertex are near
                [&](VertexId v, const RowBlock& block) { sum += block * x.middleRows(3 * v, 3); });
            if (loaded)
                sum.colwise() -= Vec3(load.segment<3>(3 * h.vertex));
        }
        return near;
    }

    template <class F> void for_blocks(VertexId v, const F& f) const
    {
        const OnlineStiffness::Row& row = K.row(v);
        for (std::size_t k = 0; k < row.column.size(); ++k)
            f(row.column[k], RowBlock(row.value.data() + 9 * k));
    }

    /// The loads that the system near by sees: those now, less those whose field is added at the end, more what holds
    /// that field back.
    Eigen::VectorXd near_load() const
    {
        if (!K.loaded())
            return {};
        if (parts)
            return K.load();
        return held_back(K.load() - grown(base_load), grown(base_field));
    }
    Eigen::VectorXd held_back(Eigen::VectorXd load, const Eigen::VectorXd& field) const
    {
        const Eigen::MatrixXd forces = product(body->stiffness(), at(body->kept(), field));
        for (std::size_t i = 0; i < body->kept().size(); ++i)
            load.segment<3>(3 * body->kept()[i]) += forces.col(0).segment<3>(3 * static_cast<Eigen::Index>(i));
        return load;
    }

    /// Extends a near field to the whole body; `field` is that of the loads held back, empty: none.
    Eigen::MatrixXd whole_field(const Eigen::MatrixXd& near, const Eigen::VectorXd& field) const
    {
        if (parts) // it is whole
            return near;
        Eigen::MatrixXd kept = at(body->kept(), near);
        if (field.size() != 0)
            kept.colwise() -= at(body->kept(), field).col(0);
        Eigen::MatrixXd x = body->field(kept, K.slot_count());
        if (field.size() != 0)
            x.colwise() += field;
        for (const VertexId v : body->kept())
            x.middleRows(3 * v, 3) = near.middleRows(3 * v, 3);
        for (const VertexId v : newborn)
            x.middleRows(3 * v, 3) = near.middleRows(3 * v, 3);
        return x;
    }
    Eigen::VectorXd load_field() const { return K.loaded() ? grown(base_field) : Eigen::VectorXd(); }

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

    std::vector<Vec3> hook_forces(const Eigen::VectorXd& imbalance_of_all) const
    {
        std::vector<Vec3> forces(hooks.size(), Vec3::Zero());
        for (const HeldVertex& h : held)
            forces[static_cast<std::size_t>(h.hook)] -= imbalance_of_all.segment<3>(3 * h.vertex);
        return forces;
    }

    /// Solves for a residual on all free unknowns, the hooks held still; for most of it where what is condensed away
    /// has next to none of it, as after answers: that costs a fifth.
    Eigen::VectorXd correction(const Eigen::VectorXd& r) const
    {
        const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(hooks.size()), 1);
        if (parts)
            return solve_parts(r, still).displacement.col(0);
        constexpr double kNextToNone = 1e-2;
        Eigen::VectorXd condensed = r;
        for (const VertexId v : body->kept())
            condensed.segment<3>(3 * v).setZero();
        for (const VertexId v : newborn)
            condensed.segment<3>(3 * v).setZero();
        if (condensed.norm() <= kNextToNone * r.norm())
            return whole_field(solve_near(r - condensed, still).displacement, {}).col(0);
        const Eigen::VectorXd field = body->solve(condensed);
        const Near near = solve_near(held_back(r, field), still);
        return whole_field(near.displacement, field).col(0);
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
    /// @param forces column_forces where there are columns; empty: to be found.
    void place_hooks(OnlineAnswer& answer, const Eigen::MatrixXd& forces = {}) const
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
        Eigen::MatrixXd R = forces;
        if (R.size() == 0) {
            R = solve_near(near_load(), unit_cases()).hook_forces;
            without_loads(R);
        }
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

void keep_freed_memory()
{
    constexpr int kLarge = 1 << 30;
    ::mallopt(M_MMAP_THRESHOLD, kLarge);
    ::mallopt(M_TRIM_THRESHOLD, kLarge);
}

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
        std::vector<double> bed(s.K.slot_count(), 0.0);
        for (const BeddedVertex& bedded : supports.bedded) {
            check_vertex(s.K, bedded.vertex, "supports");
            bed[static_cast<std::size_t>(bedded.vertex)] = bedded.stiffness;
        }
        s.K.set_bed(std::move(bed));
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

void OnlineOpening::follow(const MeshDelta& delta, std::span<const LipFace> lips)
{
    State& s = *state_;
    s.K.check(delta);
    s.fold_when_worth_it();
    std::vector<std::pair<VertexId, OnlineStiffness::Row>> before;
    for (const VertexId v : s.K.touched_by(delta))
        before.emplace_back(v, s.K.row(v));
    s.K.apply(delta);
    s.fixed.resize(s.K.slot_count(), 0);
    for (auto& [v, row] : before) {
        if (s.rebuild)
            s.rebuild->reference.try_emplace(v, row);
        if (s.folded)
            s.folded->reference.try_emplace(v, row);
        if (s.folding)
            s.folding->reference.try_emplace(v, row);
        if (!s.parts)
            s.base.reference.try_emplace(v, std::move(row));
        else if (!(s.K.row(v) == row))
            s.parts->touch(v, row);
    }
    for (const MeshDelta::VertexBorn& vertex : delta.vertices_born) {
        if (s.folded && s.folded->has(vertex.id))
            s.drop_folded(); // an id that lives again is another vertex
        if (s.folding && s.folding->source->has(vertex.id))
            s.folding.reset();
        s.fixed[static_cast<std::size_t>(vertex.id)] = s.born_fixed(vertex) ? 1 : 0;
        if (s.parts)
            s.parts->touch(vertex.id, {});
        else if (!s.is_fixed(vertex.id) && !s.body->has(vertex.id))
            s.newborn.insert(vertex.id);
    }
    for (const MeshDelta::VertexBorn& vertex : delta.vertices_gone) {
        s.newborn.erase(vertex.id);
        if (vertex.origin == MeshDelta::Origin::restored)
            s.ablated_fixed.keep(vertex.id, s.fixed[static_cast<std::size_t>(vertex.id)]);
        s.fixed[static_cast<std::size_t>(vertex.id)] = 0;
    }
    s.carry_hooks(delta);
    s.K.set_wound(lips);
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
    const auto number = static_cast<std::int32_t>(s.hooks.size()); // ids rise: it is the last
    s.hooks.emplace(id, AttachedHook { std::move(hook) });
    const bool kept = s.local && s.local->route() == LocalRoute::dense
        && std::all_of(nodes.begin(), nodes.end(), [&](VertexId v) { return s.view->place(v) >= 0; });
    if (!kept) {
        s.hooks_changed();
        return id;
    }
    // The factor stays: it is the dear part there.
    for (const VertexId v : s.hooks.at(id).nodes)
        s.held.push_back({ v, number });
    s.local->hold_appended();
    s.columns.resize(0, 0);
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
        answer.lost_hook = s.lost_hook;
        return answer;
    }
    answer.message = s.partly_lost();
    s.place_hooks(answer);
    const Eigen::MatrixXd d = s.stacked(answer.hook_displacements);
    const State::Near near = s.solve_near(s.near_load(), d);
    for (std::size_t h = 0; h < answer.hooks.size(); ++h)
        answer.hook_forces_N.push_back(near.hook_forces.col(0).segment<3>(3 * static_cast<Eigen::Index>(h)));
    answer.displacement = near.displacement.col(0);
    answer.reciprocal_condition = s.reciprocal_condition();
    answer.corridor_seconds = watch.seconds();
    return answer;
}

void OnlineOpening::complete(OnlineAnswer& answer)
{
    State& s = *state_;
    if (answer.status == OnlineStatus::unsupported)
        return;
    if (!s.ready() || answer.displacement.size() != 3 * static_cast<Eigen::Index>(s.K.slot_count()))
        throw InputError("the answer is of an earlier state: ask for another");
    const Stopwatch watch;
    const Eigen::MatrixXd d = s.stacked(answer.hook_displacements);
    answer.displacement = s.whole_field(answer.displacement, s.load_field()).col(0);
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
    const State::Near near = s.solve_near(s.near_load(), unit);
    s.columns = s.whole_field(near.displacement, s.load_field());
    s.column_forces = near.hook_forces;
    double worst = 0.0;
    const Eigen::MatrixXd internal = s.K.multiply(s.columns);
    for (Eigen::Index c = 0; c < unit.cols(); ++c) {
        const double load = s.right_side(unit.col(c)).norm();
        Eigen::VectorXd r = -internal.col(c);
        if (s.K.loaded())
            r += s.K.load();
        if (load > 0.0)
            worst = std::max(worst, s.masked(std::move(r)).norm() / load);
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

OnlineAnswer OnlineOpening::drag_answer()
{
    State& s = *state_;
    if (s.columns.rows() == 0)
        throw InputError("dragging needs prepare_drag() after the last change");
    const Stopwatch watch;
    OnlineAnswer answer;
    answer.message = s.partly_lost();
    s.place_hooks(answer, s.column_forces);
    answer.displacement = drag(answer.hook_displacements);
    answer.hook_forces_N = drag_forces(answer.hook_displacements);
    answer.whole = true;
    answer.residual = s.column_residual;
    answer.reciprocal_condition = s.reciprocal_condition();
    answer.whole_seconds = watch.seconds();
    return answer;
}

std::vector<VertexId> OnlineOpening::held_vertices() const
{
    std::vector<VertexId> vertices;
    for (const auto& [id, hook] : state_->hooks)
        for (const VertexId v : hook.nodes)
            if (!hook.lost.contains(v) && state_->is_active(v))
                vertices.push_back(v);
    return vertices;
}

void OnlineOpening::start_rebuild() { state_->start_rebuild(state_->corridor_now(state_->changed_but_condensed())); }

void OnlineOpening::start_rebuild(std::span<const VertexId> corridor)
{
    std::set<VertexId> wanted = state_->hooked();
    wanted.insert(corridor.begin(), corridor.end());
    std::erase_if(wanted, [&](VertexId v) { return !state_->is_active(v); });
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
    } catch (const SolverError&) { // the body does not stand without its hooks
        return false;
    }
    return true;
}

const OnlineStiffness& OnlineOpening::stiffness() const { return state_->K; }
std::size_t OnlineOpening::corridor_vertices() const
{
    return state_->parts ? state_->parts->open_count() : state_->body->kept().size();
}
std::string OnlineOpening::route() const
{
    return state_->parts                                 ? "dissected"
        : !state_->local                                 ? "none"
        : state_->local->route() == LocalRoute::low_rank ? "low rank"
                                                         : "dense";
}
bool OnlineOpening::folded() const { return state_->local && state_->folded && state_->view == &*state_->folded; }
std::size_t OnlineOpening::left_vertices() const { return folded() ? state_->folded->left.size() : 0; }
double OnlineOpening::factor_entries() const
{
    return state_->parts ? state_->parts->factor_entries() : state_->body->factor_entries();
}

std::size_t OnlineOpening::bytes() const
{
    const State& s = *state_;
    std::size_t sum = s.K.bytes() + (s.parts ? s.parts->bytes() : s.body->bytes());
    const auto add = [&](const Eigen::MatrixXd& a) { sum += static_cast<std::size_t>(a.size()) * sizeof(double); };
    add(s.columns);
    for (const auto* compliance : { &s.base_compliance, &s.folded_compliance })
        if (*compliance)
            add((*compliance)->columns);
    if (s.folded) {
        add(s.folded->compliance());
        sum += s.folded->behind.factor.bytes() + s.folded->step_bytes();
    }
    if (s.folding) // what it will be, at most
        add(*s.folding->source->compliance);
    if (s.change) {
        add(s.change->stiffness);
        add(s.change->coupling);
        sum += s.change->condensing.bytes();
    }
    if (s.local)
        sum += s.local->bytes();
    return sum;
}

} // namespace retractor
