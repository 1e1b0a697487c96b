#include "fem/statics/lifted_factor.h"

#include "mesh/base/error.h"

#include <algorithm>

namespace retractor::fem {

void factorise_least_lifted(ElasticBody& body, const Eigen::VectorXd& displacement, ConstrainedSolver& solver)
{
    constexpr double kLeast = 1.0 / 64.0, kMore = 4.0;
    const auto is_factorised = [&](double lift, Extremes extremes, bool may_fail) {
        const BlockMatrix& K = body.stiffness(displacement, lift, extremes);
        try {
            solver.factorise(K);
            return true;
        } catch (const SolverError&) {
            if (!may_fail)
                throw;
            return false;
        }
    };
    if (is_factorised(0.0, Extremes::as_they_are, true))
        return;
    for (double lift = 0.0; !is_factorised(lift, Extremes::raised, lift < 1.0);
         lift = std::min(1.0, std::max(kMore * lift, kLeast))) { }
}

} // namespace retractor::fem
