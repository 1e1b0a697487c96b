#pragma once
// A linear body that is condensed onto its rim (static condensation). Condensing costs one factorisation; afterwards
// the body's answer to a motion of the rim is a dense product. Units mm, N, MPa.

#include "fem/linear_algebra/sparse_cholesky.h"
#include "fem/linear_algebra/symmetric_pattern.h"
#include "fem/model/elastic_body.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::fem {

/// Unknowns and order of elimination of a block matrix. Some nodes are prescribed, and the last nodes are retained.
struct CondensingSystem {
    /// Place of each node among the free nodes, rising with the node; -1 when not free.
    std::vector<std::int32_t> number;
    std::vector<VertexId> free; ///< the free nodes, rising
    SymmetricPattern pattern; ///< three unknowns per free node
    std::vector<std::int32_t> source; ///< index into BlockMatrix::values, per entry of the pattern; -1: no such entry
    /// Order of elimination by nested dissection; the retained nodes come last, in their order.
    std::vector<std::int32_t> order;
};

/// @param fixed one per node, 1 = prescribed
/// @param kept number of retained nodes. These are the last nodes and are free.
/// @param dense_kept the pattern holds all pairs of retained nodes, also pairs that no element joins
CondensingSystem condensing_system(
    const BlockPattern& blocks, const std::vector<std::uint8_t>& fixed, std::size_t kept, bool dense_kept);

class CondensedRegion {
public:
    /// @param body the last `rim` nodes are the rim and are free. The stiffness is the stiffness at rest, for every
    /// elasticity.
    /// @param fixed one per node, 1 = does not move
    /// @throws SolverError naming the node of the body at which the body is not supported
    CondensedRegion(ElasticBody& body, const std::vector<std::uint8_t>& fixed, std::size_t rim);

    /// Forces on the rim at unit displacements of the rim: 3 rim x 3 rim, N/mm.
    const Eigen::MatrixXd& stiffness() const { return stiffness_; }
    /// Displacement of the whole body (three entries per node) from the displacement of the rim (three per node of the
    /// rim), without loads. Half a solve.
    Eigen::VectorXd field(const Eigen::VectorXd& rim_displacement) const;

    /// Condenses forces on the body (three entries per node) onto the rim. Half a solve. Forces on fixed nodes are
    /// ignored.
    struct Reduced {
        Eigen::VectorXd on_rim; ///< equivalent forces on the rim, three per node of the rim
        Eigen::MatrixXd half; ///< intermediate result for field()
    };
    Reduced reduce(const Eigen::VectorXd& forces) const;
    /// Displacement of the whole body under these forces.
    Eigen::VectorXd field(const Eigen::VectorXd& rim_displacement, const Reduced& forces) const;

    std::size_t bytes() const;

private:
    Eigen::VectorXd spread(const Eigen::MatrixXd& of_free) const;

    std::size_t nodes_ = 0;
    std::vector<VertexId> free_;
    SparseCholesky factor_;
    Eigen::MatrixXd stiffness_;
};

} // namespace retractor::fem
