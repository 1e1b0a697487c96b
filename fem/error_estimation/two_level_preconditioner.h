#pragma once
// A preconditioner for ten-node elements by four-node ones on the same mesh. Vectors have three entries per node,
// corners first.
//
// The linear functions by their factor, the edge functions by their diagonal blocks [Bank, Smith 1993; Deuflhard,
// Leinen, Yserentant 1989].
//
// Contact is much stiffer than tissue, and what it feels of an edge function would hide all else of that. From those on
// surfaces in contact the linear functions are taken off that are the same to the contact, which then knows linear
// functions alone. What these strain may be bone beside muscle, and couples the edges round a corner: such edges are
// solved together.

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

/// Linear functions among the quadratic ones.
class Nesting {
public:
    /// @param fine ten-node elements; their corners are the first vertices.
    Nesting(const mesh::TetMesh& fine, std::size_t corners);

    Eigen::VectorXd prolong(const Eigen::VectorXd& coarse) const;
    Eigen::VectorXd restrict_to_corners(const Eigen::VectorXd& fine) const; ///< the transpose

    Eigen::Index corners() const { return corners_; }
    std::size_t midpoints() const { return ends_.size(); }

private:
    Eigen::Index corners_;
    std::vector<std::array<VertexId, 2>> ends_; ///< of the edge that each midpoint lies on
};

class TwoLevelPreconditioner {
public:
    /// @param coarse the linear functions' solver, which the caller keeps up to date. @param held one per unknown of
    /// the ten-node elements, 1 = prescribed. All of them must outlive this.
    TwoLevelPreconditioner(ConstrainedSolver& coarse, const Nesting& nesting, const AveragedContact& contact,
        const std::vector<std::uint8_t>& held);

    /// The stiffness of both, with contact in the coarse one; contact is linearised as there.
    void take_blocks(const BlockMatrix& coarse_K, const BlockMatrix& K);

    /// An inverse of the stiffness, roughly: symmetric and positive definite on what is free.
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
    std::vector<Mat3> inverse_; ///< of each edge's diagonal block
    std::map<VertexId, std::size_t> number_; ///< of midpoints of edges in contact
    BlockMatrix matrix_; ///< of these edges, by that number
    std::optional<ConstrainedSolver> together_; ///< solves it
};

} // namespace retractor::fem
