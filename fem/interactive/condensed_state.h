#pragma once
// A state of a condensed body against which later states are solved: the compliance of the retained vertices with all
// other vertices eliminated, and the stiffness rows of that state. The first state is the body as it was factored.
//
// While a stroke goes on, low-rank updates (LowRankUpdate) move the changes so far into a new state, so that the cost
// of a step depends on the step's own changes and not on those of the whole stroke. Vertices behind the knife are
// dropped from the new state: their compliance is no longer updated, and their displacements follow from the forces,
// back through the updates. A state is exact except for round-off, which adds up slowly; residuals show the round-off.
//
// Units mm, N; three rows per vertex.

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

/// Stiffness rows of a state, for every vertex that was touched since.
using ReferenceRows = std::map<VertexId, OnlineStiffness::Row>;

/// Vertices that cuts have added and that are eliminated again, behind the knife, with the factor that gives their
/// displacements.
struct EliminatedAdded {
    std::vector<VertexId> vertices; ///< rising
    std::map<VertexId, std::int32_t> place;
    /// Factor of the vertices' own stiffness; mutable because a solve uses its work space.
    mutable SparseCholesky factor;

    /// Sets `place` and `factor` for the present `vertices`.
    /// @param row the stiffness row of a vertex
    /// @throws SolverError when the vertices' own stiffness is not positive definite
    void number_and_factor(const RowOf& row);
};

/// The step from one state to the next where vertices are dropped: the data that carry forces back and displacements
/// forward. "Before" is the state before the step.
struct LowRankUpdate {
    std::vector<std::int32_t> staying; ///< rows before of the vertices that stay; these come first in the new state
    std::vector<std::int32_t> changed; ///< rows before whose stiffness changed
    Eigen::MatrixXd columns; ///< compliance before, columns `changed`
    Eigen::MatrixXd taken; ///< compliance after = compliance before - columns taken columns^T
    std::vector<std::int32_t> beside; ///< rows before that the vertices added by this step follow
    Eigen::MatrixXd follow; ///< displacements of the added vertices per displacement of `beside`
};

/// Loads on dropped vertices, and their effect on the state.
struct LoadOnDropped {
    Eigen::MatrixXd load; ///< rows of the retained vertices of the body
    Eigen::MatrixXd response; ///< displacements of the vertices of the state
    std::vector<Eigen::MatrixXd> of_changed; ///< per step: displacements of the changed rows, before the step
};

/// Compliance and stiffness rows of the retained vertices.
struct CondensedState {
    std::vector<VertexId> vertices;
    std::vector<std::int32_t> places; ///< place in `vertices` per vertex id, or -1; ids beyond the end: -1
    const CondensedBody* body = nullptr; ///< the body whose compliance this state uses; null: the state uses `own`
    std::shared_ptr<const Eigen::MatrixXd> own;
    ReferenceRows reference;
    std::set<VertexId> added; ///< members of `vertices` that cuts have added since the body was factored
    EliminatedAdded eliminated_added;
    std::shared_ptr<const Eigen::MatrixXd> origin; ///< compliance of the body, from which `steps` start; may be null
    std::vector<std::shared_ptr<const LowRankUpdate>> steps; ///< from the state of the body to this state
    /// Members of `vertices` that an earlier update changed; the next update that does not change them drops them.
    std::set<VertexId> stale;
    std::set<VertexId> dropped; ///< vertices that the steps have dropped

    std::shared_ptr<const Eigen::MatrixXd> shared_compliance() const
    {
        return body != nullptr ? body->shared_compliance() : own;
    }
    const Eigen::MatrixXd& compliance() const { return body != nullptr ? body->compliance() : *own; }
    std::int32_t place(VertexId v) const
    {
        return v >= 0 && static_cast<std::size_t>(v) < places.size() ? places[static_cast<std::size_t>(v)] : -1;
    }
    /// @param load rows of the retained vertices of the body; loads on vertices that are not dropped are ignored
    LoadOnDropped load_on_dropped(const CondensedBody& of, const Eigen::MatrixXd& load) const;
    /// Displacements of all vertices that the body retains.
    /// @param forces on the rows of this state
    /// @param load loads on dropped vertices; null: none
    Eigen::MatrixXd carried_back(Eigen::MatrixXd forces, const LoadOnDropped* load) const;
    std::size_t step_bytes() const;
    /// Whether this state retains the vertex or has eliminated it; false for vertices that later cuts add.
    bool has(VertexId v) const { return place(v) >= 0 || eliminated_added.place.contains(v); }
    void keep(VertexId v); ///< appends the vertex to `vertices` and `places`; the caller extends the compliance
};

/// The state of the body as it was factored. The body must live as long as the state.
CondensedState condensed_state_of(const CondensedBody& body);

/// Retains eliminated vertices again.
/// @pre no vertex has been dropped
/// @param K the present stiffness; rows that changed since are in the reference
void fetch_back(CondensedState& state, const OnlineStiffness& K, const std::vector<VertexId>& vertices);

/// Retains the vertices that the body now retains in addition.
/// @pre no vertex has been dropped
/// @param added the result of CondensedBody::keep_also()
void keep_also(CondensedState& state, const AddedVertices& added);

/// The rows of these vertices in the compliance, three per vertex.
std::vector<std::int32_t> rows_of_vertices(const CondensedState& state, const std::vector<VertexId>& vertices);

} // namespace retractor::fem
