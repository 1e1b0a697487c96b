#pragma once
// The change of the stiffness that cuts have made since a state of the body, on the retained vertices of that state.
// Vertices that cuts have added since couple to retained vertices only and are eliminated. The change depends on the
// mesh alone, not on its history: an undone cut leaves no change. Units N/mm; three rows per vertex.

#include "fem/interactive/condensed_state.h"
#include "fem/interactive/vertex_matrix.h"

namespace retractor::fem {

struct CutChange {
    std::vector<VertexId> changed; ///< retained vertices whose rows differ from the reference, rising
    std::vector<std::int32_t> kept_rows; ///< rows of the changed vertices among the retained, three per vertex
    /// One block of the change, without the contribution of added vertices. Blocks with the same place are summed.
    struct Block {
        std::int32_t row = 0, column = 0; ///< index into `changed`
        Mat3 value;
    };
    std::vector<Block> blocks;
    Eigen::MatrixXd stiffness; ///< the whole change as one matrix, set where needed: see changed_stiffness()

    std::vector<VertexId> added; ///< free vertices that the state does not have, rising
    std::map<VertexId, std::int32_t> added_place;
    std::vector<std::int32_t> beside; ///< rows of `stiffness` that the added vertices couple to
    Eigen::MatrixXd taken; ///< lower triangle on `beside`: the term that the eliminated added vertices contribute
    SparseCholesky condensing; ///< factor of the added vertices, condensed onto `beside`

    /// Displacements of the added vertices for given displacements of `beside`, without loads.
    Eigen::MatrixXd added_following(const Eigen::MatrixXd& beside_displacement) const;
    struct Pushed {
        Eigen::MatrixXd displacement; ///< of the added vertices, while `beside` does not move
        Eigen::MatrixXd handed_on; ///< force that the added vertices transfer to `beside`
    };
    Pushed added_alone(const Eigen::MatrixXd& load) const; ///< under loads on the added vertices
};

/// Retained vertices whose rows differ from the reference.
std::vector<VertexId> changed_vertices(const OnlineStiffness& K, const CondensedState& state);

/// The whole change as one dense matrix on the changed unknowns.
Eigen::MatrixXd changed_stiffness(const CutChange& change);

/// Computes all members except the matrix `stiffness`.
/// @param active per vertex id: 1 where a free vertex lives now
/// @param added free vertices that the state does not have
/// @param held vertices whose displacement is given; added vertices among them are not eliminated
/// @pre all vertices whose rows changed are retained, added or fixed
/// @throws SolverError when added vertices are not supported by retained vertices
CutChange make_cut_change(const OnlineStiffness& K, const CondensedState& state,
    const std::vector<std::uint8_t>& active, const std::set<VertexId>& added, const std::set<VertexId>& held);

} // namespace retractor::fem
