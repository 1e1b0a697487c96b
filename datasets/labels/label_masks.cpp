#include "datasets/labels/label_masks.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace retractor::datasets {

namespace {

    constexpr std::size_t kMostVoxels = 400'000'000;

    /// A box in continuous indices of the kept grid. The box reaches to the outer faces of its voxels.
    struct IndexBox {
        Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
        Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

        void add(const Vec3& point)
        {
            low = low.cwiseMin(point);
            high = high.cwiseMax(point);
        }
        bool touches(const IndexBox& other, double slack) const
        {
            return (low.array() <= other.high.array() + slack).all()
                && (other.low.array() <= high.array() + slack).all();
        }
    };

    /// Bounding box, in indices of `to`, of the voxels from `low` to `high` (inclusive, indices of `from`). With `half`
    /// 0.5 the box contains the whole voxels, with 0 only their centres.
    IndexBox seen_in(
        const mesh::ImageGrid& to, const mesh::ImageGrid& from, const Vec3& low, const Vec3& high, double half)
    {
        IndexBox box;
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 index;
            for (int axis = 0; axis < 3; ++axis)
                index[axis] = (corner >> axis & 1) != 0 ? high[axis] + half : low[axis] - half;
            box.add(to.index(from.world(index)));
        }
        return box;
    }

    Vec3 last_index(const mesh::ImageGrid& grid) { return Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1); }

    /// The lowest and the highest index of a mask's voxels.
    std::pair<std::array<int, 3>, std::array<int, 3>> extent_of(const StructureMask& mask)
    {
        std::array<int, 3> low = mask.grid.size, high { -1, -1, -1 };
        const auto nx = static_cast<std::uint32_t>(mask.grid.size[0]);
        const auto ny = static_cast<std::uint32_t>(mask.grid.size[1]);
        for (const VoxelRun& run : mask.runs) {
            const std::array<std::uint32_t, 3> first { run.first % nx, run.first / nx % ny, run.first / nx / ny };
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto from = static_cast<int>(first[axis]);
                low[axis] = std::min(low[axis], from);
                high[axis] = std::max(high[axis], axis == 0 ? from + static_cast<int>(run.count) - 1 : from);
            }
        }
        return { low, high };
    }

    const StructureMask& finest(std::span<const StructureMask> masks)
    {
        const auto better = [](const StructureMask& a, const StructureMask& b) {
            const double va = a.grid.voxel_volume(), vb = b.grid.voxel_volume();
            if (std::abs(va - vb) > 1e-4 * std::max(va, vb))
                return va < vb;
            return a.grid.voxel_count() > b.grid.voxel_count();
        };
        return *std::min_element(masks.begin(), masks.end(), better);
    }

    /// Refuses masks whose grids lie apart. Every grid must be connected to the others through touching grids, because
    /// masks of two patients, or of two frames of one patient, must not be merged.
    void check_one_place(std::span<const StructureMask> masks, const mesh::ImageGrid& grid)
    {
        constexpr double kSlack = 1.0; // voxels; crops around neighbouring organs may leave a gap
        std::vector<IndexBox> boxes;
        for (const StructureMask& mask : masks)
            boxes.push_back(seen_in(grid, mask.grid, Vec3::Zero(), last_index(mask.grid), 0.5));
        std::vector<bool> reached(masks.size(), false);
        std::vector<std::size_t> front { 0 };
        reached[0] = true;
        while (!front.empty()) {
            const std::size_t at = front.back();
            front.pop_back();
            for (std::size_t n = 0; n < masks.size(); ++n)
                if (!reached[n] && boxes[at].touches(boxes[n], kSlack)) {
                    reached[n] = true;
                    front.push_back(n);
                }
        }
        const auto apart = std::find(reached.begin(), reached.end(), false);
        if (apart != reached.end())
            throw InputError("the masks do not overlap in space: this one lies apart from " + masks[0].source
                    + "; they are not of the same patient position or not in the same frame",
                masks[static_cast<std::size_t>(apart - reached.begin())].source);
    }

    /// Extends the grid by whole voxels, so that the centres of all labelled voxels lie inside.
    mesh::ImageGrid covering(const mesh::ImageGrid& grid, std::span<const StructureMask> masks)
    {
        IndexBox all;
        all.add(Vec3::Zero());
        all.add(last_index(grid));
        for (const StructureMask& mask : masks) {
            const auto [low, high] = extent_of(mask);
            const IndexBox box
                = seen_in(grid, mask.grid, Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2]), 0.0);
            all.add(box.low);
            all.add(box.high);
        }
        mesh::ImageGrid wide = grid;
        Vec3 shift;
        double voxels = 1.0;
        // A centre within this distance (voxels) already lies in the outermost voxel.
        constexpr double kNearest = 0.5 - 1e-3;
        for (int axis = 0; axis < 3; ++axis) {
            shift[axis] = std::min(0.0, std::floor(all.low[axis] + kNearest));
            const double last = std::max<double>(last_index(grid)[axis], std::ceil(all.high[axis] - kNearest));
            voxels *= last - shift[axis] + 1.0;
            if (!(voxels <= static_cast<double>(kMostVoxels)))
                throw InputError("one grid for all masks would have more than 400 million voxels: bring the masks to "
                                 "one coarser grid first");
            wide.size[static_cast<std::size_t>(axis)] = static_cast<int>(last - shift[axis]) + 1;
        }
        wide.origin = grid.world(shift);
        return wide;
    }

    /// Offset of `crop` in the kept grid when both have the same voxels, as a cropped image has. Nothing otherwise.
    std::optional<std::array<int, 3>> same_lattice(const mesh::ImageGrid& grid, const mesh::ImageGrid& crop)
    {
        constexpr double kSame = 1e-2; // voxels over the whole crop; NIfTI stores single precision
        const Vec3 last = last_index(crop);
        const Vec3 at_first = grid.index(crop.origin);
        const Vec3 shift = at_first.array().round();
        for (const Vec3& corner : { Vec3(0, 0, 0), Vec3(last.x(), 0, 0), Vec3(0, last.y(), 0), Vec3(0, 0, last.z()) })
            if ((grid.index(crop.world(corner)) - corner - shift).cwiseAbs().maxCoeff() > kSame)
                return std::nullopt;
        return std::array<int, 3> { static_cast<int>(shift.x()), static_cast<int>(shift.y()),
            static_cast<int>(shift.z()) };
    }

    /// Calls visit(offset in the kept grid) for each voxel of the kept grid that the mask covers.
    template <typename Visit>
    void for_voxels(const mesh::ImageGrid& grid, const StructureMask& mask, const Visit& visit)
    {
        const auto nx = static_cast<std::uint32_t>(mask.grid.size[0]);
        const auto ny = static_cast<std::uint32_t>(mask.grid.size[1]);
        if (const auto shift = same_lattice(grid, mask.grid)) {
            for (const VoxelRun& run : mask.runs) {
                const std::size_t row = grid.offset(static_cast<int>(run.first % nx) + (*shift)[0],
                    static_cast<int>(run.first / nx % ny) + (*shift)[1],
                    static_cast<int>(run.first / nx / ny) + (*shift)[2]);
                for (std::size_t v = row; v < row + run.count; ++v)
                    visit(v);
            }
            return;
        }
        std::vector<bool> set(mask.grid.voxel_count(), false);
        for (const VoxelRun& run : mask.runs)
            std::fill_n(set.begin() + run.first, run.count, true);
        const auto [low, high] = extent_of(mask);
        const IndexBox box
            = seen_in(grid, mask.grid, Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2]), 0.5);
        std::array<int, 3> from {}, to {};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            from[a] = static_cast<int>(std::max(0.0, std::floor(box.low[axis])));
            to[a] = static_cast<int>(std::min<double>(grid.size[a] - 1, std::ceil(box.high[axis])));
        }
        for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j)
                for (int i = from[0]; i <= to[0]; ++i) {
                    const Vec3 index = mask.grid.index(grid.world(Vec3(i, j, k))).array().round();
                    const Vec3 last = last_index(mask.grid);
                    if (index.minCoeff() >= 0.0 && (index.array() <= last.array()).all()
                        && set[mask.grid.offset(
                            static_cast<int>(index.x()), static_cast<int>(index.y()), static_cast<int>(index.z()))])
                        visit(grid.offset(i, j, k));
                }
    }

    struct Structure {
        std::vector<const StructureMask*> masks;
        /// Volume of the structure's largest mask, since joined masks mostly repeat each other.
        double volume_mm3 = 0.0;
    };

} // namespace

