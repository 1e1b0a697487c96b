#include "datasets/segmentation/image/working_image.h"

#include "mesh/base/assert.h"
#include "mesh/image/plane_holes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>
#include <thread>

namespace retractor::datasets::segmentation {

namespace {

    /// Averages boxes of `factor` voxels. An incomplete last box averages the voxels that it has.
    mesh::Volume averaged(const mesh::Volume& ct, const std::array<int, 3>& factor, int threads)
    {
        mesh::Volume out;
        out.grid = ct.grid;
        for (std::size_t axis = 0; axis < 3; ++axis)
            out.grid.size[axis] = (ct.grid.size[axis] + factor[axis] - 1) / factor[axis];
        const Vec3 shift(0.5 * (factor[0] - 1), 0.5 * (factor[1] - 1), 0.5 * (factor[2] - 1));
        out.grid.origin = ct.grid.world(shift);
        out.grid.spacing = ct.grid.spacing.cwiseProduct(Vec3(factor[0], factor[1], factor[2]));
        out.voxels.resize(out.grid.voxel_count());
        for_planes(out.grid.size[2], threads, [&](int k) {
            const auto nx = static_cast<std::size_t>(out.grid.size[0]);
            std::vector<int> sum(nx);
            std::vector<int> count(nx);
            for (int j = 0; j < out.grid.size[1]; ++j) {
                std::fill(sum.begin(), sum.end(), 0);
                std::fill(count.begin(), count.end(), 0);
                for (int c = k * factor[2]; c < std::min((k + 1) * factor[2], ct.grid.size[2]); ++c)
                    for (int b = j * factor[1]; b < std::min((j + 1) * factor[1], ct.grid.size[1]); ++b) {
                        const std::size_t row = ct.grid.offset(0, b, c);
                        for (int a = 0; a < ct.grid.size[0]; ++a) {
                            const auto cell = static_cast<std::size_t>(a / factor[0]);
                            sum[cell] += std::max(ct.voxels[row + static_cast<std::size_t>(a)], kOutsideHu);
                            ++count[cell];
                        }
                    }
                const std::size_t row = out.grid.offset(0, j, k);
                for (std::size_t i = 0; i < nx; ++i)
                    out.voxels[row + i] = static_cast<std::int16_t>(sum[i] / count[i]);
            }
        });
        return out;
    }

    /// The low and the high corner of the image's box in the world, which includes the outer faces of the voxels.
    std::array<Vec3, 2> world_box(const mesh::ImageGrid& ct)
    {
        Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
        Vec3 high = -low;
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 index;
            for (int axis = 0; axis < 3; ++axis)
                index[axis] = (corner >> axis & 1) != 0 ? ct.size[static_cast<std::size_t>(axis)] - 0.5 : -0.5;
            low = low.cwiseMin(ct.world(index));
            high = high.cwiseMax(ct.world(index));
        }
        return { low, high };
    }

    /// Number of voxels along an axis, as a double, because a caller may request more than an int can hold.
    double voxels_along(double length, double spacing_mm) { return std::max(1.0, std::round(length / spacing_mm)); }

    mesh::ImageGrid world_grid(const mesh::ImageGrid& ct, double spacing_mm)
    {
        const auto [low, high] = world_box(ct);
        mesh::ImageGrid grid;
        grid.spacing = Vec3::Constant(spacing_mm);
        for (int axis = 0; axis < 3; ++axis) {
            const double length = high[axis] - low[axis];
            const int count = static_cast<int>(voxels_along(length, spacing_mm));
            grid.size[static_cast<std::size_t>(axis)] = count;
            grid.origin[axis] = low[axis] + 0.5 * (length - (count - 1) * spacing_mm);
        }
        return grid;
    }

