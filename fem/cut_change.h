#pragma once
// What cuts have done to a condensed body: the change of the stiffness on the vertices it keeps, with the vertices that
// cuts have added (they hang on the kept ones alone) eliminated. A function of the mesh, not of its history: where a
// cut was undone there is no change. Units N/mm; three rows per vertex.

#include "fem/condensed_body.h"

#include <map>
#include <set>

namespace retractor {

/// Rows of the stiffness as they were when the body was condensed, of every vertex touched since.
using ReferenceRows = std::map<VertexId, OnlineStiffness::Row>;

struct CutChange {
    std::vector<VertexId> changed; ///< kept vertices whose rows differ from the reference; rising
    std::vector<std::int32_t> kept_rows; ///< three per changed vertex: its rows among the kept
    Eigen::MatrixXd stiffness; ///< change on them, the free newborn eliminated

    std::vector<VertexId> newborn; ///< free vertices that were not there, rising
    std::map<VertexId, std::int32_t> newborn_place;
    SparseCholesky newborn_factor;
    std::vector<std::int32_t> beside; ///< rows of `stiffness` that the newborn couple to
    Eigen::MatrixXd newborn_by_beside; ///< K_nn^-1 K_nb
    Eigen::MatrixXd coupling; ///< K_nb, 3 newborn x beside

    /// Displacements of the newborn under loads on them, the changed vertices held still.
    Eigen::MatrixXd newborn_alone(const Eigen::MatrixXd& load) const;
};

/// Free vertices of the body that are condensed away although a cut has changed their rows: keep them first.
std::vector<VertexId> changed_but_not_kept(
    const OnlineStiffness& K, const CondensedBody& body, const ReferenceRows& reference);

/// @param active per vertex id: 1 where a free vertex lives now. @param newborn free vertices that the body does not
/// have. @param held vertices whose displacement is given; the newborn among them are not eliminated.
/// @pre changed_but_not_kept() is empty. @throws SolverError when newborn vertices are not held by the kept ones.
CutChange make_cut_change(const OnlineStiffness& K, const CondensedBody& body, const ReferenceRows& reference,
    const std::vector<std::uint8_t>& active, const std::set<VertexId>& newborn, const std::set<VertexId>& held);

} // namespace retractor
