#pragma once
// The estimate of error_estimate.h for any elastic body, with its own loads and prescribed unknowns.

#include "fem/model/elastic_body.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

enum class EstimateStatus {
    done,
    not_converged, ///< the iteration stopped; there is no estimate
    cancelled,
};

struct BodyEstimate {
    EstimateStatus status = EstimateStatus::done;
    std::string message;
    /// the answer plus the change by the finer body, mm, three per node of the finer mesh
    Eigen::VectorXd displacement;
    Eigen::VectorXd forces; ///< forces at `displacement` to first order, N: reactions at prescribed unknowns
    /// displacement of the coarse body to first order, mm; differs from the answer where other equations gave the
    /// answer
    Eigen::VectorXd coarse_displacement;
    Eigen::VectorXd coarse_forces; ///< forces at `coarse_displacement` to first order, N
    double energy_error = 0.0, algebraic_error = 0.0; ///< as in ErrorEstimate
    int iterations = 0;
    std::size_t bytes = 0; ///< memory that the estimate took
};

/// Estimates the error of an answer of the coarse body by one Newton step on the finer body.
///
/// Contact of the coarse body, with pairs found at the answer, acts on the finer body by the same pairs. Each point
/// of a pair moves with the displacement averaged round the point (averaged_contact.h). An even pressure on the
/// points is then also even for ten-node elements; without the average it would act like single forces. The finer
/// body has no contact of its own.
///
/// @param coarse plain four-node elements.
/// @param fine ten-node elements on with_midpoints() of the same mesh, with the same model, materials and loads.
/// @param coarse_held, fine_held one per unknown, 1 = prescribed at the position of the answer, which is linear along
/// edges.
/// @throws SolverError when the stiffness is not positive definite.
BodyEstimate estimate_error(ElasticBody& coarse, const std::vector<std::uint8_t>& coarse_held, ElasticBody& fine,
    const std::vector<std::uint8_t>& fine_held, const Eigen::VectorXd& answer, const Job& job);

} // namespace retractor::fem
