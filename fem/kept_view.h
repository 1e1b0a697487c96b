#pragma once
// A state of a condensed body that later states are solved against: the compliance of the vertices that matter, with
// all others condensed, and what their rows of the stiffness were. The first is that of the body as it was factored.
// While a stroke goes on, what it has changed so far is folded into another, so that each step costs what the step
// changes, not what the stroke has changed. Exact but for round-off, which adds up slowly; residuals tell. Units mm, N;
// three rows per vertex.

#include "fem/condensed_body.h"

#include <map>
#include <memory>
#include <set>

namespace retractor {

/// Rows of the stiffness as they were in a state, of every vertex touched since.
using ReferenceRows = std::map<VertexId, OnlineStiffness::Row>;

struct CutChange;

/// Vertices that cuts have added and that are condensed again, behind the knife: what is needed to find them.
struct LeftBehind {
    std::vector<VertexId> vertices; ///< rising
    std::map<VertexId, std::int32_t> place;
    mutable SparseCholesky factor; ///< of their rows and columns; solving uses its work space
};

struct KeptView {
    std::vector<VertexId> vertices;
    std::vector<std::int32_t> places; ///< per vertex id: place in `vertices`, or -1; shorter: -1
    const CondensedBody* body = nullptr; ///< the compliance is this body's, or
    std::shared_ptr<const Eigen::MatrixXd> own;
    ReferenceRows reference;
    std::set<VertexId> newborn; ///< those of `vertices` that cuts have added since the body was factored
    LeftBehind behind;

    std::shared_ptr<const Eigen::MatrixXd> shared_compliance() const
    {
        return body != nullptr ? body->shared_compliance() : own;
    }
    const Eigen::MatrixXd& compliance() const { return body != nullptr ? body->compliance() : *own; }
    std::int32_t place(VertexId v) const
    {
        return v >= 0 && static_cast<std::size_t>(v) < places.size() ? places[static_cast<std::size_t>(v)] : -1;
    }
    /// Kept or left behind: no newborn vertex of a later cut.
    bool has(VertexId v) const { return place(v) >= 0 || behind.place.contains(v); }
    void keep(VertexId v); ///< appends it to `vertices` and `places`; the compliance is the caller's
};

/// The body as it was factored; referred to as long as the view lives.
KeptView view_of(const CondensedBody& body);

/// All that fold() needs of a view and of the stiffness in the state that a change leads to: they may go on meanwhile.
struct FoldSource {
    std::shared_ptr<const Eigen::MatrixXd> compliance;
    std::vector<VertexId> vertices;
    std::set<VertexId> newborn, behind; ///< of the view
    std::map<VertexId, OnlineStiffness::Row> rows; ///< of the newborn, the change's included, and of those behind
    std::set<VertexId> held; ///< whose displacement a hook gives

    /// The folded view will have it.
    bool has(VertexId v) const { return rows.contains(v) || of_view.contains(v); }
    std::set<VertexId> of_view; ///< `vertices` again
};
FoldSource fold_source(
    const KeptView& view, const CutChange& change, const OnlineStiffness& K, std::set<VertexId> held);

/// The state that `change` leads to: its newborn vertices are kept, those of earlier changes are left behind, but for
/// held ones. @param change is used up: its work space is.
KeptView fold(const FoldSource& source, const CutChange& change);

/// Keeps vertices again that were left behind. @param K the stiffness now; rows changed since are in the reference.
void fetch_back(KeptView& view, const OnlineStiffness& K, const std::vector<VertexId>& vertices);

/// Keeps what the body keeps now in addition. @param added as CondensedBody::keep_also() returned it.
void keep_also(KeptView& view, const AddedVertices& added);

/// Rows three per vertex at these places.
std::vector<std::int32_t> rows_of_vertices(const KeptView& view, const std::vector<VertexId>& vertices);

} // namespace retractor
