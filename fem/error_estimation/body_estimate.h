#pragma once
// The estimate of error_estimate.h for bodies of one's own: whatever loads them and holds single unknowns of theirs.

#include "fem/model/elastic_body.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

enum class EstimateStatus {
    done,
    not_converged, ///< no iteration went on; there is no estimate
    cancelled,
};

struct BodyEstimate {
    EstimateStatus status = EstimateStatus::done;
    std::string message;
    Eigen::VectorXd displacement; ///< the answer with what the finer body adds, three per node of the finer mesh
    Eigen::VectorXd forces; ///< there, to first order: on prescribed unknowns, what holds them
    Eigen::VectorXd coarse_displacement; ///< what the coarse body says, to first order: not the answer where other
                                         ///< equations gave it
    Eigen::VectorXd coarse_forces; ///< there
    double energy_error = 0.0, algebraic_error = 0.0; ///< as in ErrorEstimate
    int iterations = 0;
    std::size_t bytes = 0; ///< memory it took
};

/// Contact that the coarse body has, with pairs found at the answer, acts on the finer one by the same pairs: at each
/// point on the displacement averaged round it, so that a pressure that the points hold evenly is an even one for
/// ten-node elements too, and not a row of needles. The finer body has none of its own.
///
/// @param coarse plain four-node elements; @param fine ten-node ones on with_midpoints() of the same mesh, of the same
/// model and materials, under the same loads. @param coarse_held, fine_held one per unknown, 1 = prescribed: where the
/// answer, straight along edges, stands.
/// @throws SolverError when the stiffness is not positive definite.
BodyEstimate estimate_error(ElasticBody& coarse, const std::vector<std::uint8_t>& coarse_held, ElasticBody& fine,
    const std::vector<std::uint8_t>& fine_held, const Eigen::VectorXd& answer, const Job& job);

} // namespace retractor::fem
