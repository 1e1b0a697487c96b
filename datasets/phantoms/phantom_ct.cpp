#include "datasets/phantoms/phantom_ct.h"

#include "datasets/phantoms/phantom_shapes.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace retractor::datasets {

namespace {

    /// Blurs with weights (1 2 1)/4 along one axis. The border value is repeated outside.
    void blur_axis(std::span<float> values, const mesh::ImageGrid& grid, std::size_t axis)
    {
        const auto stride = static_cast<std::size_t>(axis == 0 ? 1
                : axis == 1                                    ? grid.size[0]
                                                               : grid.size[0] * grid.size[1]);
        const auto count = static_cast<std::size_t>(grid.size[axis]);
        const std::size_t block = stride * count;
        // Neighbouring lines are processed together, so that memory is read in order for every axis.
        std::vector<float> before(stride);
        for (std::size_t start = 0; start < values.size(); start += block) {
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(start), stride, before.begin());
            for (std::size_t n = 0; n < count; ++n)
                for (std::size_t s = 0; s < stride; ++s) {
                    const std::size_t at = start + n * stride + s;
                    const float here = values[at];
                    const float after = n + 1 < count ? values[at + stride] : here;
                    values[at] = 0.25F * before[s] + 0.5F * here + 0.25F * after;
                    before[s] = here;
                }
        }
    }

} // namespace

mesh::Volume render_ct(const mesh::ImageGrid& grid, std::span<float> ideal_hu, double noise_hu, std::uint64_t seed)
{
    constexpr double kLowest = -1024.0;
    constexpr double kHighest = 3071.0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        blur_axis(ideal_hu, grid, axis);
    mesh::Volume ct { grid, std::vector<std::int16_t>(ideal_hu.size()) };
    for (std::size_t v = 0; v < ideal_hu.size(); ++v) {
        const double hu
            = static_cast<double>(ideal_hu[v]) + (noise_hu > 0.0 ? noise_hu * gaussian_noise(seed, v) : 0.0);
        ct.voxels[v] = static_cast<std::int16_t>(std::lround(std::clamp(hu, kLowest, kHighest)));
    }
    return ct;
}

void check_parameter(const char* name, double value, double low, double high)
{
    if (value >= low && value <= high)
        return;
    std::ostringstream message;
    message << name << " must be between " << low << " and " << high << ", got " << value;
    throw InputError(message.str(), name);
}

} // namespace retractor::datasets