    /// Trilinear interpolation. The outer half voxel has the border's value.
    std::int16_t sample(const mesh::Volume& ct, const Vec3& at)
    {
        constexpr double kRound = 1e-6; // voxels; the faces of the grid count as inside
        std::array<int, 3> cell {};
        std::array<float, 3> part {};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            if (at[axis] < -0.5 - kRound || at[axis] > ct.grid.size[a] - 0.5 + kRound)
                return kOutsideHu;
            const double inside = std::clamp(at[axis], 0.0, static_cast<double>(ct.grid.size[a] - 1));
            cell[a] = std::min(static_cast<int>(inside), std::max(0, ct.grid.size[a] - 2));
            part[a] = static_cast<float>(inside - cell[a]);
        }
        const std::size_t first = ct.grid.offset(cell[0], cell[1], cell[2]);
        const std::size_t dx = ct.grid.size[0] > 1 ? 1 : 0;
        const std::size_t dy = ct.grid.size[1] > 1 ? static_cast<std::size_t>(ct.grid.size[0]) : 0;
        const std::size_t dz = ct.grid.size[2] > 1
            ? static_cast<std::size_t>(ct.grid.size[0]) * static_cast<std::size_t>(ct.grid.size[1])
            : 0;
        const auto line = [&](std::size_t v) {
            const auto low = static_cast<float>(std::max(ct.voxels[v], kOutsideHu));
            return low + part[0] * (static_cast<float>(std::max(ct.voxels[v + dx], kOutsideHu)) - low);
        };
        const auto plane = [&](std::size_t v) { return line(v) + part[1] * (line(v + dy) - line(v)); };
        return static_cast<std::int16_t>(std::lround(plane(first) + part[2] * (plane(first + dz) - plane(first))));
    }

    Mask combined(const Mask& a, const Mask& b, bool (*keep)(bool, bool))
    {
        RETRACTOR_ASSERT(a.size() == b.size());
        Mask out(a.size());
        for (std::size_t v = 0; v < a.size(); ++v)
            out[v] = keep(a[v] != 0, b[v] != 0) ? 1 : 0;
        return out;
    }

    /// Computes sums over a window along one axis. The border's value is repeated outside.
    void window_sums(
        const Extent& extent, std::vector<std::uint16_t>& values, std::size_t axis, int radius, int threads)
    {
        const std::array<std::size_t, 3> stride { 1, static_cast<std::size_t>(extent.size[0]),
            static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]) };
        const int count = extent.size[axis];
        // Planes along another axis than the summed axis are independent of each other.
        const std::size_t outer = axis == 2 ? 1 : 2;
        const std::size_t inner = 3 - axis - outer;
        for_planes(extent.size[outer], threads, [&](int n) {
            std::vector<int> line(static_cast<std::size_t>(count));
            for (int m = 0; m < extent.size[inner]; ++m) {
                const std::size_t first
                    = static_cast<std::size_t>(n) * stride[outer] + static_cast<std::size_t>(m) * stride[inner];
                for (int c = 0; c < count; ++c)
                    line[static_cast<std::size_t>(c)] = values[first + static_cast<std::size_t>(c) * stride[axis]];
                const auto at = [&](int c) { return line[static_cast<std::size_t>(std::clamp(c, 0, count - 1))]; };
                int sum = 0;
                for (int c = -radius; c <= radius; ++c)
                    sum += at(c);
                for (int c = 0; c < count; ++c) {
                    values[first + static_cast<std::size_t>(c) * stride[axis]] = static_cast<std::uint16_t>(sum);
                    sum += at(c + radius + 1) - at(c - radius);
                }
            }
        });
    }

    /// Calls visit(voxel, neighbour) for all neighbours over faces within the grid.
    template <typename Visit> void for_faces(const Extent& extent, const Visit& visit)
    {
        const auto nx = static_cast<std::size_t>(extent.size[0]);
        const std::size_t nxy = nx * static_cast<std::size_t>(extent.size[1]);
        std::size_t v = 0;
        for (int k = 0; k < extent.size[2]; ++k)
            for (int j = 0; j < extent.size[1]; ++j)
                for (int i = 0; i < extent.size[0]; ++i, ++v) {
                    if (i > 0)
                        visit(v, v - 1);
                    if (i + 1 < extent.size[0])
                        visit(v, v + 1);
                    if (j > 0)
                        visit(v, v - nx);
                    if (j + 1 < extent.size[1])
                        visit(v, v + nx);
                    if (k > 0)
                        visit(v, v - nxy);
                    if (k + 1 < extent.size[2])
                        visit(v, v + nxy);
                }
    }

} // namespace

void for_planes(int count, int threads, const std::function<void(int)>& work)
{
    std::atomic<int> next { 0 };
    std::mutex mutex;
    std::exception_ptr failure;
    const auto take = [&] {
        try {
            for (int k = next++; k < count; k = next++)
                work(k);
        } catch (...) {
            const std::scoped_lock lock(mutex);
            if (failure == nullptr)
                failure = std::current_exception();
            next = count; // no thread begins another plane
        }
    };
    {
        std::vector<std::jthread> helpers;
        for (int t = 1; t < std::min(threads, count); ++t)
            helpers.emplace_back(take);
        take();
    }
    if (failure != nullptr)
        std::rethrow_exception(failure);
}

