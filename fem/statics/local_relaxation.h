#pragma once
// Nonlinear elimination [Lanzkron, Rose, Wilkes 1996, doi 10.1137/S106482759325154X]: where only a few nodes have large
// residual forces (slivers at a cut, a crushed element), Newton's method first solves for these nodes and their
// neighbours, with all other nodes fixed. Without this the line search shortens each step of the whole body. Units mm,
// N.

#include "fem/model/elastic_body.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace retractor::fem {

class LocalRelaxation {
public:
    /// @param prescribed one flag per unknown, 1 = prescribed
    /// @pre body.has_parts(); body and flags outlive this object
    LocalRelaxation(const ElasticBody& body, const std::vector<std::uint8_t>& prescribed);

    /// The displacement with the nodes that bear the largest forces, and their neighbours, at rest. Nodes at which
    /// something else than tissue acts stay where they are.
    /// @param forces internal forces at the displacement u, zero at prescribed unknowns
    /// @returns nothing where the forces are not local, where they stand at nodes that must stay, or where nothing can
    /// move
    std::optional<Eigen::VectorXd> relax(const Eigen::VectorXd& u, const Eigen::VectorXd& forces) const;

private:
    std::vector<VertexId> find_worst_nodes(
        const Eigen::VectorXd& forces, const std::vector<std::uint8_t>& touched) const;

    const ElasticBody& body_;
    const std::vector<std::uint8_t>& prescribed_;
    std::vector<std::int32_t> first_; ///< of each node in `around_`
    std::vector<TetId> around_; ///< elements round the nodes
};

} // namespace retractor::fem
