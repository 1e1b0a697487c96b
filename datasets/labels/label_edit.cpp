#include "datasets/labels/label_edit.h"

#include "datasets/segmentation/image/image_filters.h"
#include "datasets/segmentation/image/working_image.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <utility>

namespace retractor::datasets {

namespace {

    using segmentation::Extent;
    using segmentation::Mask;

    /// A box of voxels: first and last index along each axis.
    struct Box {
        std::array<int, 3> first { 0, 0, 0 }, last { -1, -1, -1 };

        bool empty() const { return last[0] < first[0]; }
        void take(const std::array<int, 3>& at)
        {
            if (empty()) {
                first = last = at;
                return;
            }
            for (std::size_t a = 0; a < 3; ++a) {
                first[a] = std::min(first[a], at[a]);
                last[a] = std::max(last[a], at[a]);
            }
        }
        Box grown(int by, const mesh::ImageGrid& grid) const
        {
            Box box = *this;
            for (std::size_t a = 0; a < 3; ++a) {
                box.first[a] = std::max(0, box.first[a] - by);
                box.last[a] = std::min(grid.size[a] - 1, box.last[a] + by);
            }
            return box;
        }
        Extent extent(const mesh::ImageGrid& grid) const
        {
            Extent extent;
            for (std::size_t a = 0; a < 3; ++a) {
                extent.size[a] = last[a] - first[a] + 1;
                extent.spacing[a] = grid.spacing[static_cast<Eigen::Index>(a)];
            }
            return extent;
        }
    };

    std::array<int, 3> index_of(const mesh::ImageGrid& grid, std::size_t offset)
    {
        const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
        return { static_cast<int>(offset % nx), static_cast<int>(offset / nx % ny),
            static_cast<int>(offset / (nx * ny)) };
    }

    /// Calls visit(offset in the grid, offset in the box) in memory order.
    template <class Visit> void visit_box(const mesh::ImageGrid& grid, const Box& box, Visit&& visit)
    {
        std::size_t inside = 0;
        for (int k = box.first[2]; k <= box.last[2]; ++k)
            for (int j = box.first[1]; j <= box.last[1]; ++j)
                for (int i = box.first[0]; i <= box.last[0]; ++i)
                    visit(grid.offset(i, j, k), inside++);
    }

