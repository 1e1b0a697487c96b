#include "datasets/labels/label_presets.h"
#include "datasets/labels/seg_nrrd.h"
#include "mesh/base/error.h"

#include <limits>
#include <numeric>
#include <set>

namespace retractor::datasets {

namespace {

    constexpr std::size_t kValues = std::size_t { std::numeric_limits<Label>::max() } + 1;

    /// Index of the segment for each layer and value, -1 without a segment.
    std::vector<int> segment_lookup(const SegmentedImage& image)
    {
        std::vector<int> lookup(kValues * static_cast<std::size_t>(image.layers), -1);
        for (std::size_t s = 0; s < image.segments.size(); ++s)
            lookup[static_cast<std::size_t>(image.segments[s].layer) * kValues + image.segments[s].value]
                = static_cast<int>(s);
        return lookup;
    }

    std::vector<std::size_t> voxels_of_segments(const SegmentedImage& image, const std::vector<int>& lookup)
    {
        std::vector<std::size_t> voxels(image.segments.size(), 0);
        const auto layers = static_cast<std::size_t>(image.layers);
        for (std::size_t v = 0; v < image.voxels.size(); ++v)
            if (const int segment = lookup[v % layers * kValues + image.voxels[v]]; segment >= 0)
                ++voxels[static_cast<std::size_t>(segment)];
        return voxels;
    }

    /// The ids of the segments: the file's values when they differ in all layers, else numbers from 1 in the file's
    /// order.
    std::vector<Label> ids_of(const SegmentedImage& image, std::vector<std::string>& notes)
    {
        std::vector<Label> ids;
        std::set<Label> values;
        for (const Segment& segment : image.segments) {
            ids.push_back(segment.value);
            values.insert(segment.value);
        }
        if (values.size() < ids.size()) {
            std::iota(ids.begin(), ids.end(), Label { 1 });
            notes.emplace_back("the layers use the same values: segments are numbered from 1 in the file's order");
        }
        return ids;
    }

    mesh::LabelTable table_of(
        const SegmentedImage& image, const std::vector<Label>& ids, std::vector<std::string>& notes)
    {
        mesh::LabelTable table;
        for (std::size_t s = 0; s < image.segments.size(); ++s) {
            mesh::LabelInfo info = describe_structure(image.segments[s].name, ids[s]);
            const std::string name = info.name;
            for (int copy = 2; mesh::find_label(table, info.name) != nullptr; ++copy)
                info.name = name + "_" + std::to_string(copy);
            if (info.name != name)
                notes.push_back("segment \"" + image.segments[s].name + "\" means \"" + name
                    + "\", which another segment means too: named \"" + info.name + "\"");
            table.push_back(std::move(info));
        }
        return table;
    }

} // namespace

MergedSegments merge_segments(const SegmentedImage& image, const Job& job)
{
    if (image.segments.size() >= kValues || image.layers < 1
        || image.voxels.size() != image.grid.voxel_count() * static_cast<std::size_t>(image.layers))
        throw InputError("the segmentation's sizes disagree");
    MergedSegments merged;
    merged.notes = image.notes;
    const std::vector<int> lookup = segment_lookup(image);
    const std::vector<std::size_t> sizes = voxels_of_segments(image, lookup);
    const std::vector<Label> ids = ids_of(image, merged.notes);
    merged.labels.grid = image.grid;
    merged.labels.table = table_of(image, ids, merged.notes);
    merged.labels.voxels.resize(image.grid.voxel_count());
    const auto layers = static_cast<std::size_t>(image.layers);
    for (std::size_t v = 0; v < merged.labels.voxels.size() && !job.cancelled(); ++v) {
        int winner = -1;
        bool overlap = false;
        for (std::size_t layer = 0; layer < layers; ++layer) {
            const int segment = lookup[layer * kValues + image.voxels[v * layers + layer]];
            if (segment < 0)
                continue;
            overlap = overlap || winner >= 0;
            if (winner < 0 || sizes[static_cast<std::size_t>(segment)] < sizes[static_cast<std::size_t>(winner)])
                winner = segment;
        }
        merged.labels.voxels[v] = winner < 0 ? Label { 0 } : ids[static_cast<std::size_t>(winner)];
        merged.overlapping_voxels += overlap ? 1 : 0;
    }
    if (merged.overlapping_voxels > 0)
        merged.notes.push_back(std::to_string(merged.overlapping_voxels)
            + " voxels belong to more than one segment: the smaller segment has them");
    return merged;
}

} // namespace retractor::datasets