EmptyEnds empty_ends(const mesh::Volume& ct)
{
    EmptyEnds ends;
    ct.grid.direction.row(2).cwiseAbs().maxCoeff(&ends.axis);
    const std::array<int, 3>& size = ct.grid.size;
    const auto axis = static_cast<std::size_t>(ends.axis);
    const auto is_empty = [&](int plane) {
        std::array<int, 3> low { 0, 0, 0 }, high { size[0] - 1, size[1] - 1, size[2] - 1 };
        low[axis] = high[axis] = plane;
        const std::int16_t value = ct.voxels[ct.grid.offset(low[0], low[1], low[2])];
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i)
                    if (ct.voxels[ct.grid.offset(i, j, k)] != value)
                        return false;
        return true;
    };
    while (ends.before < size[axis] && is_empty(ends.before))
        ++ends.before;
    if (ends.before == size[axis])
        return { .axis = ends.axis };
    while (is_empty(size[axis] - 1 - ends.after))
        ++ends.after;
    return ends;
}

mesh::Volume without(const mesh::Volume& ct, const EmptyEnds& ends)
{
    const auto axis = static_cast<std::size_t>(ends.axis);
    RETRACTOR_ASSERT(ends.before >= 0 && ends.after >= 0 && ends.before + ends.after < ct.grid.size[axis]);
    mesh::Volume rest;
    rest.grid = ct.grid;
    rest.grid.size[axis] -= ends.before + ends.after;
    std::array<int, 3> first { 0, 0, 0 };
    first[axis] = ends.before;
    rest.grid.origin = ct.grid.world(Vec3(first[0], first[1], first[2]));
    rest.voxels.reserve(rest.grid.voxel_count());
    for (int k = 0; k < rest.grid.size[2]; ++k)
        for (int j = 0; j < rest.grid.size[1]; ++j) {
            const auto row
                = ct.voxels.begin() + static_cast<std::ptrdiff_t>(ct.grid.offset(first[0], j + first[1], k + first[2]));
            rest.voxels.insert(rest.voxels.end(), row, row + rest.grid.size[0]);
        }
    return rest;
}

double working_voxels(const mesh::ImageGrid& ct, double spacing_mm)
{
    const auto [low, high] = world_box(ct);
    double count = 1.0;
    for (int axis = 0; axis < 3; ++axis)
        count *= voxels_along(high[axis] - low[axis], spacing_mm);
    return count;
}

WorkingImage working_image(const mesh::Volume& ct, double spacing_mm, int threads)
{
    std::array<int, 3> factor { 1, 1, 1 };
    for (int axis = 0; axis < 3; ++axis)
        // For a grid of 1.5 mm, voxels of 0.7 mm are averaged in pairs. Voxels of 0.9 mm are not, because pairs would
        // blur too much.
        factor[static_cast<std::size_t>(axis)]
            = std::max(1, static_cast<int>(std::floor(spacing_mm / ct.grid.spacing[axis] + 0.3)));
    const bool finer = factor != std::array<int, 3> { 1, 1, 1 };
    const mesh::Volume coarse = finer ? averaged(ct, factor, threads) : mesh::Volume {};
    const mesh::Volume& source = finer ? coarse : ct;
    WorkingImage image;
    image.grid = world_grid(ct.grid, spacing_mm);
    image.hu.resize(image.grid.voxel_count());
    for_planes(image.grid.size[2], threads, [&](int k) {
        std::size_t v = image.grid.offset(0, 0, k);
        for (int j = 0; j < image.grid.size[1]; ++j) {
            const Vec3 first = source.grid.index(image.grid.world(Vec3(0, j, k)));
            const Vec3 step = source.grid.index(image.grid.world(Vec3(1, j, k))) - first;
            for (int i = 0; i < image.grid.size[0]; ++i, ++v)
                image.hu[v] = sample(source, first + i * step);
        }
    });
    return image;
}

std::size_t count_set(const Mask& mask) { return std::accumulate(mask.begin(), mask.end(), std::size_t { 0 }); }

double volume_ml(const Extent& extent, const Mask& mask)
{
    constexpr double kMillilitre = 1000.0; // mm^3
    return static_cast<double>(count_set(mask)) * extent.spacing[0] * extent.spacing[1] * extent.spacing[2]
        / kMillilitre;
}

Mask united(const Mask& a, const Mask& b)
{
    return combined(a, b, [](bool x, bool y) { return x || y; });
}

Mask common(const Mask& a, const Mask& b)
{
    return combined(a, b, [](bool x, bool y) { return x && y; });
}

Mask without(const Mask& a, const Mask& b)
{
    return combined(a, b, [](bool x, bool y) { return x && !y; });
}

Extent coarse_extent(const Extent& extent, int factor)
{
    Extent out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        out.size[axis] = (extent.size[axis] + factor - 1) / factor;
        out.spacing[axis] = extent.spacing[axis] * factor;
    }
    return out;
}

