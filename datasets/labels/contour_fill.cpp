#include "datasets/labels/contour_fill.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets {

void fill_contour(const mesh::ImageGrid& grid, const Contour& contour, std::vector<std::uint8_t>& voxels)
{
    RETRACTOR_ASSERT(voxels.size() == grid.voxel_count());
    if (contour.points.size() < 3)
        return;
    std::vector<Vec3> corners;
    double k_sum = 0.0;
    for (const Vec3& point : contour.points) {
        corners.push_back(grid.index(point));
        k_sum += corners.back().z();
    }
    const int k = static_cast<int>(std::lround(k_sum / static_cast<double>(corners.size())));
    if (k < 0 || k >= grid.size[2])
        return;
    // Even-odd rule along each row: a row is crossed where an edge passes from below it to above it or back.
    std::vector<double> crossings;
    for (int j = 0; j < grid.size[1]; ++j) {
        crossings.clear();
        for (std::size_t n = 0; n < corners.size(); ++n) {
            const Vec3 &a = corners[n], &b = corners[(n + 1) % corners.size()];
            if ((a.y() <= j) != (b.y() <= j))
                crossings.push_back(a.x() + (j - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
        }
        std::ranges::sort(crossings);
        for (std::size_t n = 0; n + 1 < crossings.size(); n += 2) {
            const int first = std::max(0, static_cast<int>(std::ceil(crossings[n])));
            const int last = std::min(grid.size[0] - 1, static_cast<int>(std::ceil(crossings[n + 1])) - 1);
            for (int i = first; i <= last; ++i)
                voxels[grid.offset(i, j, k)] ^= 1U;
        }
    }
}

} // namespace retractor::datasets
