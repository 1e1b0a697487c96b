#pragma once
// A linear body that is factored once and condensed onto the few vertices where it will be cut and held, the retained
// vertices (static condensation). The retained vertices come last in the elimination. The trailing block of the factor
// therefore gives the Schur complement on them, and their displacements give the whole field by half a solve. A
// CondensedBody does not change when the body is cut; OnlineOpening follows the cuts.
//
// Units mm, N. Matrices over the retained vertices have three rows per vertex, in the order of kept().

#include "fem/interactive/online_stiffness.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace retractor::fem {

/// How vertices that are retained later follow the vertices retained before: u = follow u_before + own f.
struct AddedVertices {
    std::vector<VertexId> before, vertices;
    Eigen::MatrixXd follow; ///< 3 added rows x 3 before columns
    Eigen::MatrixXd own; ///< compliance of the added vertices while the vertices before do not move
};

class CondensedBody {
public:
    /// Factors the present stiffness; the cost is one sparse factorisation.
    /// @param fixed per vertex id: 1 where the vertex does not move; ids beyond the end are free
    /// @param kept the retained vertices: alive, free, each once
    /// @throws InputError when a retained vertex is not alive, fixed or named twice; SolverError naming the vertex and
    /// axis when the stiffness is not positive definite, because something is not supported
    CondensedBody(
        const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed, const std::vector<VertexId>& kept);

    /// Retains further vertices, exactly. Each new unknown costs one solve (in groups) and the storage of its column.
    /// Vertices that are retained already are ignored.
    AddedVertices keep_also(const std::vector<VertexId>& vertices);

    const std::vector<VertexId>& kept() const { return kept_; }
    /// Place among kept(), or -1 when the vertex is eliminated, fixed or unknown here.
    std::int32_t place(VertexId v) const { return at(place_, v); }
    /// Whether the vertex is free in this body, retained or eliminated.
    bool has(VertexId v) const { return at(number_, v) >= 0; }
    std::size_t added() const { return kept_.size() - planned_; } ///< number of vertices added by keep_also()

    /// The Schur complement: forces on the retained vertices at their unit displacements, while all other vertices are
    /// free.
    const Eigen::MatrixXd& stiffness() const { return stiffness_; }
    /// The inverse of stiffness(): displacements by unit forces.
    const Eigen::MatrixXd& compliance() const { return *compliance_; }
    /// The compliance as shared data, unchanged by a later keep_also().
    std::shared_ptr<const Eigen::MatrixXd> shared_compliance() const { return compliance_; }

    /// The whole field under loads on any vertices. Loads and result have three entries per vertex id. Loads on
    /// vertices that are not in this body are ignored, and their displacements are zero.
    Eigen::VectorXd solve(const Eigen::VectorXd& load) const;
    /// The whole field for given displacements of the retained vertices, without load elsewhere. Half a solve per case.
    /// @param kept_displacement 3 x kept rows, one column per case
    /// @return 3 x slots rows
    Eigen::MatrixXd field(const Eigen::MatrixXd& kept_displacement, std::size_t slots) const;

    std::size_t bytes() const;

private:
    static std::int32_t at(const std::vector<std::int32_t>& of_vertex, VertexId v)
    {
        return v >= 0 && static_cast<std::size_t>(v) < of_vertex.size() ? of_vertex[static_cast<std::size_t>(v)] : -1;
    }

    std::vector<VertexId> free_; ///< vertex of each block of unknowns of the factored matrix
    std::vector<std::int32_t> number_; ///< place in free_ per vertex id, or -1
    std::vector<VertexId> kept_;
    std::vector<std::int32_t> place_; ///< place in kept_ per vertex id, or -1
    std::size_t planned_ = 0; ///< number of retained vertices that come last in the factor; the others were added later
    mutable SparseCholesky factor_; ///< mutable because a solve uses its work space
    Eigen::MatrixXd stiffness_;
    std::shared_ptr<const Eigen::MatrixXd> compliance_;
    Eigen::MatrixXd added_fields_; ///< field of a unit force on each added unknown
};

} // namespace retractor::fem
