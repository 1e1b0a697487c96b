#include "datasets/segmentation/polar_surface.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::datasets::segmentation {

namespace {

    /// Makes a first guess. In each plane, unknown values are interpolated between known neighbours. A plane without
    /// known values takes the values of the nearest plane with known values.
    void guess(PolarField& field, const std::vector<std::uint8_t>& known)
    {
        std::vector<int> filled;
        for (int k = 0; k < field.planes; ++k) {
            const std::size_t row = PolarField::offset(0, k);
            std::vector<int> at;
            for (int a = 0; a < kAngles; ++a)
                if (known[row + static_cast<std::size_t>(a)] != 0)
                    at.push_back(a);
            if (at.empty())
                continue;
            filled.push_back(k);
            for (std::size_t n = 0; n < at.size(); ++n) {
                const int from = at[n];
                const int to = n + 1 < at.size() ? at[n + 1] : at[0] + kAngles;
                const float first = field.values[row + static_cast<std::size_t>(from)];
                const float last = field.values[row + static_cast<std::size_t>(to % kAngles)];
                for (int a = from + 1; a < to; ++a)
                    field.values[row + static_cast<std::size_t>(a % kAngles)]
                        = first + (last - first) * static_cast<float>(a - from) / static_cast<float>(to - from);
            }
        }
        for (int k = 0; k < field.planes && !filled.empty(); ++k) {
            const auto above = std::lower_bound(filled.begin(), filled.end(), k);
            const int source = above == filled.end()                       ? filled.back()
                : above == filled.begin() || *above - k < k - *(above - 1) ? *above
                                                                           : *(above - 1);
            if (source != k)
                std::copy_n(field.values.begin() + static_cast<std::ptrdiff_t>(PolarField::offset(0, source)), kAngles,
                    field.values.begin() + static_cast<std::ptrdiff_t>(PolarField::offset(0, k)));
        }
    }

} // namespace

void complete(PolarField& field, const std::vector<std::uint8_t>& known)
{
    constexpr int kSweeps = 250;
    constexpr float kOverRelaxation = 1.9F; // suits gaps of up to about 60 cells
    constexpr float kDone = 0.01F; // mm per sweep
    if (std::find(known.begin(), known.end(), std::uint8_t { 1 }) == known.end())
        return;
    RETRACTOR_ASSERT(known.size() == field.values.size());
    guess(field, known);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        float largest = 0.0F;
        for (int k = 0; k < field.planes; ++k)
            for (int a = 0; a < kAngles; ++a) {
                const std::size_t at = PolarField::offset(a, k);
                if (known[at] != 0)
                    continue;
                const float left = field.values[PolarField::offset((a + kAngles - 1) % kAngles, k)];
                const float right = field.values[PolarField::offset((a + 1) % kAngles, k)];
                const float below = field.values[PolarField::offset(a, std::max(0, k - 1))];
                const float above = field.values[PolarField::offset(a, std::min(field.planes - 1, k + 1))];
                const float change = kOverRelaxation * (0.25F * (left + right + below + above) - field.values[at]);
                field.values[at] += change;
                largest = std::max(largest, std::abs(change));
            }
        if (largest < kDone)
            break;
    }
}

Mask inside_surface(
    const Extent& extent, const PolarAxis& axis, const PolarField& radius, const Mask& limit, int threads)
{
    Mask out(limit.size(), 0);
    const auto plane = static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]);
    for_planes(extent.size[2], threads, [&](int k) {
        std::size_t v = static_cast<std::size_t>(k) * plane;
        const float* row = radius.values.data() + PolarField::offset(0, k);
        for (int j = 0; j < extent.size[1]; ++j)
            for (int i = 0; i < extent.size[0]; ++i, ++v) {
                if (limit[v] == 0)
                    continue;
                const double dx = (i - axis.x[static_cast<std::size_t>(k)]) * extent.spacing[0];
                const double dy = (j - axis.y[static_cast<std::size_t>(k)]) * extent.spacing[1];
                double turn = std::atan2(dx, dy) / (2.0 * std::numbers::pi);
                turn = (turn < 0.0 ? turn + 1.0 : turn) * kAngles;
                const int a = static_cast<int>(turn);
                const auto part = static_cast<float>(turn - a);
                const float low = row[a % kAngles];
                const float r = low + part * (row[(a + 1) % kAngles] - low);
                out[v] = std::hypot(dx, dy) < r ? 1 : 0;
            }
    });
    return out;
}

} // namespace retractor::datasets::segmentation
