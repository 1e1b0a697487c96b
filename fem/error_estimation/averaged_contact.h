#pragma once
// Contact of four-node elements, felt by ten-node ones on the same mesh. Units mm, N; vectors have three entries per
// node.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/model/elastic_body.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <vector>

namespace retractor::fem {

/// Contact by the coarse body's pairs. A point of theirs feels the displacement there and the mean of what the finer
/// elements add on the edges round it, weighted by the area of the faces in contact on both sides of an edge.
class AveragedContact {
public:
    /// By the pairs as they are; a body without contact has none. @param fine with_midpoints() of its mesh. @param
    /// answer of the coarse body, which must outlive this.
    AveragedContact(const ElasticBody& coarse, const mesh::TetMesh& fine, const Eigen::VectorXd& answer);

    /// For add_product(); what is indefinite is left out by the share `lifted`.
    void linearise(const Eigen::VectorXd& answer, double lifted);

    void add_forces(Eigen::VectorXd& to) const; ///< at the answer
    void add_product(const Eigen::VectorXd& u, Eigen::VectorXd& to) const; ///< of the stiffness with u

    struct Share { ///< of what an edge's function adds to one of its ends
        VertexId end, other, middle;
        double weight;
    };
    const std::vector<Share>& shares() const { return shares_; } ///< those of one end stand together
    const BlockMatrix& linear_stiffness() const { return stiffness_; } ///< as linear functions feel it

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
