#pragma once
// A preconditioner for ten-node elements by four-node elements on the same mesh. Vectors have three entries per node,
// corners first.
//
// The linear functions are solved by their factor, the edge functions by their diagonal blocks [Bank, Smith 1993;
// Deuflhard, Leinen, Yserentant 1989].
//
// Contact is much stiffer than tissue and would dominate the diagonal blocks of edge functions on surfaces in
// contact. From each such edge function linear functions with the same effect on the contact are subtracted; the
// contact then acts on linear functions alone. The subtracted functions may strain stiffer tissue, such as bone
// beside muscle, and couple the edges round a corner. Such edges are therefore solved together.

#include "fem/error_estimation/averaged_contact.h"
#include "fem/linear_algebra/block_matrix.h"
#include "fem/linear_algebra/constrained_solver.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace retractor::fem {

/// The embedding of the linear functions in the quadratic functions.
class Nesting {
public:
    /// @param fine ten-node elements.
    /// @param corners number of corners, which are the first vertices of the mesh.
    Nesting(const mesh::TetMesh& fine, std::size_t corners);

    Eigen::VectorXd prolong(const Eigen::VectorXd& coarse) const;
    Eigen::VectorXd restrict_to_corners(const Eigen::VectorXd& fine) const; ///< the transpose of prolong()

    Eigen::Index corners() const { return corners_; }
    std::size_t midpoints() const { return ends_.size(); }

private:
    Eigen::Index corners_;
    std::vector<std::array<VertexId, 2>> ends_; ///< ends of the edge on which each midpoint lies
};

class TwoLevelPreconditioner {
public:
    /// @param coarse solver of the linear functions, which the caller keeps factorised.
    /// @param held one per unknown of the ten-node elements, 1 = prescribed.
    /// @pre all arguments live longer than this object
    TwoLevelPreconditioner(ConstrainedSolver& coarse, const Nesting& nesting, const AveragedContact& contact,
        const std::vector<std::uint8_t>& held);

    /// Takes the diagonal blocks from the stiffness of both meshes.
    /// @param coarse_K with contact. The contact of the constructor must be linearised at the same displacement.
    /// @param K of the ten-node elements, without contact.
    void take_blocks(const BlockMatrix& coarse_K, const BlockMatrix& K);

    /// Applies the approximate inverse of the stiffness, which is symmetric and positive definite on the free
    /// unknowns.
    Eigen::VectorXd apply(const Eigen::VectorXd& r);

    /// Sets prescribed entries to zero.
    void mask(Eigen::VectorXd& vector) const;

    std::size_t bytes() const;

private:
    Eigen::Index at(VertexId middle) const { return 3 * (middle - nesting_.corners()); }
    void number_edges_in_contact();
    void add_block(std::size_t row, std::size_t column, const Mat3& block);
    Mat3 felt_at(VertexId corner, const BlockMatrix& coarse_K) const;
    void solve_edges(Eigen::VectorXd& edges);

    ConstrainedSolver& coarse_;
    const Nesting& nesting_;
    const AveragedContact& contact_;
    const std::vector<std::uint8_t>& held_;
    std::vector<Mat3> inverse_; ///< inverse of each edge's diagonal block
    std::map<VertexId, std::size_t> number_; ///< number of each midpoint of an edge in contact
    BlockMatrix matrix_; ///< stiffness of the edges in contact, ordered by number_
    std::optional<ConstrainedSolver> together_; ///< solver of matrix_
};

} // namespace retractor::fem
