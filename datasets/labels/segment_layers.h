#pragma once
// Puts segments that may overlap into as few layers as it takes one after another.

#include "datasets/labels/seg_nrrd.h"

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::datasets {

/// A grid to which segments are added.
class SegmentLayers {
public:
    explicit SegmentLayers(mesh::ImageGrid grid);

    /// Adds a segment in the first layer where it overlaps no other.
    /// @param voxels one per voxel of the grid; other than 0 means inside
    /// @return false when no voxel is inside; nothing is added then
    /// @throws InputError when there are more segments than ids, or all layers have more than 800 million voxels
    bool add(const std::string& id, const std::string& name, const std::vector<std::uint8_t>& voxels);

    /// The image of all segments. @pre this is the last call
    SegmentedImage take();

private:
    SegmentedImage image_;
    std::vector<std::vector<Label>> layers_;
};

} // namespace retractor::datasets
