#pragma once
// A body while it is cut: its present stiffness, its supports, and its hooks with their vertices. Vertices have the ids
// of the session; fields have three entries per id. Units mm, N, MPa; frame patient LPS.

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
#include <string>
#include <vector>

namespace retractor::fem {

/// A hook, with the last positions of its vertices that are gone. A vertex that comes back at exactly this position is
/// the same vertex.
struct AttachedHook : OnlineHook {
    std::map<VertexId, Vec3> lost {};

    bool holds(VertexId v) const;
};
inline constexpr std::size_t kHookPatch = 3; ///< least number of living vertices that a hook needs

struct OnlineBody {
    OnlineStiffness K; ///< of all living vertices, with fixed and held vertices included
    std::vector<std::uint8_t> fixed {}; ///< per vertex id
    mesh::AblatedValues<std::uint8_t> ablated_fixed {};
    std::map<HookId, AttachedHook> hooks {};
    std::vector<HeldVertex> held {}; ///< living vertices of all hooks, set by gather_held()

    bool lives(VertexId v) const { return v >= 0 && static_cast<std::size_t>(v) < K.slot_count() && K.alive(v); }
    bool is_fixed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < fixed.size() && fixed[static_cast<std::size_t>(v)] != 0;
    }
    bool is_active(VertexId v) const { return lives(v) && !is_fixed(v); }
};

/// Sets fixed vertices, beds and hinges. @throws InputError on vertices that do not live, on bad beds and on bad hinges
void set_supports(OnlineBody& body, const Supports& supports);
/// @throws InputError when nodes are missing, dead, fixed, named twice or held by another hook, and on bad drives
void check_hook(const OnlineBody& body, const OnlineHook& hook);

/// Updates the supports by the vertices that a delta removes and brings back. @pre the stiffness has followed the delta
void carry_supports(OnlineBody& body, const mesh::MeshDelta& delta);
/// Updates the hooks by the vertices that a delta removes and brings back. @return whether any hook changed
bool carry_hooks(OnlineBody& body, const mesh::MeshDelta& delta);

std::vector<std::uint8_t> active_vertices(const OnlineBody& body); ///< per vertex id: 1 where a free vertex lives
std::set<VertexId> hooked_vertices(const OnlineBody& body); ///< vertices whose displacement a hook gives
std::set<VertexId> held_vertices(const OnlineBody& body); ///< vertices of `held`
/// Finds the living vertices of each hook. @return a hook that has lost its hold
std::optional<HookId> gather_held(OnlineBody& body);
/// Names the hooks that have lost some of their vertices; empty: none.
std::string partly_lost(const OnlineBody& body);

/// Pairs of hooks that face each other on opposite lips, as indices in the order of `hooks`.
std::vector<FacingHooks> facing_hooks_of(const OnlineBody& body);

/// Whether every vertex is connected through elements to a fixed, bedded or held vertex.
bool all_joined_to_something(const OnlineBody& body);
std::string loose_piece(const OnlineBody& body); ///< names a piece without support; empty: none

/// Sets the entries of fixed and held vertices to zero.
Eigen::VectorXd on_free(const OnlineBody& body, Eigen::VectorXd by_id);
/// Right side of the equations of the free unknowns: loads, and forces by the displacement of the hooks.
Eigen::VectorXd right_side(const OnlineBody& body, const Eigen::VectorXd& hook_displacement);
/// Loads less internal forces on all vertices. On supports and hooks this is the support force with opposite sign; on
/// free vertices it is an error.
Eigen::VectorXd imbalance(const OnlineBody& body, const Eigen::VectorXd& displacement);
/// Force that each attached hook must apply. @param imbalance_of_all the result of imbalance()
std::vector<Vec3> hook_forces(const OnlineBody& body, const Eigen::VectorXd& imbalance_of_all);

/// Calls f(column, block) for the blocks of the stiffness row of a vertex.
template <class F> void for_blocks(const OnlineStiffness& K, VertexId v, const F& f)
{
    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    const OnlineStiffness::Row& row = K.row(v);
    for (std::size_t k = 0; k < row.column.size(); ++k)
        f(row.column[k], RowBlock(row.value.data() + 9 * k));
}

} // namespace retractor::fem
