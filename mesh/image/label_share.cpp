#include "mesh/image/label_share.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace retractor::mesh {

double label_share(const LabelVolume& labels, const LabelFlags& mask, const Vec3& point)
{
    const Vec3 index = labels.grid.index(point);
    if (!index.allFinite() || index.cwiseAbs().maxCoeff() > 1e6)
        return 0.0;
    const Vec3 low = index.array().floor();
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        std::array<int, 3> voxel {};
        double weight = 1.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int step = corner >> axis & 1;
            const auto a = static_cast<Eigen::Index>(axis);
            voxel[axis] = static_cast<int>(low[a]) + step;
            const double t = index[a] - low[a];
            weight *= step == 1 ? t : 1.0 - t;
        }
        if (labels.grid.contains(voxel[0], voxel[1], voxel[2])
            && mask[labels.voxels[labels.grid.offset(voxel[0], voxel[1], voxel[2])]] != 0)
            sum += weight;
    }
    return sum;
}

} // namespace retractor::mesh
