#include "datasets/labels/segment_layers.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace retractor::datasets {

SegmentLayers::SegmentLayers(mesh::ImageGrid grid)
{
    mesh::check_grid(grid);
    image_.grid = std::move(grid);
}

bool SegmentLayers::add(const std::string& id, const std::string& name, const std::vector<std::uint8_t>& voxels)
{
    RETRACTOR_ASSERT(voxels.size() == image_.grid.voxel_count());
    if (std::ranges::all_of(voxels, [](std::uint8_t voxel) { return voxel == 0; }))
        return false;
    if (image_.segments.size() + 1 >= std::numeric_limits<Label>::max())
        throw InputError("there are more segments than ids", name);
    const auto is_free = [&](const std::vector<Label>& layer) {
        for (std::size_t v = 0; v < voxels.size(); ++v)
            if (voxels[v] != 0 && layer[v] != 0)
                return false;
        return true;
    };
    auto layer = std::ranges::find_if(layers_, is_free);
    if (layer == layers_.end()) {
        constexpr std::size_t kMostVoxels = 800'000'000; // of all layers: 1.6 GB
        if (voxels.size() * (layers_.size() + 1) > kMostVoxels)
            throw InputError("so many structures overlap on so large a grid that they do not fit into memory", name);
        layers_.emplace_back(voxels.size(), Label { 0 });
        layer = layers_.end() - 1;
    }
    const auto value = static_cast<Label>(image_.segments.size() + 1);
    for (std::size_t v = 0; v < voxels.size(); ++v)
        if (voxels[v] != 0)
            (*layer)[v] = value;
    image_.segments.push_back(
        { .id = id, .name = name, .layer = static_cast<int>(layer - layers_.begin()), .value = value, .tags = {} });
    return true;
}

SegmentedImage SegmentLayers::take()
{
    image_.layers = static_cast<int>(layers_.size());
    const std::size_t count = image_.grid.voxel_count();
    image_.voxels.resize(count * layers_.size());
    for (std::size_t l = 0; l < layers_.size(); ++l)
        for (std::size_t v = 0; v < count; ++v)
            image_.voxels[v * layers_.size() + l] = layers_[l][v];
    return std::move(image_);
}

} // namespace retractor::datasets
