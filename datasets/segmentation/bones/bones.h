#pragma once
// Finds the skeleton of a chest CT. Bone is distinguished from contrast and calcification, then separated into spine,
// sternum, numbered ribs, shoulder blades and clavicles. Units mm and Hounsfield units; frame patient LPS.

#include "datasets/segmentation/bones/bones_input.h"
#include "datasets/segmentation/image/found_structure.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <string>
#include <vector>

namespace retractor::datasets::segmentation {

/// The bones, and how each was found.
struct Bones {
    mesh::LabelTable table; ///< the bones and cartilages found, with the ids that autosegment() uses
    std::vector<Label> labels; ///< per voxel of the working grid; 0 outside bone and cartilage
    std::vector<FoundStructure> structures;
    std::vector<std::string> warnings;
};

/// Separates the bones. Spine and sternum come first, since they define the frame. Ribs are followed from the spine
/// outwards and numbered from the top, by the vertebra that each rib meets. When the first rib is out of view, ribs are
/// numbered from the lowest rib, with a warning.
/// @throws InputError when the given labels are not on the grid of the image.
Bones segment_bones(const BonesInput& input, const Job& job = {});

} // namespace retractor::datasets::segmentation
