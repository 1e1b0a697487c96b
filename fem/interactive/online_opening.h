#pragma once
// Opens a wound while it is cut: linear small-strain elasticity on four-node elements that follows a CutSession by its
// deltas and answers hooks at once. Every answer satisfies the equations of the present mesh, carries its residual, and
// is refined when the residual is too large.
//
// Method. The body is factored once and condensed onto the vertices where it will be cut and held (CondensedBody). Cuts
// change a small dense system on these vertices (CutChange, LocalSystem). Their displacements are the first answer; the
// eliminated vertices follow by half a solve (SchurWoundSolver). A cut outside the corridor costs one solve per touched
// unknown, and beyond a limit a new factorisation; both happen without request. Where the corridor is so large that its
// dense system costs more than the sparse system of the whole body, the body is divided into a tree of parts, and the
// parts that cuts change are factored anew (MultifrontalWoundSolver). The first answer is then the whole field.
//
// Costs (box of 67,000 elements, 530 vertices in the corridor; `retractor-bench open` measures them): the constructor a
// factorisation; follow() and answer() a work that grows with the cut; complete() half a solve of the whole; attach() a
// small dense factorisation; drag() a product with three columns per hook, which prepare_drag() makes.
//
// Units mm, N, MPa; frame patient LPS. Vertices have the ids of the session; fields have three entries per id, zero
// where no vertex lives. A vertex that a cut adds is fixed when the edge or vertex from which it comes is fixed; it has
// no bed. A vertex that an undone ablation brings back has its old support, but is free when it was ablated before this
// object was made.

#include "fem/interactive/online_hook.h"
#include "fem/interactive/online_options.h"
#include "fem/interactive/online_stiffness.h"
#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hooks_apart.h"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

enum class OnlineStatus {
    solved,
    /// A piece has come off, or a hook has lost its hold; the message names the piece or hook. The user can undo the
    /// cut or hook the piece.
    unsupported,
    inaccurate, ///< the residual stays above the limit, or hooks_at_rest is false
};

struct [[nodiscard]] OnlineAnswer {
    OnlineStatus status = OnlineStatus::solved;
    std::optional<HookId> lost_hook; ///< when unsupported: the hook that has lost its hold, if this is the cause
    std::string message; ///< the refusal and its place, or the hooks that have lost some of their vertices
    Eigen::VectorXd displacement; ///< mm; before complete() only in the corridor and on the lips
    /// Whether `displacement` is complete.
    bool whole = false;
    std::vector<HookId> hooks; ///< attached hooks; the lists below have this order
    std::vector<Vec3> hook_displacements; ///< mm: displacement of the tissue under each hook
    /// Force that the surgeon must apply to each hook, without the force between hooks that meet.
    std::vector<Vec3> hook_forces_N;
    std::vector<bool> hook_yielded; ///< per hook: the force limit is reached
    std::vector<FacingHooks> meeting; ///< pairs of hooks that stop each other because their lips meet
    bool hooks_at_rest = true; ///< false: forces and displacements are not valid
    double residual = 0.0; ///< of the whole field; set by complete()
    int refinements = 0;
    double reciprocal_condition = 0.0; ///< estimate for the system that was solved anew
};

class OnlineOpening {
public:
    /// @param corridor vertices where cuts are planned, for speed only; fixed and dead vertices are ignored
    /// @throws InputError on bad materials, supports or vertices; SolverError when the body is not supported
    OnlineOpening(const mesh::CutSession& session, std::span<const Material> material_of_label,
        const Supports& supports, std::span<const VertexId> corridor, OnlineOptions options = {});
    ~OnlineOpening();
    OnlineOpening(OnlineOpening&&) noexcept;

    /// Follows a delta of the session; the next answer is for the mesh after the delta. Hooks hold vertices, not ids: a
    /// hook releases a vertex that is gone and holds it again when the vertex comes back, even if the id was used
    /// for another vertex meanwhile.
    /// @param lips CutSession::lips() after the delta; needed where there is tension
    /// @throws InputError when the delta does not fit the mesh; nothing is changed then
    void follow(const mesh::MeshDelta& delta, std::span<const mesh::LipFace> lips = {});

    /// Attaches a hook.
    /// @throws InputError when nodes are missing, dead, fixed, named twice or held by another hook, and on bad drives
    HookId attach(OnlineHook hook);
    void detach(HookId hook); ///< @throws InputError when there is no such hook
    /// Sets the drive of a hook. Hooks on facing lips that would pass through each other stop where they meet.
    /// @throws InputError as attach()
    void drive(HookId hook, const HookDrive& drive);

    /// Solves for the corridor, the lips and the hooks.
    OnlineAnswer answer();
    /// Computes the whole field with its residual, and refines the field where the residual is too large.
    void complete(OnlineAnswer& answer);

    /// Computes the whole-field columns of all hooks. The columns are valid until a cut or a change of hooks.
    /// @return the largest residual of the columns
    /// @pre the last answer was not refused
    double prepare_drag();
    /// The whole field for given displacements of the tissue under each hook, by one small dense product. Hooks may
    /// pass through each other here.
    /// @pre prepare_drag() was called
    const Eigen::VectorXd& drag(std::span<const Vec3> hook_displacements);
    /// The hook forces of drag(). @pre prepare_drag() was called
    std::vector<Vec3> drag_forces(std::span<const Vec3> hook_displacements) const;
    /// The result of answer() and complete() for the present drives, computed from the columns, with limits and grips.
    /// The residual is the largest residual of the columns.
    /// @pre prepare_drag() was called
    OnlineAnswer drag_answer();

    /// Pairs of hooks that face each other in the present body, as indices in the order of rising hook ids.
    const std::vector<FacingHooks>& facing_hooks();

    /// The vertices that hooks hold now, hook by hook.
    std::vector<VertexId> held_vertices() const;

    /// Starts a factorisation of the present body on another thread. The new corridor is the vertices that cuts and
    /// hooks have touched, or `corridor` and the vertices of hooks where the next cut is better known; for speed only.
    void start_rebuild();
    void start_rebuild(std::span<const VertexId> corridor);
    bool rebuilding() const; ///< a rebuild was started and is not adopted yet
    bool rebuild_ready() const; ///< adopt_rebuild() will not wait
    /// Replaces the factor by the new one, and waits for it if necessary.
    /// @return false when no rebuild was started or the rebuild failed; the old factor then stays
    bool adopt_rebuild();

    const OnlineStiffness& stiffness() const;
    bool fixed(VertexId v) const; ///< the vertex does not move
    std::size_t corridor_vertices() const; ///< present number, with added vertices
    std::string route() const; ///< method of the last answer: "low rank", "dense" or "dissected"
    bool is_updated() const; ///< the last answer was computed against an updated state
    /// Number of corridor vertices behind the knife that the updated state has dropped.
    std::size_t dropped_vertices() const;
    std::size_t bytes() const; ///< memory in use: matrix, factor, dense systems, columns

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
