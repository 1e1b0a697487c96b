#pragma once
// Factors the stiffness of a body at a state that need not be stable.

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/elastic_body.h"

#include <Eigen/Core>

namespace retractor::fem {

/// Factors the true stiffness where the whole matrix is positive definite; else the stiffness with raised extremes;
/// else that with the smallest sufficient share of its negative eigenvalues raised too (ElasticBody::stiffness()). The
/// matrix is then ElasticBody::last_stiffness().
/// @throws SolverError when the stiffness is not positive definite with all negative eigenvalues raised
void factorise_least_lifted(ElasticBody& body, const Eigen::VectorXd& displacement, ConstrainedSolver& solver);

} // namespace retractor::fem