std::size_t StructureMask::voxel_count() const
{
    return std::accumulate(runs.begin(), runs.end(), std::size_t { 0 },
        [](std::size_t sum, const VoxelRun& run) { return sum + run.count; });
}

std::vector<VoxelRun> runs_of(const mesh::ImageGrid& grid, const std::vector<Label>& voxels, Label value)
{
    std::vector<VoxelRun> runs;
    const auto nx = static_cast<std::size_t>(grid.size[0]);
    for (std::size_t row = 0; row < voxels.size(); row += nx)
        for (std::size_t v = row; v < row + nx; ++v) {
            if (voxels[v] != value)
                continue;
            const std::size_t first = v;
            while (v < row + nx && voxels[v] == value)
                ++v;
            runs.push_back({ static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(v - first) });
        }
    return runs;
}

MergedMasks merge_masks(std::span<const StructureMask> masks, const Job& job)
{
    MergedMasks merged;
    std::vector<Structure> structures;
    for (const StructureMask& mask : masks) {
        const auto known = std::find(merged.names.begin(), merged.names.end(), mask.name);
        const auto at = static_cast<std::size_t>(known - merged.names.begin());
        if (known == merged.names.end()) {
            merged.names.push_back(mask.name);
            structures.emplace_back();
        }
        structures[at].masks.push_back(&mask);
        structures[at].volume_mm3 = std::max(structures[at].volume_mm3, mask.volume_mm3());
    }
    if (structures.empty())
        throw InputError("no mask has a voxel");
    if (structures.size() > std::numeric_limits<Label>::max())
        throw InputError("more structures than a label image can hold (65535)");

    const StructureMask& best = finest(masks);
    check_one_place(masks, best.grid);
    merged.grid = covering(best.grid, masks);
    merged.grid_source = best.source;
    merged.extended = merged.grid.size != best.grid.size;
    merged.voxels.assign(merged.grid.voxel_count(), 0);
    merged.counts.assign(structures.size(), 0);
    merged.lost.resize(structures.size());

    // The largest structure is painted first, so that smaller structures win. Equal structures keep their order.
    std::vector<std::size_t> order(structures.size());
    std::iota(order.begin(), order.end(), std::size_t { 0 });
    std::stable_sort(order.begin(), order.end(),
        [&](std::size_t a, std::size_t b) { return structures[a].volume_mm3 > structures[b].volume_mm3; });
    for (std::size_t done = 0; done < order.size(); ++done) {
        if (job.cancelled())
            return {};
        const std::size_t here = order[done];
        const auto id = static_cast<Label>(here + 1);
        std::map<Label, std::size_t> taken;
        for (const StructureMask* mask : structures[here].masks)
            for_voxels(merged.grid, *mask, [&](std::size_t v) {
                Label& voxel = merged.voxels[v];
                if (voxel == id)
                    return;
                if (voxel != 0)
                    ++taken[voxel];
                voxel = id;
                ++merged.counts[here];
            });
        for (const auto& [from, count] : taken) {
            merged.counts[from - 1U] -= count;
            merged.lost[from - 1U].push_back({ here, count });
        }
        job.report("merge masks", static_cast<double>(done + 1) / static_cast<double>(order.size()));
    }
    return merged;
}

} // namespace retractor::datasets
