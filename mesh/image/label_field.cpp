#include "mesh/image/label_field.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace retractor::mesh {

namespace {

    constexpr std::uint8_t kMixed = 255;
    constexpr int kMargin = 4; ///< voxels of "outside" round the crop, for the spline's support and the surface

    /// Number of each label id in the crop's numbering; roles other than wall become 0.
    std::vector<int> wall_numbers(const LabelVolume& labels)
    {
        std::vector<int> number(std::numeric_limits<Label>::max() + 1U, -1);
        number[0] = 0;
        int next = 1;
        for (const LabelInfo& info : labels.table)
            if (info.id != 0)
                number[info.id] = info.role == Role::wall ? next++ : 0;
        return number;
    }

    constexpr int kSteps[6][3] = { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } };

    using Box = Eigen::AlignedBox3i; ///< first and last index per axis; empty until it is extended

    template <typename Visit> void for_each_voxel(const Box& box, Visit&& visit)
    {
        for (int k = box.min()[2]; k <= box.max()[2]; ++k)
            for (int j = box.min()[1]; j <= box.max()[1]; ++j)
                for (int i = box.min()[0]; i <= box.max()[0]; ++i)
                    visit(i, j, k);
    }

    /// Index range that can hold voxels within region_mm of the corridor.
    Box region_box(const ImageGrid& grid, std::span<const Vec3> corridor, double region_mm)
    {
        Box box;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            double low = 0.0, high = grid.size[a] - 1;
            if (region_mm > 0.0) {
                double from = std::numeric_limits<double>::infinity(), to = -from;
                for (const Vec3& p : corridor) {
                    from = std::min(from, p[axis]);
                    to = std::max(to, p[axis]);
                }
                low = std::max(low, std::floor((from - region_mm) / grid.spacing[axis]) - 1.0);
                high = std::min(high, std::ceil((to + region_mm) / grid.spacing[axis]) + 1.0);
            }
            if (high < low)
                return {};
            box.min()[axis] = static_cast<int>(low);
            box.max()[axis] = static_cast<int>(high);
        }
        return box;
    }

    /// The voxels that are kept beyond the region, one byte per voxel of the grid; empty when no label is kept whole.
    /// The set grows from the voxels of whole labels within the region through touching voxels of whole labels.
    std::vector<char> whole_voxels(const LabelVolume& labels, const Region& region)
    {
        if (region.whole_labels.empty() || region.region_mm == 0.0)
            return {};
        std::vector<char> is_whole(std::numeric_limits<Label>::max() + 1U, 0);
        for (const Label label : region.whole_labels) {
            const LabelInfo* info = find_label(labels.table, label);
            is_whole[label] = info != nullptr && info->role == Role::wall;
        }
        const ImageGrid& grid = labels.grid;
        std::vector<char> kept(labels.voxels.size(), 0);
        std::vector<std::array<int, 3>> front;
        const auto keep = [&](int i, int j, int k) {
            const std::size_t at = grid.offset(i, j, k);
            if (kept[at] || !is_whole[labels.voxels[at]])
                return;
            kept[at] = 1;
            front.push_back({ i, j, k });
        };
        const CorridorDistance corridor(
            region.corridor, Vec3::Zero(), grid.spacing.cwiseProduct(Vec3(grid.size[0], grid.size[1], grid.size[2])));
        for_each_voxel(region_box(grid, region.corridor, region.region_mm), [&](int i, int j, int k) {
            if (is_whole[labels.voxels[grid.offset(i, j, k)]]
                && corridor.within(grid.spacing.cwiseProduct(Vec3(i, j, k)), region.region_mm))
                keep(i, j, k);
        });
        while (!front.empty()) {
            const auto [i, j, k] = front.back();
            front.pop_back();
            for (const auto& step : kSteps)
                if (grid.contains(i + step[0], j + step[1], k + step[2]))
                    keep(i + step[0], j + step[1], k + step[2]);
        }
        return kept;
    }

    /// Weights of the uniform cubic B-spline at fraction t, for the voxels -1, 0, 1, 2.
    std::array<double, 4> spline_weights(double t)
    {
        const double u = 1.0 - t;
        return { u * u * u / 6.0, 2.0 / 3.0 - t * t * (2.0 - t) / 2.0, 2.0 / 3.0 - u * u * (2.0 - u) / 2.0,
            t * t * t / 6.0 };
    }

    /// For every voxel the common value of the window [-1, 2] along one axis, or kMixed.
    void spread_mixed(std::vector<std::uint8_t>& values, const std::array<int, 3>& size, int axis)
    {
        const auto a = static_cast<std::size_t>(axis);
        const std::size_t strides[3] = { 1, static_cast<std::size_t>(size[0]),
            static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) };
        const std::size_t stride = strides[a];
        const int n = size[a], n1 = size[(a + 1) % 3], n2 = size[(a + 2) % 3];
        std::vector<std::uint8_t> line(static_cast<std::size_t>(n));
        for (int q = 0; q < n2; ++q)
            for (int p = 0; p < n1; ++p) {
                std::uint8_t* begin = values.data() + static_cast<std::size_t>(p) * strides[(a + 1) % 3]
                    + static_cast<std::size_t>(q) * strides[(a + 2) % 3];
                for (int i = 0; i < n; ++i)
                    line[static_cast<std::size_t>(i)] = begin[static_cast<std::size_t>(i) * stride];
                for (int i = 0; i < n; ++i) {
                    std::uint8_t value = line[static_cast<std::size_t>(i)];
                    for (int s = std::max(i - 1, 0); s <= std::min(i + 2, n - 1); ++s)
                        if (line[static_cast<std::size_t>(s)] != value)
                            value = kMixed;
                    begin[static_cast<std::size_t>(i) * stride] = value;
                }
            }
    }

} // namespace

