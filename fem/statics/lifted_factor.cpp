#include "fem/statics/lifted_factor.h"

#include "mesh/base/error.h"

#include <algorithm>

namespace retractor::fem {

void factorise_least_lifted(ElasticBody& body, const Eigen::VectorXd& displacement, ConstrainedSolver& solver)
{
    constexpr double kLeast = 1.0 / 64.0, kMore = 4.0;
    for (double lift = 0.0;; lift = std::min(1.0, std::max(kMore * lift, kLeast))) {
        const BlockMatrix& K = body.stiffness(displacement, lift);
        try {
            return solver.factorise(K);
        } catch (const SolverError&) {
            if (lift == 1.0)
                throw;
        }
    }
}

} // namespace retractor::fem
