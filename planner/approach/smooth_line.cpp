#include "planner/approach/smooth_line.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace retractor::planner {

std::vector<Vec3> smoothed(const std::vector<Vec3>& values, double sigma_nodes)
{
    RETRACTOR_ASSERT(!values.empty() && sigma_nodes > 0.0);
    const auto n = static_cast<int>(values.size());
    const auto at = [&](int i) -> Vec3 {
        if (i < 0)
            return 2.0 * values.front() - values[static_cast<std::size_t>(std::min(-i, n - 1))];
        if (i >= n)
            return 2.0 * values.back() - values[static_cast<std::size_t>(std::max(2 * n - 2 - i, 0))];
        return values[static_cast<std::size_t>(i)];
    };
    const int reach = static_cast<int>(std::ceil(3.0 * sigma_nodes));
    std::vector<Vec3> result(values.size());
    for (int i = 0; i < n; ++i) {
        Vec3 sum = Vec3::Zero();
        double weights = 0.0;
        for (int d = -reach; d <= reach; ++d) {
            const double w = std::exp(-0.5 * (d / sigma_nodes) * (d / sigma_nodes));
            sum += w * at(i + d);
            weights += w;
        }
        result[static_cast<std::size_t>(i)] = sum / weights;
    }
    return result;
}

std::vector<Vec3> tangents(const std::vector<Vec3>& line)
{
    RETRACTOR_ASSERT(line.size() >= 2);
    std::vector<Vec3> result(line.size());
    for (std::size_t n = 0; n < line.size(); ++n)
        result[n] = (line[std::min(n + 1, line.size() - 1)] - line[n == 0 ? 0 : n - 1]).normalized();
    return result;
}

} // namespace retractor::planner