    Box box_of(const mesh::LabelVolume& labels, Label label)
    {
        Box box;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label here) {
            if (here == label)
                box.take({ i, j, k });
        });
        return box;
    }

    Mask mask_of(const mesh::LabelVolume& labels, const Box& box, Label label)
    {
        Mask mask(box.extent(labels.grid).voxel_count(), 0);
        visit_box(labels.grid, box,
            [&](std::size_t at, std::size_t inside) { mask[inside] = labels.voxels[at] == label ? 1 : 0; });
        return mask;
    }

    /// Calls visit(offset) for the neighbours over faces.
    template <class Visit> void visit_neighbours(const mesh::ImageGrid& grid, std::size_t offset, Visit&& visit)
    {
        const std::array<int, 3> at = index_of(grid, offset);
        for (std::size_t a = 0; a < 3; ++a)
            for (const int step : { -1, 1 }) {
                std::array<int, 3> next = at;
                next[a] += step;
                if (grid.contains(next[0], next[1], next[2]))
                    visit(grid.offset(next[0], next[1], next[2]));
            }
    }

    void check_label(const mesh::LabelVolume& labels, Label label)
    {
        if (label != 0 && mesh::find_label(labels.table, label) == nullptr)
            throw InputError("there is no label " + std::to_string(label));
    }

    std::string name_of(const mesh::LabelVolume& labels, Label label)
    {
        const mesh::LabelInfo* info = mesh::find_label(labels.table, label);
        return info == nullptr ? std::string("nothing") : readable(info->name);
    }

    void change(LabelEdit& edit, const mesh::LabelVolume& labels, std::size_t voxel, Label after)
    {
        if (labels.voxels[voxel] == after)
            return;
        edit.voxels.push_back(voxel);
        edit.before.push_back(labels.voxels[voxel]);
        edit.after.push_back(after);
    }

    /// Adds voxels that lose their label: each gets the most frequent label of the neighbours that have another one,
    /// layer by layer from outside. Voxels that no other label reaches get none.
    void give_to_neighbours(
        LabelEdit& edit, const mesh::LabelVolume& labels, const std::vector<std::size_t>& voxels, Label lost)
    {
        constexpr Label kOpen = std::numeric_limits<Label>::max(); // not decided yet
        std::map<std::size_t, Label> given;
        for (const std::size_t voxel : voxels)
            given.emplace(voxel, kOpen);
        std::vector<std::size_t> open = voxels;
        while (!open.empty()) {
            std::vector<std::pair<std::size_t, Label>> layer;
            for (const std::size_t voxel : open) {
                std::map<Label, int> votes;
                visit_neighbours(labels.grid, voxel, [&](std::size_t next) {
                    const auto decided = given.find(next);
                    const Label label = decided == given.end() ? labels.voxels[next] : decided->second;
                    if (label != kOpen && label != lost)
                        ++votes[label];
                });
                if (!votes.empty())
                    layer.emplace_back(
                        voxel, std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
                            return a.second < b.second;
                        })->first);
            }
            if (layer.empty())
                break;
            for (const auto& [voxel, label] : layer)
                given[voxel] = label;
            std::erase_if(open, [&](std::size_t voxel) { return given[voxel] != kOpen; });
        }
        for (const auto& [voxel, label] : given)
            change(edit, labels, voxel, label == kOpen ? Label { 0 } : label);
    }

    double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b)
    {
        const Vec3 way = b - a;
        const double length2 = way.squaredNorm();
        const double t = length2 > 0.0 ? std::clamp((p - a).dot(way) / length2, 0.0, 1.0) : 0.0;
        return (p - a - t * way).norm();
    }

    /// The voxels of a slice, by index and centre: the layer of the grid that is shown where the slice lies along its
    /// layers, and voxels within half a layer elsewhere.
    std::function<bool(const std::array<int, 3>&, const Vec3&)> layer_of(
        const mesh::ImageGrid& grid, const Vec3& place, const Vec3& normal)
    {
        constexpr double kAlong = 0.9999; // cosine
        const int axis = nearest_axis(grid, normal);
        if (std::abs(grid.direction.col(axis).dot(normal)) > kAlong) {
            const auto layer = std::lround(
                std::clamp(grid.index(place)[axis], -2.0, grid.size[static_cast<std::size_t>(axis)] + 1.0));
            return [axis, layer](const std::array<int, 3>& at, const Vec3&) {
                return at[static_cast<std::size_t>(axis)] == layer;
            };
        }
        const double half = 0.5 * grid.spacing[axis];
        return [place, normal, half](const std::array<int, 3>&, const Vec3& centre) {
            const double off = (centre - place).dot(normal);
            return off > -half && off <= half; // of two layers at the same distance, one
        };
    }

    /// Signed distance from a mask's outline, mm: negative inside.
    std::vector<float> signed_distance(const Extent& extent, const Mask& mask)
    {
        Mask outside(mask.size());
        std::transform(mask.begin(), mask.end(), outside.begin(),
            [](std::uint8_t set) { return static_cast<std::uint8_t>(set == 0); });
        std::vector<float> distance = segmentation::distance_to(extent, mask);
        const std::vector<float> depth = segmentation::distance_to(extent, outside);
        for (std::size_t v = 0; v < distance.size(); ++v)
            distance[v] -= depth[v];
        return distance;
    }

} // namespace

int nearest_axis(const mesh::ImageGrid& grid, const Vec3& direction)
{
    Eigen::Index axis = 0;
    (grid.direction.transpose() * direction).cwiseAbs().maxCoeff(&axis);
    return static_cast<int>(axis);
}

void make_edit(mesh::LabelVolume& labels, const LabelEdit& edit)
{
    for (std::size_t n = 0; n < edit.voxels.size(); ++n) {
        RETRACTOR_ASSERT(labels.voxels[edit.voxels[n]] == edit.before[n]);
        labels.voxels[edit.voxels[n]] = edit.after[n];
    }
}

void take_back(mesh::LabelVolume& labels, const LabelEdit& edit)
{
    for (std::size_t n = 0; n < edit.voxels.size(); ++n) {
        RETRACTOR_ASSERT(labels.voxels[edit.voxels[n]] == edit.after[n]);
        labels.voxels[edit.voxels[n]] = edit.before[n];
    }
}

