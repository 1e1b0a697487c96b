#include "tests/benchmarks/framework/bench_numbers.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::benchmarks {

double percentile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0.0;
    const auto rank = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), rank, values.end());
    return *rank;
}

double median(std::vector<double> values) { return percentile(std::move(values), 0.5); }

double relative_difference(const Eigen::VectorXd& field, const Eigen::VectorXd& reference)
{
    const Eigen::Index both = std::min(field.size(), reference.size());
    if (!field.tail(field.size() - both).isZero(0.0) || !reference.tail(reference.size() - both).isZero(0.0))
        throw SolverError("fields of different meshes are compared");
    return (field.head(both) - reference.head(both)).lpNorm<Eigen::Infinity>() / reference.lpNorm<Eigen::Infinity>();
}

} // namespace retractor::benchmarks
