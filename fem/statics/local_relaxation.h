#pragma once
// Nonlinear elimination of local residuals [Lanzkron, Rose, Wilkes 1996, doi 10.1137/S106482759325154X]: where the
// forces that are left stand at a few nodes (slivers at a cut, a crushed element), these nodes are brought to rest
// while the rest of the body stays. Newton's method for the whole body would shorten step after step for their sake.
// Units mm, N.

#include "fem/model/elastic_body.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace retractor::fem {

class LocalRelaxation {
public:
    /// @param body corotational, and larger than its parts: see is_worth_it()
    /// @param prescribed one flag per unknown, 1 = prescribed
    LocalRelaxation(const ElasticBody& body, const std::vector<std::uint8_t>& prescribed);

    /// Whether the parts of a body can be relaxed, and are much smaller than the body.
    static bool is_worth_it(const ElasticBody& body);

    /// The displacement with the nodes that bear the largest forces, and their neighbours, at rest. Nodes at which
    /// something else than tissue acts stay where they are.
    /// @param forces internal forces at the displacement u, zero at prescribed unknowns
    /// @returns nothing where the forces are not local, or where nothing can move
    std::optional<Eigen::VectorXd> relaxed(const Eigen::VectorXd& u, const Eigen::VectorXd& forces) const;

private:
    std::vector<VertexId> worst_nodes(
        const Eigen::VectorXd& forces, const std::vector<std::uint8_t>& touched) const;

    const ElasticBody& body_;
    const std::vector<std::uint8_t>& prescribed_;
    std::vector<std::int32_t> first_; ///< of each node in `around_`
    std::vector<TetId> around_; ///< elements round the nodes
};

} // namespace retractor::fem