std::vector<Vec3> local_points(const ImageGrid& grid, std::span<const Vec3> world)
{
    std::vector<Vec3> local;
    for (const Vec3& p : world) {
        const Vec3 exact = grid.direction.transpose() * (p - grid.origin);
        local.push_back((exact / kLocalGrain).array().round().matrix() * kLocalGrain);
    }
    return local;
}

Vec3 world_point(const ImageGrid& grid, const Vec3& local) { return grid.origin + grid.direction * local; }

WallVoxels wall_voxels(const LabelVolume& labels, const Region& region)
{
    const ImageGrid& grid = labels.grid;
    const std::vector<int> number = wall_numbers(labels);
    RETRACTOR_ASSERT(labels.voxels.size() == grid.voxel_count());
    const auto voxel_number = [&](int i, int j, int k) {
        const Label label = labels.voxels[grid.offset(i, j, k)];
        if (number[label] < 0)
            throw InputError("a voxel has a label that is not in the label table: " + std::to_string(label),
                "voxel " + std::to_string(i) + ", " + std::to_string(j) + ", " + std::to_string(k));
        return number[label];
    };
    std::vector<char> met(labels.table.size() + 1, 0);
    Box box;
    for_each_voxel(region_box(grid, region.corridor, region.region_mm), [&](int i, int j, int k) {
        if (const int n = voxel_number(i, j, k); n > 0) {
            met[static_cast<std::size_t>(n)] = 1;
            box.extend(Eigen::Vector3i(i, j, k));
        }
    });
    WallVoxels wall;
    wall.spacing = (grid.spacing / kEdgeGrain).array().round().matrix() * kEdgeGrain;
    if (box.isEmpty())
        return wall;
    const std::vector<char> kept = whole_voxels(labels, region);
    std::vector<char> whole(met.size(), 0);
    if (!kept.empty())
        for_each_voxel(region_box(grid, {}, 0.0), [&](int i, int j, int k) {
            if (!kept[grid.offset(i, j, k)])
                return;
            const auto label = static_cast<std::size_t>(voxel_number(i, j, k));
            whole[label] = met[label] = 1;
            box.extend(Eigen::Vector3i(i, j, k));
        });

    std::vector<std::uint8_t> compact(met.size(), 0);
    int n = 0;
    for (const LabelInfo& info : labels.table)
        if (info.id != 0 && info.role == Role::wall && met[static_cast<std::size_t>(++n)]) {
            wall.labels.push_back(info.id);
            wall.whole.push_back(whole[static_cast<std::size_t>(n)]);
            if (wall.labels.size() >= kMixed)
                throw InputError("more than 254 wall labels occur");
            compact[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(wall.labels.size());
        }
    for (int axis = 0; axis < 3; ++axis) {
        wall.first[static_cast<std::size_t>(axis)] = box.min()[axis] - kMargin;
        wall.size[static_cast<std::size_t>(axis)] = box.sizes()[axis] + 1 + 2 * kMargin;
    }
    wall.voxels.assign(static_cast<std::size_t>(wall.size[0]) * static_cast<std::size_t>(wall.size[1])
            * static_cast<std::size_t>(wall.size[2]),
        0);
    for_each_voxel(box, [&](int i, int j, int k) {
        const auto label = static_cast<std::size_t>(voxel_number(i, j, k));
        if (!whole[label] || kept[grid.offset(i, j, k)]) // a whole label keeps only voxels connected to the region
            wall.voxels[wall.offset(i - wall.first[0], j - wall.first[1], k - wall.first[2])] = compact[label];
    });
    return wall;
}

LabelField::LabelField(WallVoxels wall, Region region)
    : wall_(std::move(wall))
    , region_(std::move(region))
    , corridor_(region_.corridor, lower(), upper())
    , uniform_(wall_.voxels)
{
    RETRACTOR_ASSERT(wall_.labels.size() == wall_.whole.size());
    RETRACTOR_ASSERT(wall_.voxels.empty() || wall_.voxels.size() == wall_.offset(0, 0, wall_.size[2]));
    for (int axis = 0; axis < 3; ++axis)
        spread_mixed(uniform_, wall_.size, axis);
    if (region_.merge_beyond_mm > 0.0)
        choose_merged_label();
}

void LabelField::choose_merged_label()
{
    std::vector<std::size_t> voxels(wall_.labels.size() + 1, 0);
    for (const std::uint8_t number : wall_.voxels)
        ++voxels[number];
    merges_.assign(voxels.size(), 0);
    for (std::size_t n = 1; n < voxels.size(); ++n) {
        const auto& merged = region_.merged_labels;
        if (std::find(merged.begin(), merged.end(), wall_.labels[n - 1]) == merged.end())
            continue;
        merges_[n] = 1;
        if (merged_ == 0 || voxels[n] > voxels[static_cast<std::size_t>(merged_)])
            merged_ = static_cast<int>(n);
    }
}

int LabelField::merged(int number, const Vec3& local) const
{
    return merges(number) && merges_at(local) ? merged_ : number;
}

bool LabelField::merges_at(const Vec3& local) const
{
    return region_.merge_beyond_mm > 0.0 && !corridor_.within(local, region_.merge_beyond_mm);
}

int LabelField::at(const Vec3& local) const { return merged(unmerged_at(local), local); }

int LabelField::unmerged_at(const Vec3& local) const
{
    std::array<int, 3> cell {};
    Vec3 fraction;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double index = local[axis] / wall_.spacing[axis] - wall_.first[a];
        if (!(index >= 1.0) || !(index < wall_.size[a] - 2))
            return 0; // within the margin the spline's support holds only "outside"
        cell[a] = static_cast<int>(index);
        fraction[axis] = index - cell[a];
    }
    const std::uint8_t uniform = uniform_[wall_.offset(cell[0], cell[1], cell[2])];
    if (uniform == 0)
        return 0;
    const int label = uniform != kMixed ? uniform : smooth_at(cell, fraction);
    RETRACTOR_ASSERT(static_cast<std::size_t>(label) <= wall_.whole.size());
    if (label == 0 || region_.region_mm == 0.0 || wall_.whole[static_cast<std::size_t>(label - 1)])
        return label;
    return corridor_.within(local, region_.region_mm) ? label : 0;
}

