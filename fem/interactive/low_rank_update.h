#pragma once
// Block low-rank (Woodbury) update of a condensed state: the state after a change becomes a CondensedState of its own,
// against which further cuts are solved. An update may run on another thread while the stroke goes on; the update reads
// a copy (UpdateSource). Units mm, N; three rows per vertex.

#include "fem/interactive/condensed_state.h"
#include "fem/interactive/cut_change.h"
#include "fem/interactive/online_stiffness.h"

#include <Eigen/Core>

#include <map>
#include <memory>
#include <set>
#include <vector>

namespace retractor::fem {

/// The data of a state, and of the stiffness after a change, that apply_update() needs. State and stiffness may change
/// meanwhile.
struct UpdateSource {
    std::shared_ptr<const Eigen::MatrixXd> compliance;
    std::vector<VertexId> vertices;
    std::set<VertexId> added, eliminated_added; ///< as in the state
    /// Stiffness rows of added vertices, also those of the change, and of eliminated vertices.
    std::map<VertexId, OnlineStiffness::Row> rows;
    std::set<VertexId> held; ///< vertices whose displacement a hook gives
    std::shared_ptr<const Eigen::MatrixXd> origin; ///< as in the state; null: no vertex may be dropped
    std::vector<std::shared_ptr<const LowRankUpdate>> steps;
    std::set<VertexId> stale, dropped;

    /// Whether the updated state will have the vertex.
    bool has(VertexId v) const { return rows.contains(v) || vertex_set.contains(v); }
    std::set<VertexId> vertex_set; ///< `vertices` as a set
};
/// @param leaving whether vertices may be dropped; keep_also() and fetch_back() need states without dropped vertices
UpdateSource update_source(const CondensedState& state, const CutChange& change, const OnlineStiffness& K,
    std::set<VertexId> held, bool leaving);

/// Computes the state after `change`. The state retains the vertices that the change added. Vertices added by earlier
/// changes are eliminated, and vertices of the body that only earlier changes touched are dropped, unless a hook holds
/// them.
/// @param change its work space is used up
CondensedState apply_update(const UpdateSource& source, const CutChange& change);

} // namespace retractor::fem
