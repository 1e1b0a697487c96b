#pragma once
// A body while it is cut: its stiffness as it is now, what supports it, and the hooks with what they hold. Vertices by
// the session's ids; fields have three entries per id. Units mm, N, MPa; frame patient LPS.

#include "fem/interactive/online_hook.h"
#include "fem/interactive/online_stiffness.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hooks_apart.h"
#include "mesh/cutting/ablated_values.h"

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// With those of its vertices that are gone: where they were. A vertex that comes back to the very place is the same.
struct AttachedHook : OnlineHook {
    std::map<VertexId, Vec3> lost {};

    bool holds(VertexId v) const;
};
inline constexpr std::size_t kHookPatch = 3; ///< vertices of a hook at least

struct OnlineBody {
    OnlineStiffness K; ///< of all living vertices, the fixed and the held included
    std::vector<std::uint8_t> fixed {}; ///< per vertex id
    mesh::AblatedValues<std::uint8_t> ablated_fixed {};
    std::map<HookId, AttachedHook> hooks {};
    std::vector<HeldVertex> held {}; ///< living nodes of all hooks, as gather_held() found them

    bool lives(VertexId v) const { return v >= 0 && static_cast<std::size_t>(v) < K.slot_count() && K.alive(v); }
    bool is_fixed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < fixed.size() && fixed[static_cast<std::size_t>(v)] != 0;
    }
    bool is_active(VertexId v) const { return lives(v) && !is_fixed(v); }
};

/// @throws InputError on vertices that do not live, and bad beds.
void set_supports(OnlineBody& body, const Supports& supports);
/// @throws InputError when nodes are missing, dead, fixed, named twice or held by another hook, and on bad drives.
void check_hook(const OnlineBody& body, const OnlineHook& hook);

/// What supports lose and get back. @pre the stiffness is that after the delta.
void carry_supports(OnlineBody& body, const mesh::MeshDelta& delta);
/// What hooks lose and get back. @return whether any did.
bool carry_hooks(OnlineBody& body, const mesh::MeshDelta& delta);

std::vector<std::uint8_t> active_vertices(const OnlineBody& body); ///< per vertex id: 1 where a free vertex lives
std::set<VertexId> hooked_vertices(const OnlineBody& body); ///< whose displacement a hook gives
std::set<VertexId> held_vertices(const OnlineBody& body); ///< those of `held`
/// Finds the living nodes of each hook. @return a hook that has lost its hold.
std::optional<HookId> gather_held(OnlineBody& body);
/// Names the hooks that hold less than they did; empty: none.
std::string partly_lost(const OnlineBody& body);

/// Pairs that lie opposite each other on facing lips; places in the order of `hooks`.
std::vector<FacingHooks> facing_hooks_of(const OnlineBody& body);

/// Every vertex is joined, by elements, to one that is fixed, bedded or held.
bool all_joined_to_something(const OnlineBody& body);
std::string loose_piece(const OnlineBody& body); ///< names the piece that is not held; empty: there is none

/// Zero at fixed and held vertices.
Eigen::VectorXd on_free(const OnlineBody& body, Eigen::VectorXd by_id);
/// Right side of the free unknowns: loads, and what moving the hooks pulls on.
Eigen::VectorXd right_side(const OnlineBody& body, const Eigen::VectorXd& hook_displacement);
/// Loads less internal forces, everywhere: what supports and hooks take with the sign turned, elsewhere an error.
Eigen::VectorXd imbalance(const OnlineBody& body, const Eigen::VectorXd& displacement);
/// By attached hook: what it must apply. @param imbalance_of_all see imbalance().
std::vector<Vec3> hook_forces(const OnlineBody& body, const Eigen::VectorXd& imbalance_of_all);

/// f(column, block) for the blocks of a vertex' row of the stiffness.
template <class F> void for_blocks(const OnlineStiffness& K, VertexId v, const F& f)
{
    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    const OnlineStiffness::Row& row = K.row(v);
    for (std::size_t k = 0; k < row.column.size(); ++k)
        f(row.column[k], RowBlock(row.value.data() + 9 * k));
}

} // namespace retractor::fem
