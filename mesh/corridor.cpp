#include "mesh/corridor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor {

double polyline_distance(std::span<const Vec3> polyline, const Vec3& p)
{
    if (polyline.empty())
        return std::numeric_limits<double>::infinity();
    double nearest = (p - polyline.front()).squaredNorm();
    for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
        const Vec3 along = polyline[i + 1] - polyline[i];
        const double length2 = along.squaredNorm();
        const double t = length2 > 0.0 ? std::clamp((p - polyline[i]).dot(along) / length2, 0.0, 1.0) : 0.0;
        nearest = std::min(nearest, (p - polyline[i] - t * along).squaredNorm());
    }
    return std::sqrt(nearest);
}

double share_within(std::span<const Vec3> polyline, double radius, const Vec3& centre, const Vec3& edges, int samples)
{
    const double distance = polyline_distance(polyline, centre);
    const double reach = 0.5 * edges.norm();
    if (distance + reach <= radius)
        return 1.0;
    if (distance - reach > radius)
        return 0.0;
    int inside = 0;
    for (int k = 0; k < samples; ++k)
        for (int j = 0; j < samples; ++j)
            for (int i = 0; i < samples; ++i) {
                const Vec3 unit = (Vec3(i, j, k).array() + 0.5) / samples - 0.5;
                inside += polyline_distance(polyline, centre + edges.cwiseProduct(unit)) <= radius;
            }
    return static_cast<double>(inside) / (samples * samples * samples);
}

} // namespace retractor
