#pragma once
// The skeleton of a chest CT: bone told from contrast and calcification, then separated into spine, sternum, numbered
// ribs, shoulder blades, clavicles. Units mm and Hounsfield units; frame patient LPS.

#include "datasets/segmentation/autosegment.h"
#include "datasets/segmentation/image_filters.h"

namespace retractor::segmentation {

/// What the steps share: the CT on the working grid, whose axes are patient LPS (direction is the identity).
struct WorkingImage {
    ImageGrid grid;
    std::vector<std::int16_t> hu;

    Extent extent() const { return { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }; }
};

struct BonesInput {
    const WorkingImage& image;
    const Mask& body; ///< without table, blankets and leads
    const Mask& lungs; ///< both, airways included
    const LabelVolume* given = nullptr; ///< on the working grid; bones named in it are taken as they are
};

struct Bones {
    LabelTable table; ///< the bones found, cartilages included; ids as autosegment() hands them out
    std::vector<Label> labels; ///< per voxel of the working grid, 0 where there is no bone or cartilage
    std::vector<FoundStructure> structures;
    std::vector<std::string> warnings;
};

/// Spine and sternum first (they hold the frame), then ribs from the spine outwards, numbered from the top by the
/// vertebra they meet (or, where the first rib is out of view, from the lowest, and the warning says so).
Bones segment_bones(const BonesInput& input, const Job& job = {});

} // namespace retractor::segmentation