std::vector<std::size_t> voxels_under(const mesh::ImageGrid& grid, const BrushStroke& stroke)
{
    if (stroke.path.empty())
        throw InputError("a stroke needs a place", "path");
    if (!(stroke.radius_mm > 0.0 && std::isfinite(stroke.radius_mm)))
        throw InputError("the radius of a brush must be above 0 mm", "radius_mm");
    Box box;
    for (const Vec3& place : stroke.path) {
        if (!place.allFinite())
            throw InputError("a place of a stroke is not a finite number of mm", "path");
        if (stroke.normal
            && std::abs((place - stroke.path.front()).dot(*stroke.normal))
                > 0.5 * grid.spacing[nearest_axis(grid, *stroke.normal)])
            throw InputError(
                "the places of a disc lie in different slices: paint one slice at a time, or a ball", "path");
        const Vec3 at = grid.index(place), reach = Vec3::Constant(stroke.radius_mm).cwiseQuotient(grid.spacing);
        for (const double sign : { -1.0, 1.0 }) {
            std::array<int, 3> corner {};
            for (std::size_t a = 0; a < 3; ++a) {
                const auto axis = static_cast<Eigen::Index>(a);
                corner[a]
                    = static_cast<int>(std::clamp(std::round(at[axis] + sign * reach[axis]), -2.0, grid.size[a] + 1.0));
            }
            box.take(corner);
        }
    }
    box = box.grown(1, grid);
    const auto is_in_layer = stroke.normal ? layer_of(grid, stroke.path.front(), *stroke.normal)
                                           : std::function<bool(const std::array<int, 3>&, const Vec3&)>();
    std::vector<std::size_t> found;
    visit_box(grid, box, [&](std::size_t offset, std::size_t) {
        const std::array<int, 3> at = index_of(grid, offset);
        const Vec3 centre = grid.world(Vec3(at[0], at[1], at[2]));
        if (is_in_layer && !is_in_layer(at, centre))
            return;
        const auto flat = [&](const Vec3& place) -> Vec3 {
            return stroke.normal ? Vec3(place - (place - centre).dot(*stroke.normal) * *stroke.normal) : place;
        };
        double least = (flat(stroke.path.front()) - centre).norm();
        for (std::size_t n = 0; n + 1 < stroke.path.size(); ++n)
            least = std::min(least, distance_to_segment(centre, flat(stroke.path[n]), flat(stroke.path[n + 1])));
        if (least <= stroke.radius_mm)
            found.push_back(offset);
    });
    for (const Vec3& place : stroke.path) { // a brush that is smaller than a voxel
        const Vec3 at = grid.index(place);
        const int i = static_cast<int>(std::lround(std::clamp(at[0], -1.0, grid.size[0] + 0.0))),
                  j = static_cast<int>(std::lround(std::clamp(at[1], -1.0, grid.size[1] + 0.0))),
                  k = static_cast<int>(std::lround(std::clamp(at[2], -1.0, grid.size[2] + 0.0)));
        if (grid.contains(i, j, k))
            found.push_back(grid.offset(i, j, k));
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

LabelEdit painted(const mesh::LabelVolume& labels, const BrushStroke& stroke, Label with, const mesh::LabelFlags& kept)
{
    check_label(labels, with);
    LabelEdit edit { .what = "paint " + name_of(labels, with), .voxels = {}, .before = {}, .after = {} };
    for (const std::size_t voxel : voxels_under(labels.grid, stroke))
        if (kept[labels.voxels[voxel]] == 0)
            change(edit, labels, voxel, with);
    return edit;
}

LabelEdit erased(const mesh::LabelVolume& labels, const BrushStroke& stroke, Label label)
{
    check_label(labels, label);
    LabelEdit edit { .what = "erase " + name_of(labels, label), .voxels = {}, .before = {}, .after = {} };
    std::vector<std::size_t> voxels = voxels_under(labels.grid, stroke);
    std::erase_if(voxels, [&](std::size_t voxel) { return labels.voxels[voxel] != label; });
    give_to_neighbours(edit, labels, voxels, label);
    return edit;
}

LabelEdit region_filled(const mesh::LabelVolume& labels, const Vec3& place, const Vec3& normal, Label with)
{
    check_label(labels, with);
    const mesh::ImageGrid& grid = labels.grid;
    const Vec3 at = grid.index(place);
    const std::array<int, 3> start { static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
        static_cast<int>(std::lround(at[2])) };
    if (!place.allFinite() || !grid.contains(start[0], start[1], start[2]))
        throw InputError("the place lies outside the image");
    LabelEdit edit { .what = "fill with " + name_of(labels, with), .voxels = {}, .before = {}, .after = {} };
    const auto across = static_cast<std::size_t>(nearest_axis(grid, normal));
    const Label old = labels.voxels[grid.offset(start[0], start[1], start[2])];
    if (old == with)
        return edit;
    std::vector<bool> seen(grid.voxel_count(), false);
    std::vector<std::size_t> open { grid.offset(start[0], start[1], start[2]) };
    seen[open.back()] = true;
    while (!open.empty()) {
        const std::size_t voxel = open.back();
        open.pop_back();
        change(edit, labels, voxel, with);
        visit_neighbours(grid, voxel, [&](std::size_t next) {
            if (seen[next] || labels.voxels[next] != old || index_of(grid, next)[across] != start[across])
                return;
            seen[next] = true;
            open.push_back(next);
        });
    }
    return edit;
}

LabelEdit smoothed(const mesh::LabelVolume& labels, Label label, int radius_voxels, const mesh::LabelFlags& kept)
{
    constexpr int kLargest = 10, kThreads = 2;
    check_label(labels, label);
    if (radius_voxels < 1 || radius_voxels > kLargest)
        throw InputError(formatted("smooth over 1 to %d voxels, got %d", kLargest, radius_voxels), "radius_voxels");
    LabelEdit edit { .what = "smooth " + name_of(labels, label), .voxels = {}, .before = {}, .after = {} };
    Box box = box_of(labels, label);
    if (box.empty())
        return edit;
    box = box.grown(radius_voxels, labels.grid);
    const Mask smooth
        = segmentation::majority(box.extent(labels.grid), mask_of(labels, box, label), radius_voxels, kThreads);
    std::vector<std::size_t> lost;
    visit_box(labels.grid, box, [&](std::size_t at, std::size_t inside) {
        const Label here = labels.voxels[at];
        if (smooth[inside] != 0 && here != label && kept[here] == 0)
            change(edit, labels, at, label);
        else if (smooth[inside] == 0 && here == label)
            lost.push_back(at);
    });
    give_to_neighbours(edit, labels, lost, label);
    return edit;
}

LabelEdit without_islands(const mesh::LabelVolume& labels, Label label)
{
    check_label(labels, label);
    LabelEdit edit { .what = "drop islands of " + name_of(labels, label), .voxels = {}, .before = {}, .after = {} };
    const Box box = box_of(labels, label);
    if (box.empty())
        return edit;
    const segmentation::Pieces pieces
        = segmentation::connected_pieces(box.extent(labels.grid), mask_of(labels, box, label));
    std::vector<std::size_t> islands;
    visit_box(labels.grid, box, [&](std::size_t at, std::size_t inside) {
        if (pieces.piece_of[inside] > 1)
            islands.push_back(at);
    });
    give_to_neighbours(edit, labels, islands, label);
    return edit;
}

LabelEdit interpolated(const mesh::LabelVolume& labels, Label label, int axis, const mesh::LabelFlags& kept)
{
    RETRACTOR_ASSERT(axis >= 0 && axis < 3);
    check_label(labels, label);
    LabelEdit edit { .what = "interpolate " + name_of(labels, label), .voxels = {}, .before = {}, .after = {} };
    Box box = box_of(labels, label);
    if (box.empty())
        return edit;
    const auto across = static_cast<std::size_t>(axis);
    const int first = box.first[across], last = box.last[across];
    box = box.grown(1, labels.grid);
    const auto slice_box = [&](int slice) {
        Box one = box;
        one.first[across] = one.last[across] = slice;
        return one;
    };
    int before = first;
    std::vector<float> from;
    for (int slice = first; slice <= last; ++slice) {
        const Box here = slice_box(slice);
        const Mask mask = mask_of(labels, here, label);
        if (std::ranges::count(mask, 1) == 0)
            continue;
        std::vector<float> to = signed_distance(here.extent(labels.grid), mask);
        for (int between = before + 1; between < slice; ++between) {
            const double t = static_cast<double>(between - before) / (slice - before);
            visit_box(labels.grid, slice_box(between), [&](std::size_t at, std::size_t inside) {
                if ((1.0 - t) * from[inside] + t * to[inside] < 0.0 && kept[labels.voxels[at]] == 0)
                    change(edit, labels, at, label);
            });
        }
        before = slice;
        from = std::move(to);
    }
    return edit;
}

LabelEdit joined(const mesh::LabelVolume& labels, Label from, Label to)
{
    check_label(labels, from);
    check_label(labels, to);
    LabelEdit edit { .what = "join " + name_of(labels, from) + " with " + name_of(labels, to),
        .voxels = {},
        .before = {},
        .after = {} };
    if (from == 0)
        throw InputError("voxels without a label cannot be joined with one");
    for (std::size_t voxel = 0; voxel < labels.voxels.size(); ++voxel)
        if (labels.voxels[voxel] == from)
            change(edit, labels, voxel, to);
    return edit;
}

} // namespace retractor::datasets
