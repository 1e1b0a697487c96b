#include "fem/statics/largest_force_left.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"

namespace retractor::fem {

std::string largest_force_left(const Points& points, const Eigen::VectorXd& displacement, const Eigen::VectorXd& forces)
{
    RETRACTOR_ASSERT(displacement.size() == 3 * points.rows() && forces.size() == displacement.size());
    if (points.rows() == 0)
        return "no force is left";
    Eigen::Index at = 0;
    for (Eigen::Index v = 1; v < points.rows(); ++v)
        if (forces.segment<3>(3 * v).norm() > forces.segment<3>(3 * at).norm())
            at = v;
    const Vec3 place = points.row(at).transpose() + displacement.segment<3>(3 * at);
    return formatted("the largest force left is %.3g N, at (%.1f, %.1f, %.1f) mm", forces.segment<3>(3 * at).norm(),
        place.x(), place.y(), place.z());
}

} // namespace retractor::fem
