#include "planner/evidence/binomial_interval.h"

#include "mesh/base/assert.h"

#include <boost/math/distributions/beta.hpp>

namespace retractor::planner {

ShareInterval clopper_pearson_interval(std::size_t successes, std::size_t trials, double confidence)
{
    RETRACTOR_ASSERT(successes <= trials && confidence > 0.0 && confidence < 1.0);
    ShareInterval interval;
    const auto k = static_cast<double>(successes), n = static_cast<double>(trials);
    const double tail = 0.5 * (1.0 - confidence);
    // Quantiles of beta distributions solve the two equations of the binomial's tails.
    if (successes > 0)
        interval.low = boost::math::quantile(boost::math::beta_distribution<>(k, n - k + 1.0), tail);
    if (successes < trials)
        interval.high = boost::math::quantile(boost::math::beta_distribution<>(k + 1.0, n - k), 1.0 - tail);
    return interval;
}

} // namespace retractor::planner
