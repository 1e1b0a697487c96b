#pragma once
// Opening a wound while it is cut: linear small-strain elasticity on four-node elements that follows a CutSession by
// its deltas and answers hooks at once. Exact: every answer satisfies the equations of the mesh as it is now, carries
// its residual, and is refined when that is too large. How: the body is factored once, condensed onto the vertices
// where it will be cut and held (CondensedBody); cuts change a small dense system on these (CutChange, LocalSystem);
// the displacements there are the first answer, the far field follows by half a solve (SchurWoundSolver). A cut
// elsewhere costs a solve per unknown it touches, and beyond a limit a new factorisation; neither needs asking for.
// Where the corridor is so large that its dense system costs more than the whole body's sparse one, the body is taken
// apart instead, and the parts that cuts change are factored anew (MultifrontalWoundSolver); the first answer is then
// the whole field.
//
// What costs what (box of 67,000 elements, 530 vertices in the corridor; `retractor-bench open` measures it):
// construction a factorisation; follow() and answer() what the cut is large; complete() half a solve of the whole;
// attach() a small dense factorisation; drag() a product with three columns per hook, which prepare_drag() makes.
//
// Units mm, N, MPa; frame patient LPS. Vertices by the session's ids; fields have three entries per id, zero where no
// vertex lives. A vertex that cuts add is fixed where the edge or vertex it comes from is; it has no bed. One
// that an undone ablation brings back has the support it had; one ablated before this was made comes back free.

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
    unsupported, ///< a piece has come off, or a hook lost its hold: refused, by name. Undo, or hook the piece.
    inaccurate, ///< the residual stays above the limit, or hooks_at_rest is false
};

struct [[nodiscard]] OnlineAnswer {
    OnlineStatus status = OnlineStatus::solved;
    std::optional<HookId> lost_hook; ///< unsupported: the hook that lost its hold, if that is the reason
    std::string message; ///< what was refused and where; or which hooks have lost a part of their hold
    Eigen::VectorXd displacement; ///< mm; before complete() only in the corridor and on the lips
    bool whole = false;
    std::vector<HookId> hooks; ///< attached, in the order of the next two
    std::vector<Vec3> hook_displacements; ///< mm: what the tissue under the hook does
    /// What the surgeon must apply; where hooks meet, without what they press on each other with.
    std::vector<Vec3> hook_forces_N;
    std::vector<bool> hook_yielded; ///< held back by its force limit
    std::vector<FacingHooks> meeting; ///< hooks that hold each other back: their lips have met
    bool hooks_at_rest = true; ///< else forces and displacements are no answer
    double residual = 0.0; ///< of the whole field: set by complete()
    int refinements = 0;
    double reciprocal_condition = 0.0; ///< estimate for the system solved anew
};

class OnlineOpening {
public:
    /// @param corridor vertices where cuts are planned, for speed only; those fixed or not alive are left out.
    /// @throws InputError on bad materials, supports, vertices; SolverError when the body is not held.
    OnlineOpening(const mesh::CutSession& session, std::span<const Material> material_of_label,
        const Supports& supports, std::span<const VertexId> corridor, OnlineOptions options = {});
    ~OnlineOpening();
    OnlineOpening(OnlineOpening&&) noexcept;

    /// Takes a delta of the session in; the next answer is of the mesh as it is then. Hooks hold their vertices, not
    /// ids: one that is gone is let go, and held again when it comes back, whatever its id was used for meanwhile.
    /// @param lips of the session after it (CutSession::lips()); needed where there is tension.
    /// @throws InputError when it does not fit; nothing is changed then.
    void follow(const mesh::MeshDelta& delta, std::span<const mesh::LipFace> lips = {});

    /// @throws InputError when nodes are missing, dead, fixed, named twice or held by another hook, and on bad drives.
    HookId attach(OnlineHook hook);
    void detach(HookId hook); ///< @throws InputError when there is no such hook
    /// Hooks on facing lips that are drawn, or draw each other, through each other stop where they meet.
    /// @throws InputError as attach()
    void drive(HookId hook, const HookDrive& drive);

    /// The corridor, the lips and the hooks.
    OnlineAnswer answer();
    /// The whole field, with its residual, refined where that is needed.
    void complete(OnlineAnswer& answer);

    /// Makes the whole-field columns of all hooks; kept until a cut or a change of hooks. @return their worst residual.
    /// @pre the last answer was not refused.
    double prepare_drag();
    /// The whole field with each hook's tissue displaced so, through each other's, too: one small dense product.
    /// @pre prepare_drag().
    const Eigen::VectorXd& drag(std::span<const Vec3> hook_displacements);
    /// The same hooks' forces. @pre prepare_drag().
    std::vector<Vec3> drag_forces(std::span<const Vec3> hook_displacements) const;
    /// What answer() and complete() give for the hooks' drives as they are now, by the columns: limits and grips
    /// included. Its residual is the columns' worst. @pre prepare_drag().
    OnlineAnswer drag_answer();

    /// Pairs that face each other, as the body is cut now; places in the order of rising ids.
    const std::vector<FacingHooks>& facing_hooks();

    /// The vertices that hooks hold now, hook by hook.
    std::vector<VertexId> held_vertices() const;

    /// Factors the body as it is now, on its own thread. The corridor becomes what cuts and hooks have touched, or,
    /// where the next cut is known better, these vertices and the hooks'; for speed only.
    void start_rebuild();
    void start_rebuild(std::span<const VertexId> corridor);
    bool rebuilding() const; ///< one was begun, and is not swapped in yet
    bool rebuild_ready() const; ///< adopting it will not wait
    /// Swaps the new factor in, waiting for it where it must. @return false when none was begun, or it failed: the old
    /// one stays.
    bool adopt_rebuild();

    const OnlineStiffness& stiffness() const;
    bool fixed(VertexId v) const; ///< held where it is
    std::size_t corridor_vertices() const; ///< now, with those added
    std::string route() const; ///< how the last answer was found: "low rank", "dense", "dissected"
    bool is_updated() const; ///< the last answer was set up against a state that a stroke was folded into
    std::size_t dropped_vertices() const; ///< of the corridor, behind the knife: that this state does without
    double factor_entries() const;
    std::size_t bytes() const; ///< memory held: matrix, factor, dense systems, columns

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
