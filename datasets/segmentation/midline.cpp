#include "datasets/segmentation/midline.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

std::vector<PlaneExtents> plane_extents(const Extent& extent, const Mask& mask)
{
    RETRACTOR_ASSERT(mask.size() == extent.voxel_count());
    std::vector<PlaneExtents> planes(static_cast<std::size_t>(extent.size[2]));
    std::size_t v = 0;
    for (int k = 0; k < extent.size[2]; ++k)
        for (int j = 0; j < extent.size[1]; ++j)
            for (int i = 0; i < extent.size[0]; ++i, ++v)
                if (mask[v] != 0) {
                    PlaneExtents& p = planes[static_cast<std::size_t>(k)];
                    p.low_x = std::min(p.low_x, static_cast<double>(i));
                    p.high_x = std::max(p.high_x, static_cast<double>(i));
                    p.low_y = std::min(p.low_y, static_cast<double>(j));
                    p.high_y = std::max(p.high_y, static_cast<double>(j));
                }
    return planes;
}

std::vector<double> smooth_line(std::vector<double> values, int reach)
{
    std::vector<double> whole = values;
    const int count = static_cast<int>(values.size());
    for (int k = 0; k < count; ++k)
        for (int step = 1; std::isnan(whole[static_cast<std::size_t>(k)]) && step < count; ++step)
            for (const int other : { k - step, k + step })
                if (other >= 0 && other < count && !std::isnan(values[static_cast<std::size_t>(other)]))
                    whole[static_cast<std::size_t>(k)] = values[static_cast<std::size_t>(other)];
    for (int k = 0; k < count; ++k) {
        double sum = 0.0;
        const int from = std::max(0, k - reach);
        const int to = std::min(count - 1, k + reach);
        for (int other = from; other <= to; ++other)
            sum += whole[static_cast<std::size_t>(other)];
        values[static_cast<std::size_t>(k)] = sum / (to - from + 1);
    }
    return values;
}

std::vector<double> spine_front(const Extent& extent, const Mask& spine, const std::vector<double>& middle_x)
{
    constexpr double kHalfWidth = 9.0; // mm; half-width of the middle part of a vertebral body
    std::vector<double> front(static_cast<std::size_t>(extent.size[2]), std::nan(""));
    for (int k = 0; k < extent.size[2]; ++k) {
        const double x = middle_x[static_cast<std::size_t>(k)];
        const int reach = static_cast<int>(kHalfWidth / extent.spacing[0]);
        for (int j = 0; j < extent.size[1] && std::isnan(front[static_cast<std::size_t>(k)]); ++j)
            for (int i = static_cast<int>(x) - reach; i <= static_cast<int>(x) + reach; ++i)
                if (i >= 0 && i < extent.size[0]
                    && spine[(static_cast<std::size_t>(k) * static_cast<std::size_t>(extent.size[1])
                                 + static_cast<std::size_t>(j))
                               * static_cast<std::size_t>(extent.size[0])
                           + static_cast<std::size_t>(i)]
                        != 0)
                    front[static_cast<std::size_t>(k)] = j;
    }
    return front;
}

std::pair<int, int> plane_range(const std::vector<PlaneExtents>& planes)
{
    int first = -1;
    int last = -1;
    for (int k = 0; k < static_cast<int>(planes.size()); ++k)
        if (!planes[static_cast<std::size_t>(k)].empty()) {
            first = first < 0 ? k : first;
            last = k;
        }
    return { first, last };
}

} // namespace retractor::datasets::segmentation
