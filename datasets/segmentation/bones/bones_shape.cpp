// Turns the voxels of a bone into a body for the mesher: solid, in one piece, and not touching the next bone.

#include "datasets/segmentation/bones/bones_steps.h"
#include "mesh/image/plane_holes.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    /// A part of the working grid with a border of empty voxels.
    struct LocalBox {
        std::array<int, 3> low {}, size {};
        Mask mask;

        std::size_t at(int i, int j, int k) const
        {
            return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j))
                * static_cast<std::size_t>(size[0])
                + static_cast<std::size_t>(i);
        }
    };

    LocalBox local_box(const mesh::ImageGrid& grid, const std::vector<Voxel>& voxels, const std::vector<Vec3>& line)
    {
        constexpr int kBorder = 4;
        const auto nx = static_cast<Voxel>(grid.size[0]), ny = static_cast<Voxel>(grid.size[1]);
        std::array<int, 3> low = grid.size, high { 0, 0, 0 };
        const auto include = [&](const std::array<int, 3>& p) {
            for (std::size_t a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        };
        const auto indices = [&](Voxel v) {
            return std::array<int, 3> { static_cast<int>(v % nx), static_cast<int>((v / nx) % ny),
                static_cast<int>(v / (nx * ny)) };
        };
        for (const Voxel v : voxels)
            include(indices(v));
        for (const Vec3& p : line) {
            const Vec3 x = grid.index(p);
            include({ static_cast<int>(x[0]), static_cast<int>(x[1]), static_cast<int>(x[2]) });
        }
        LocalBox box;
        for (std::size_t a = 0; a < 3; ++a) {
            box.low[a] = low[a] - kBorder;
            box.size[a] = high[a] - low[a] + 1 + 2 * kBorder;
        }
        box.mask.assign(static_cast<std::size_t>(box.size[0]) * static_cast<std::size_t>(box.size[1])
                * static_cast<std::size_t>(box.size[2]),
            0);
        for (const Voxel v : voxels) {
            const auto p = indices(v);
            box.mask[box.at(p[0] - box.low[0], p[1] - box.low[1], p[2] - box.low[2])] = 1;
        }
        return box;
    }

    /// Grows the voxels of this value by one voxel along each axis in turn, with a box of 3 x 3 x 3. Growing the
    /// complement shrinks the mask.
    void grow(LocalBox& box, std::uint8_t value)
    {
        const std::array<std::size_t, 3> strides { 1, static_cast<std::size_t>(box.size[0]),
            static_cast<std::size_t>(box.size[0]) * static_cast<std::size_t>(box.size[1]) };
        for (const std::size_t stride : strides) {
            const Mask before = box.mask;
            for (std::size_t v = stride; v + stride < before.size(); ++v)
                if (before[v - stride] == value || before[v + stride] == value)
                    box.mask[v] = value;
        }
    }

    void close_and_fill(LocalBox& box, double spacing)
    {
        constexpr double kClose = 2.0; // mm
        const int steps = std::clamp(static_cast<int>(std::lround(kClose / spacing)), 1, 3);
        const Mask before = box.mask;
        for (int n = 0; n < steps; ++n)
            grow(box, 1);
        const Extent extent { box.size, { spacing, spacing, spacing } };
        for (int axis = 0; axis < 3; ++axis)
            box.mask = mesh::holes_filled_in_planes(extent.size, box.mask, axis);
        for (int n = 0; n < steps; ++n)
            grow(box, 0);
        for (std::size_t v = 0; v < before.size(); ++v)
            box.mask[v] = box.mask[v] | before[v];
    }

    void draw_tube(LocalBox& box, const mesh::ImageGrid& grid, const Vec3& a, const Vec3& b, double radius)
    {
        const Vec3 low = a.cwiseMin(b).array() - radius, high = a.cwiseMax(b).array() + radius;
        const Vec3 first = grid.index(low), last = grid.index(high);
        const Vec3 along = b - a;
        const double square = std::max(along.squaredNorm(), 1e-12);
        for (int k = static_cast<int>(std::ceil(first[2])); k <= last[2]; ++k)
            for (int j = static_cast<int>(std::ceil(first[1])); j <= last[1]; ++j)
                for (int i = static_cast<int>(std::ceil(first[0])); i <= last[0]; ++i) {
                    const Vec3 p = grid.world(Vec3(i, j, k));
                    const double t = std::clamp((p - a).dot(along) / square, 0.0, 1.0);
                    if ((p - a - t * along).norm() > radius)
                        continue;
                    const int x = i - box.low[0], y = j - box.low[1], z = k - box.low[2];
                    if (x >= 0 && y >= 0 && z >= 0 && x < box.size[0] && y < box.size[1] && z < box.size[2])
                        box.mask[box.at(x, y, z)] = 1;
                }
    }

} // namespace