int LabelField::smooth_at(const std::array<int, 3>& cell, const Vec3& fraction) const
{
    const auto wx = spline_weights(fraction[0]), wy = spline_weights(fraction[1]), wz = spline_weights(fraction[2]);
    // Few labels meet at a point, so that a short list of (label, weight) is faster than a table of all labels.
    std::array<std::uint8_t, 64> met;
    std::array<double, 64> weight;
    std::size_t count = 0;
    for (int c = 0; c < 4; ++c)
        for (int b = 0; b < 4; ++b) {
            const std::uint8_t* row = wall_.voxels.data() + wall_.offset(cell[0] - 1, cell[1] + b - 1, cell[2] + c - 1);
            const double wyz = wy[static_cast<std::size_t>(b)] * wz[static_cast<std::size_t>(c)];
            for (std::size_t a = 0; a < 4; ++a) {
                std::size_t m = 0;
                while (m < count && met[m] != row[a])
                    ++m;
                if (m == count) {
                    met[m] = row[a];
                    weight[m] = 0.0;
                    ++count;
                }
                weight[m] += wx[a] * wyz;
            }
        }
    std::size_t best = 0;
    for (std::size_t m = 1; m < count; ++m)
        if (weight[m] > weight[best] || (weight[m] == weight[best] && met[m] < met[best]))
            best = m;
    return met[best];
}

Vec3 LabelField::crossing(Vec3 a, Vec3 b, double tolerance) const
{
    RETRACTOR_ASSERT(tolerance > 0.0);
    const int start = at(a);
    while ((b - a).norm() > tolerance) {
        const Vec3 middle = 0.5 * (a + b);
        (at(middle) == start ? a : b) = middle;
    }
    return a;
}

} // namespace retractor::mesh