Mask coarse_mask(const Extent& extent, const Mask& mask, int factor, double share)
{
    RETRACTOR_ASSERT(factor >= 1 && mask.size() == extent.voxel_count());
    const Extent cells = coarse_extent(extent, factor);
    std::vector<std::uint16_t> set(cells.voxel_count(), 0);
    std::vector<std::uint16_t> all(cells.voxel_count(), 0);
    std::size_t v = 0;
    for (int k = 0; k < extent.size[2]; ++k)
        for (int j = 0; j < extent.size[1]; ++j) {
            const std::size_t row = (static_cast<std::size_t>(k / factor) * static_cast<std::size_t>(cells.size[1])
                                        + static_cast<std::size_t>(j / factor))
                * static_cast<std::size_t>(cells.size[0]);
            for (int i = 0; i < extent.size[0]; ++i, ++v) {
                const std::size_t cell = row + static_cast<std::size_t>(i / factor);
                set[cell] = static_cast<std::uint16_t>(set[cell] + mask[v]);
                ++all[cell];
            }
        }
    Mask out(set.size());
    for (std::size_t c = 0; c < out.size(); ++c)
        out[c] = set[c] > 0 && set[c] >= share * all[c] ? 1 : 0;
    return out;
}

Mask majority(const Extent& extent, const Mask& mask, int radius_voxels, int threads)
{
    RETRACTOR_ASSERT(radius_voxels >= 0 && mask.size() == extent.voxel_count());
    std::vector<std::uint16_t> sums(mask.begin(), mask.end());
    for (std::size_t axis = 0; axis < 3; ++axis)
        window_sums(extent, sums, axis, radius_voxels, threads);
    const int width = 2 * radius_voxels + 1;
    const int half = width * width * width / 2;
    Mask out(mask.size());
    std::transform(
        sums.begin(), sums.end(), out.begin(), [half](int sum) { return static_cast<std::uint8_t>(sum > half); });
    return out;
}

Mask shrunk_by_a_voxel(const Extent& extent, const Mask& mask)
{
    RETRACTOR_ASSERT(mask.size() == extent.voxel_count());
    Mask out = mask;
    for_faces(extent, [&](std::size_t v, std::size_t neighbour) {
        if (mask[neighbour] == 0)
            out[v] = 0;
    });
    return out;
}

Mask grown_by_a_voxel(const Extent& extent, const Mask& mask, const Mask& limit)
{
    RETRACTOR_ASSERT(mask.size() == extent.voxel_count() && limit.size() == mask.size());
    Mask out = mask;
    for_faces(extent, [&](std::size_t v, std::size_t neighbour) {
        if (mask[neighbour] != 0 && limit[v] != 0)
            out[v] = 1;
    });
    return out;
}

Mask small_holes_filled_in_planes(const Extent& extent, const Mask& mask, int axis, double most_mm2)
{
    Mask out = mask;
    const auto a = static_cast<std::size_t>(axis);
    const Mask holes = without(mesh::holes_filled_in_planes(extent.size, mask, axis), mask);
    // The pieces are flat: only the two axes in the plane connect voxels.
    const std::array<std::size_t, 3> stride { 1, static_cast<std::size_t>(extent.size[0]),
        static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]) };
    const std::size_t u = a == 0 ? 1 : 0;
    const std::size_t w = a == 2 ? 1 : 2;
    const auto most = static_cast<std::size_t>(most_mm2 / (extent.spacing[u] * extent.spacing[w]));
    Mask seen(mask.size(), 0);
    std::vector<std::size_t> area;
    for (std::size_t start = 0; start < holes.size(); ++start) {
        if (holes[start] == 0 || seen[start] != 0)
            continue;
        area.assign(1, start);
        seen[start] = 1;
        for (std::size_t n = 0; n < area.size(); ++n)
            for (const std::size_t side : { u, w }) {
                // A hole never touches the grid's border, so the neighbours exist.
                for (const std::size_t next : { area[n] - stride[side], area[n] + stride[side] })
                    if (holes[next] != 0 && seen[next] == 0) {
                        seen[next] = 1;
                        area.push_back(next);
                    }
            }
        if (area.size() <= most)
            for (const std::size_t v : area)
                out[v] = 1;
    }
    return out;
}

Mask small_holes_filled(const Extent& extent, const Mask& mask, double most_mm2)
{
    Mask out = mask;
    for (int axis = 0; axis < 3; ++axis)
        out = united(out, small_holes_filled_in_planes(extent, mask, axis, most_mm2));
    return out;
}

} // namespace retractor::datasets::segmentation
