#pragma once
// PendingUpdate a change into the state that it was solved against: the state after the change becomes a CondensedState
// of its own, against which further cuts are solved. A fold may run beside the stroke that goes on: it reads a copy
// (UpdateSource). Units mm, N; three rows per vertex.

#include "fem/interactive/condensed_state.h"
#include "fem/interactive/cut_change.h"
#include "fem/interactive/online_stiffness.h"

#include <Eigen/Core>

#include <map>
#include <memory>
#include <set>
#include <vector>

namespace retractor::fem {

/// All that fold() needs of a view and of the stiffness in the state that a change leads to: they may go on meanwhile.
struct UpdateSource {
    std::shared_ptr<const Eigen::MatrixXd> compliance;
    std::vector<VertexId> vertices;
    std::set<VertexId> added, eliminated_added; ///< of the view
    std::map<VertexId, OnlineStiffness::Row> rows; ///< of the newborn, the change's included, and of those behind
    std::set<VertexId> held; ///< whose displacement a hook gives
    std::shared_ptr<const Eigen::MatrixXd> origin; ///< null: nothing may leave
    std::vector<std::shared_ptr<const LowRankUpdate>> steps;
    std::set<VertexId> stale, dropped;

    /// The folded view will have it.
    bool has(VertexId v) const { return rows.contains(v) || of_view.contains(v); }
    std::set<VertexId> of_view; ///< `vertices` again
};
/// @param leaving whether vertices may leave; keep_also() and fetch_back() need views that none have left.
UpdateSource update_source(const CondensedState& view, const CutChange& change, const OnlineStiffness& K,
    std::set<VertexId> held, bool leaving);

/// The state that `change` leads to: its newborn vertices are kept, those of earlier changes are left behind, and the
/// body's own that only earlier changes touched leave, but for held ones. @param change is used up: its work space is.
CondensedState apply_update(const UpdateSource& source, const CutChange& change);

} // namespace retractor::fem
