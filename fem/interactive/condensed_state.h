#pragma once
// A state of a condensed body that later states are solved against: the compliance of the vertices that matter, with
// all others condensed, and what their rows of the stiffness were. The first is that of the body as it was factored.
// While a stroke goes on, what it has changed so far is folded into another, so that each step costs what the step
// changes, not what the stroke has changed. What lies behind the knife leaves the folded state: its compliance is not
// kept up to date, and its displacements are found from the forces, back through the folds (LowRankUpdate). Exact but
// for round-off, which adds up slowly; residuals tell. Units mm, N; three rows per vertex.

#include "fem/interactive/condensed_body.h"
#include "fem/interactive/online_stiffness.h"
#include "fem/interactive/vertex_matrix.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace retractor::fem {

/// Rows of the stiffness as they were in a state, of every vertex touched since.
using ReferenceRows = std::map<VertexId, OnlineStiffness::Row>;

/// Vertices that cuts have added and that are condensed again, behind the knife: what is needed to find them.
struct EliminatedAdded {
    std::vector<VertexId> vertices; ///< rising
    std::map<VertexId, std::int32_t> place;
    mutable SparseCholesky factor; ///< of their rows and columns; solving uses its work space

    /// Sets `place` and `factor` for the vertices as they are now. @param row the stiffness, by vertex.
    /// @throws SolverError when their part of the stiffness is not positive definite.
    void number_and_factor(const RowOf& row);
};

/// How a folded state follows from the one before, where vertices leave it: enough to carry forces back and
/// displacements on.
struct LowRankUpdate {
    std::vector<std::int32_t> staying; ///< rows before of what this state keeps first
    std::vector<std::int32_t> changed; ///< rows before whose stiffness was changed
    Eigen::MatrixXd columns; ///< compliance before, columns `changed`
    Eigen::MatrixXd taken; ///< the compliance after is that before less columns taken columns^T
    std::vector<std::int32_t> beside; ///< rows before that the vertices added here follow
    Eigen::MatrixXd follow; ///< displacements of these per displacement of those beside
};

/// Loads on vertices that have left a view, and what they do.
struct LoadOnDropped {
    Eigen::MatrixXd load; ///< rows of the body's kept vertices
    Eigen::MatrixXd response; ///< of the view's vertices
    std::vector<Eigen::MatrixXd> of_changed; ///< per step: response of the rows it changed, before it did
};

struct CondensedState {
    std::vector<VertexId> vertices;
    std::vector<std::int32_t> places; ///< per vertex id: place in `vertices`, or -1; shorter: -1
    const CondensedBody* body = nullptr; ///< the compliance is this body's, or
    std::shared_ptr<const Eigen::MatrixXd> own;
    ReferenceRows reference;
    std::set<VertexId> added; ///< those of `vertices` that cuts have added since the body was factored
    EliminatedAdded eliminated_added;
    std::shared_ptr<const Eigen::MatrixXd> origin; ///< compliance of the body, which `steps` lead back to; may be null
    std::vector<std::shared_ptr<const LowRankUpdate>> steps; ///< from the body's own view to this one
    std::set<VertexId> stale; ///< of `vertices`: changed by a fold before; they leave with the next that does not
    std::set<VertexId> dropped; ///< with the steps

    std::shared_ptr<const Eigen::MatrixXd> shared_compliance() const
    {
        return body != nullptr ? body->shared_compliance() : own;
    }
    const Eigen::MatrixXd& compliance() const { return body != nullptr ? body->compliance() : *own; }
    std::int32_t place(VertexId v) const
    {
        return v >= 0 && static_cast<std::size_t>(v) < places.size() ? places[static_cast<std::size_t>(v)] : -1;
    }
    /// @param load rows of the body's kept vertices; what it has on others than those left does not count.
    LoadOnDropped load_on_dropped(const CondensedBody& of, const Eigen::MatrixXd& load) const;
    /// Displacements of all vertices that the body keeps. @param forces on the rows of this view. @param load null:
    /// none.
    Eigen::MatrixXd carried_back(Eigen::MatrixXd forces, const LoadOnDropped* load) const;
    std::size_t step_bytes() const;
    /// Kept or left behind: no newborn vertex of a later cut.
    bool has(VertexId v) const { return place(v) >= 0 || eliminated_added.place.contains(v); }
    void keep(VertexId v); ///< appends it to `vertices` and `places`; the compliance is the caller's
};

/// The body as it was factored; referred to as long as the view lives.
CondensedState condensed_state_of(const CondensedBody& body);

/// Keeps vertices again that were left behind. @pre no vertex has left. @param K the stiffness now; rows changed since
/// are in the reference.
void fetch_back(CondensedState& view, const OnlineStiffness& K, const std::vector<VertexId>& vertices);

/// Keeps what the body keeps now in addition. @pre no vertex has left. @param added as CondensedBody::keep_also()
/// returned it.
void keep_also(CondensedState& view, const AddedVertices& added);

/// Rows three per vertex at these places.
std::vector<std::int32_t> rows_of_vertices(const CondensedState& view, const std::vector<VertexId>& vertices);

} // namespace retractor::fem