void make_solid(const mesh::ImageGrid& grid, std::vector<Label>& labels, Label label, const std::vector<Vec3>& line,
    const std::vector<Label>& yielding)
{
    // Radius in mm. The tube keeps a rib in one piece where the image or a neighbour interrupts the rib.
    constexpr double kTubeRadius = 2.6;
    std::vector<Voxel> voxels;
    for (Voxel v = 0; v < labels.size(); ++v)
        if (labels[v] == label)
            voxels.push_back(v);
    if (voxels.empty())
        return;
    LocalBox box = local_box(grid, voxels, line);
    for (std::size_t n = 1; n < line.size(); ++n)
        draw_tube(box, grid, line[n - 1], line[n], kTubeRadius);
    const Mask firm = box.mask; // the bone's own voxels and the tube
    close_and_fill(box, grid.spacing.x());
    // Keeps only connected voxels that belong to no other bone.
    const auto outside = [&](int i, int j, int k) { return !grid.contains(i, j, k); };
    std::size_t v = 0;
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i, ++v) {
                const int x = i + box.low[0], y = j + box.low[1], z = k + box.low[2];
                if (!box.mask[v])
                    continue;
                if (outside(x, y, z)) {
                    box.mask[v] = 0;
                    continue;
                }
                const Label there = labels[grid.offset(x, y, z)];
                const bool yields = firm[v] && std::find(yielding.begin(), yielding.end(), there) != yielding.end();
                box.mask[v] = there == 0 || there == label || yields;
            }
    const Extent extent { box.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } };
    box.mask = largest_piece(extent, box.mask);
    for (const Voxel u : voxels)
        labels[u] = 0;
    v = 0;
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i, ++v)
                if (box.mask[v])
                    labels[grid.offset(i + box.low[0], j + box.low[1], k + box.low[2])] = label;
}

void keep_largest_pieces(
    const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& which, Label rest)
{
    const auto nx = static_cast<Voxel>(grid.size[0]), ny = static_cast<Voxel>(grid.size[1]);
    const auto nz = static_cast<Voxel>(grid.size[2]);
    const Voxel slice = nx * ny;
    std::vector<std::uint8_t> seen(labels.size(), 0);
    std::vector<std::vector<Voxel>> largest(std::size_t { 1 } << 16);
    std::vector<std::uint8_t> wanted(std::size_t { 1 } << 16, 0);
    for (const Label l : which)
        wanted[l] = 1;
    std::vector<Voxel> piece;
    for (Voxel seed = 0; seed < labels.size(); ++seed) {
        const Label label = labels[seed];
        if (!wanted[label] || seen[seed])
            continue;
        piece.assign(1, seed);
        seen[seed] = 1;
        for (std::size_t n = 0; n < piece.size(); ++n) {
            const Voxel v = piece[n], i = v % nx, j = (v / nx) % ny, k = v / slice;
            const auto visit = [&](bool inside, Voxel u) {
                if (inside && labels[u] == label && !seen[u]) {
                    seen[u] = 1;
                    piece.push_back(u);
                }
            };
            visit(i > 0, v - 1);
            visit(i + 1 < nx, v + 1);
            visit(j > 0, v - nx);
            visit(j + 1 < ny, v + nx);
            visit(k > 0, v - slice);
            visit(k + 1 < nz, v + slice);
        }
        // The smaller piece gets the label `rest`. The first piece of a label has no rival.
        if (piece.size() > largest[label].size())
            std::swap(piece, largest[label]);
        for (const Voxel v : piece)
            labels[v] = rest;
    }
}

void part_bones(const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& giving_way,
    bool corners, const std::function<bool(Label, Label)>& must_part)
{
    Label largest = 0;
    for (const Label l : giving_way)
        largest = std::max(largest, l);
    std::vector<bool> gives(static_cast<std::size_t>(largest) + 1, false);
    for (const Label l : giving_way)
        gives[l] = true;
    std::vector<Voxel> off;
    for (int k = 1; k + 1 < grid.size[2]; ++k)
        for (int j = 1; j + 1 < grid.size[1]; ++j)
            for (int i = 1; i + 1 < grid.size[0]; ++i) {
                const Voxel v = grid.offset(i, j, k);
                const Label here = labels[v];
                if (here == 0 || here > largest || !gives[here])
                    continue;
                bool touches = false;
                for (int n = 0; n < 27 && !touches; ++n) {
                    const bool face = n == 4 || n == 10 || n == 12 || n == 14 || n == 16 || n == 22;
                    if (!corners && !face)
                        continue;
                    const Label there = labels[grid.offset(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1)];
                    touches = there != 0 && there != here && must_part(here, there);
                }
                if (touches)
                    off.push_back(v);
            }
    for (const Voxel v : off)
        labels[v] = 0;
}

} // namespace retractor::datasets::segmentation
