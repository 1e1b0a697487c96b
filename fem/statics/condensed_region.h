#pragma once
// A linear body of which only a rim matters: everything else is condensed onto it once, so that what lies beyond the
// rim costs a dense product. Units mm, N, MPa.

#include "fem/linear_algebra/sparse_cholesky.h"
#include "fem/linear_algebra/symmetric_pattern.h"
#include "fem/model/elastic_body.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::fem {

/// Unknowns and order of elimination of a block matrix of which some nodes are prescribed and the last ones kept.
struct CondensingSystem {
    std::vector<std::int32_t> number; ///< per node: its place among the free ones, which rises with the node; -1
    std::vector<VertexId> free; ///< the nodes that are free
    SymmetricPattern pattern; ///< three unknowns per free node
    std::vector<std::int32_t> source; ///< per entry: where in BlockMatrix::values it lies; -1: nowhere
    std::vector<std::int32_t> order; ///< nested dissection, the kept ones last as they are
};

/// @param fixed one per node, 1 = prescribed. @param kept so many nodes at the end are free and are kept.
/// @param dense_kept the pattern holds all pairs of kept nodes, though no element joins them.
CondensingSystem condensing_system(
    const BlockPattern& blocks, const std::vector<std::uint8_t>& fixed, std::size_t kept, bool dense_kept);

class CondensedRegion {
public:
    /// @param body its last `rim` nodes are the rim, free. Its stiffness is taken at rest, whatever its elasticity.
    /// @param fixed one per node, 1 = held where it is.
    /// @throws SolverError naming the node of the body where it is not held.
    CondensedRegion(ElasticBody& body, const std::vector<std::uint8_t>& fixed, std::size_t rim);

    /// Forces on the rim that hold it at unit displacements: 3 rim x 3 rim.
    const Eigen::MatrixXd& stiffness() const { return stiffness_; }
    /// Three entries per node of the body, from three per node of the rim: half a solve.
    Eigen::VectorXd field(const Eigen::VectorXd& rim_displacement) const;

    /// Forces on the body, three per node, brought to the rim: half a solve. Those on held nodes are left out.
    struct Reduced {
        Eigen::VectorXd on_rim; ///< what they come to there, three per node of the rim
        Eigen::MatrixXd half; ///< for field()
    };
    Reduced reduce(const Eigen::VectorXd& forces) const;
    /// field() under these forces.
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
