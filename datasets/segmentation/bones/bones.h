#pragma once
// The skeleton of a chest CT: bone told from contrast and calcification, then separated into spine, sternum, numbered
// ribs, shoulder blades, clavicles. Units mm and Hounsfield units; frame patient LPS.

#include "datasets/segmentation/bones/bones_input.h"
#include "datasets/segmentation/image/found_structure.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

struct Bones {
    mesh::LabelTable table; ///< the bones found, cartilages included; ids as autosegment() hands them out
    std::vector<Label> labels; ///< per voxel of the working grid, 0 where there is no bone or cartilage
    std::vector<FoundStructure> structures;
    std::vector<std::string> warnings;
};

/// Spine and sternum first (they hold the frame), then ribs from the spine outwards, numbered from the top by the
/// vertebra they meet (or, where the first rib is out of view, from the lowest, and the warning says so).
Bones segment_bones(const BonesInput& input, const Job& job = {});

} // namespace retractor::datasets::segmentation
