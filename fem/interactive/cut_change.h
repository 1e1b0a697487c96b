#pragma once
// What cuts have done since a state of the body: the change of the stiffness on the vertices that state keeps, with the
// vertices that cuts have added since (they hang on the kept ones alone) eliminated. A function of the mesh, not of its
// history: where a cut was undone there is no change. Units N/mm; three rows per vertex.

#include "fem/interactive/condensed_state.h"
#include "fem/interactive/vertex_matrix.h"

namespace retractor::fem {

struct CutChange {
    std::vector<VertexId> changed; ///< kept vertices whose rows differ from the reference; rising
    std::vector<std::int32_t> kept_rows; ///< three per changed vertex: its rows among the kept
    /// The change on them, but for what the newborn add: to be summed up.
    struct Block {
        std::int32_t row = 0, column = 0; ///< among `changed`
        Mat3 value;
    };
    std::vector<Block> blocks;
    Eigen::MatrixXd stiffness; ///< the whole change, where it is wanted as one matrix: see changed_stiffness()

    std::vector<VertexId> added; ///< free vertices that were not there, rising
    std::map<VertexId, std::int32_t> added_place;
    std::vector<std::int32_t> beside; ///< rows of `stiffness` that the newborn couple to
    Eigen::MatrixXd taken; ///< lower triangle on `beside`: what the newborn, eliminated, add there
    SparseCholesky condensing; ///< factor of newborn, condensed onto those beside

    /// Displacements of the newborn where those beside them move so and nothing pushes them.
    Eigen::MatrixXd newborn_following(const Eigen::MatrixXd& beside_displacement) const;
    struct Pushed {
        Eigen::MatrixXd displacement; ///< of the newborn, those beside held still
        Eigen::MatrixXd handed_on; ///< force on those beside
    };
    Pushed newborn_alone(const Eigen::MatrixXd& load) const; ///< under loads on the newborn
};

/// Kept vertices whose rows differ from the reference.
std::vector<VertexId> changed_vertices(const OnlineStiffness& K, const CondensedState& view);

/// The whole change as one dense matrix on the changed unknowns.
Eigen::MatrixXd changed_stiffness(const CutChange& change);

/// All but the matrix `stiffness`. @param active per vertex id: 1 where a free vertex lives now. @param newborn free
/// vertices that the view does not have. @param held vertices whose displacement is given; the newborn among them are
/// not eliminated.
/// @pre all vertices whose rows changed are kept, newborn or fixed.
/// @throws SolverError when newborn vertices are not held by the kept ones.
CutChange make_cut_change(const OnlineStiffness& K, const CondensedState& view, const std::vector<std::uint8_t>& active,
    const std::set<VertexId>& added, const std::set<VertexId>& held);

} // namespace retractor::fem
