#include "mesh/image/plane_holes.h"

#include "mesh/base/assert.h"

namespace retractor::mesh {

namespace {

    /// Fills the areas that are not connected to the border of a plane. The plane has `width` x `height` bytes.
    void fill_plane(std::vector<std::uint8_t>& plane, int width, int height, std::vector<int>& stack)
    {
        constexpr std::uint8_t kOutside = 2;
        const auto reach = [&](int x, int y) {
            auto& voxel
                = plane[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
            if (voxel != 0)
                return;
            voxel = kOutside;
            stack.push_back(y * width + x);
        };
        for (int x = 0; x < width; ++x) {
            reach(x, 0);
            reach(x, height - 1);
        }
        for (int y = 0; y < height; ++y) {
            reach(0, y);
            reach(width - 1, y);
        }
        while (!stack.empty()) {
            const int x = stack.back() % width;
            const int y = stack.back() / width;
            stack.pop_back();
            if (x > 0)
                reach(x - 1, y);
            if (x + 1 < width)
                reach(x + 1, y);
            if (y > 0)
                reach(x, y - 1);
            if (y + 1 < height)
                reach(x, y + 1);
        }
        for (auto& voxel : plane)
            voxel = voxel == kOutside ? 0 : 1;
    }

} // namespace

std::vector<std::uint8_t> holes_filled_in_planes(
    const std::array<int, 3>& size, const std::vector<std::uint8_t>& mask, int axis)
{
    RETRACTOR_ASSERT(mask.size()
        == static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]));
    RETRACTOR_ASSERT(axis >= 0 && axis <= 2);
    const std::array<std::size_t, 3> stride { 1, static_cast<std::size_t>(size[0]),
        static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) };
    const auto a = static_cast<std::size_t>(axis);
    const std::size_t u = a == 0 ? 1 : 0;
    const std::size_t w = a == 2 ? 1 : 2;
    std::vector<std::uint8_t> out = mask;
    std::vector<std::uint8_t> plane(static_cast<std::size_t>(size[u]) * static_cast<std::size_t>(size[w]));
    std::vector<int> stack;
    const auto visit_plane = [&](std::size_t first, const auto& visit) {
        std::size_t at = 0;
        for (std::size_t y = 0; y < static_cast<std::size_t>(size[w]); ++y)
            for (std::size_t x = 0; x < static_cast<std::size_t>(size[u]); ++x, ++at)
                visit(out[first + y * stride[w] + x * stride[u]], plane[at]);
    };
    for (std::size_t n = 0; n < static_cast<std::size_t>(size[a]); ++n) {
        visit_plane(n * stride[a], [](std::uint8_t voxel, std::uint8_t& copy) { copy = voxel != 0 ? 1 : 0; });
        fill_plane(plane, size[u], size[w], stack);
        visit_plane(n * stride[a], [](std::uint8_t& voxel, std::uint8_t copy) { voxel = copy; });
    }
    return out;
}

} // namespace retractor::mesh
