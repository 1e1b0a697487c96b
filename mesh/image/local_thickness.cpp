#include "mesh/image/local_thickness.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace retractor::mesh {

namespace {

    /// One-dimensional squared distance transform of a run of equal labels: out[i] = min over j of f[j] + (h (i - j))^2
    /// (Felzenszwalb and Huttenlocher 2012). The result is bounded by the distance to the run's ends.
    class RunTransform {
    public:
        explicit RunTransform(std::size_t longest)
            : site_(longest)
            , from_(longest + 1)
            , f_(longest)
        {
        }

        void operator()(float* values, std::size_t stride, int n, double h)
        {
            for (int i = 0; i < n; ++i)
                f_[u(i)] = values[u(i) * stride];
            int k = 0;
            site_[0] = 0;
            from_[0] = -std::numeric_limits<double>::infinity();
            from_[1] = -from_[0];
            for (int q = 1; q < n; ++q) {
                double s = meet(q, site_[u(k)], h);
                while (s <= from_[u(k)])
                    s = meet(q, site_[u(--k)], h);
                site_[u(++k)] = q;
                from_[u(k)] = s;
                from_[u(k + 1)] = std::numeric_limits<double>::infinity();
            }
            k = 0;
            for (int i = 0; i < n; ++i) {
                while (from_[u(k + 1)] < i)
                    ++k;
                const double along = h * (i - site_[u(k)]);
                const double end = h * (std::min(i, n - 1 - i) + 0.5);
                values[u(i) * stride] = static_cast<float>(std::min(f_[u(site_[u(k)])] + along * along, end * end));
            }
        }

    private:
        static std::size_t u(int i) { return static_cast<std::size_t>(i); }
        double meet(int q, int p, double h) const
        {
            return ((f_[u(q)] - f_[u(p)]) / (h * h) + static_cast<double>(q) * q - static_cast<double>(p) * p)
                / (2.0 * (q - p));
        }
        std::vector<int> site_;
        std::vector<double> from_, f_;
    };

    void transform_axis(const WallVoxels& wall, std::vector<float>& squared, std::size_t axis)
    {
        const std::size_t strides[3] = { 1, wall.offset(0, 1, 0), wall.offset(0, 0, 1) };
        const std::size_t a1 = (axis + 1) % 3, a2 = (axis + 2) % 3;
        const int n = wall.size[axis];
        RunTransform transform(static_cast<std::size_t>(n));
        for (int q = 0; q < wall.size[a2]; ++q)
            for (int p = 0; p < wall.size[a1]; ++p) {
                const std::size_t begin
                    = static_cast<std::size_t>(p) * strides[a1] + static_cast<std::size_t>(q) * strides[a2];
                for (int i = 0; i < n;) {
                    const std::size_t at = begin + static_cast<std::size_t>(i) * strides[axis];
                    int end = i + 1;
                    while (end < n
                        && wall.voxels[begin + static_cast<std::size_t>(end) * strides[axis]] == wall.voxels[at])
                        ++end;
                    if (wall.voxels[at] != 0)
                        transform(squared.data() + at, strides[axis], end - i, wall.spacing[static_cast<int>(axis)]);
                    i = end;
                }
            }
    }

    /// Distance (mm) from each voxel's centre to the nearest face between the voxel's label and another label, measured
    /// along the centres of voxels (exact for flat faces along the axes). Voxels outside have 0.
    std::vector<float> depth_in_label(const WallVoxels& wall)
    {
        constexpr float kFar = 1e12F;
        std::vector<float> depth(wall.voxels.size());
        std::transform(
            wall.voxels.begin(), wall.voxels.end(), depth.begin(), [](std::uint8_t v) { return v == 0 ? 0.0F : kFar; });
        for (std::size_t axis = 0; axis < 3; ++axis)
            transform_axis(wall, depth, axis);
        for (float& d : depth)
            d = std::sqrt(d);
        return depth;
    }

} // namespace

std::vector<float> local_thickness(const WallVoxels& wall)
{
    RETRACTOR_ASSERT(wall.voxels.size() == wall.offset(0, 0, wall.size[2]));
    const std::vector<float> depth = depth_in_label(wall);
    // Every voxel points to its deepest neighbour of the same label; a ridge voxel points to itself.
    std::vector<std::uint32_t> uphill(depth.size());
    std::iota(uphill.begin(), uphill.end(), 0U);
    for (int k = 1; k + 1 < wall.size[2]; ++k)
        for (int j = 1; j + 1 < wall.size[1]; ++j)
            for (int i = 1; i + 1 < wall.size[0]; ++i) {
                const std::size_t at = wall.offset(i, j, k);
                if (wall.voxels[at] == 0)
                    continue;
                std::size_t best = at;
                for (int c = -1; c <= 1; ++c)
                    for (int b = -1; b <= 1; ++b)
                        for (int a = -1; a <= 1; ++a) {
                            const std::size_t other = wall.offset(i + a, j + b, k + c);
                            if (wall.voxels[other] == wall.voxels[at] && depth[other] > depth[best])
                                best = other;
                        }
                uphill[at] = static_cast<std::uint32_t>(best);
            }
    // In a layer of an even number of voxels the ridge lies half a voxel off the middle. The bias is half of the error,
    // because half of all layers are even.
    const auto bias = static_cast<float>(0.5 * wall.spacing.minCoeff());
    std::vector<float> thickness(depth.size(), 0.0F);
    for (std::size_t at = 0; at < depth.size(); ++at) {
        if (wall.voxels[at] == 0)
            continue;
        std::uint32_t ridge = static_cast<std::uint32_t>(at);
        while (uphill[ridge] != ridge) {
            uphill[ridge] = uphill[uphill[ridge]];
            ridge = uphill[ridge];
        }
        thickness[at] = 2.0F * depth[ridge] + bias;
    }
    return thickness;
}

} // namespace retractor::mesh
