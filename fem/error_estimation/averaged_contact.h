#pragma once
// Contact that was found for four-node elements, applied to ten-node elements on the same mesh. Units mm, N; vectors
// have three entries per node.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/model/elastic_body.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <vector>

namespace retractor::fem {

/// Contact by the coarse body's pairs. A point of a pair is displaced by its own displacement plus the mean of the
/// displacements that the ten-node elements add on the edges round the point. The weight of an edge in this mean is
/// the area of the contact faces on both sides of the edge.
class AveragedContact {
public:
    /// Takes the present pairs; a body without contact has no pairs.
    /// @param fine with_midpoints() of the coarse mesh.
    /// @param answer displacement of the coarse body, mm.
    /// @pre the coarse body lives longer than this object.
    AveragedContact(const ElasticBody& coarse, const mesh::TetMesh& fine, const Eigen::VectorXd& answer);

    /// Computes the stiffness for add_product(). The share `lifted` of its indefinite part is left out.
    void linearise(const Eigen::VectorXd& answer, double lifted);

    void add_forces(Eigen::VectorXd& to) const; ///< adds the contact forces at the answer, N
    /// adds the product of the contact stiffness with u
    void add_product(const Eigen::VectorXd& u, Eigen::VectorXd& to) const;

    struct Share { ///< weight of an edge's function in the mean at one end of the edge
        VertexId end, other, middle;
        double weight;
    };
    const std::vector<Share>& shares() const { return shares_; } ///< shares of one end are consecutive
    const BlockMatrix& linear_stiffness() const { return stiffness_; } ///< contact stiffness for linear functions

private:
    void weigh_edges(const mesh::TetMesh& coarse, const mesh::TetMesh& fine);
    Eigen::VectorXd average(const Eigen::VectorXd& u) const;
    void spread(const Eigen::VectorXd& forces, Eigen::VectorXd& to) const;

    const Contact* contact_;
    Eigen::Index coarse_size_;
    Eigen::VectorXd forces_;
    BlockMatrix stiffness_;
    std::vector<Share> shares_;
};

} // namespace retractor::fem
