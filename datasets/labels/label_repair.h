#pragma once
// Finds labels that are in several pieces or have holes, and repairs them on request.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <string>
#include <vector>

namespace retractor::datasets {

/// The pieces and holes of one label.
struct LabelFragments {
    std::string name;
    std::size_t voxels = 0; ///< voxels of the label
    std::size_t pieces = 1; ///< number of pieces, connected over faces, edges and corners
    std::size_t stray_voxels = 0; ///< voxels outside the largest piece
    std::size_t hole_voxels = 0; ///< voxels without a label that this label encloses
};

/// Returns one entry for each label that has several pieces or holes.
std::vector<LabelFragments> find_fragments(const mesh::LabelVolume& labels, const Job& job = {});

/// Keeps the largest piece of each label (stray voxels become 0) and fills holes without a label. Some labels have
/// several pieces by nature: ribs under one name, costal cartilages, skin, fat, muscle, vertebrae as one spine. Such a
/// label keeps every piece with at least `keep_fraction` of the voxels of its largest piece. Skin is a shell, so the
/// enclosed body is no hole. Of equally large pieces the first in memory order is kept. A cancelled repair changes
/// nothing.
/// @returns the changes: voxels and pieces before the repair, removed stray voxels, filled hole voxels
/// @throws InputError for a fraction outside 0 to 1, and for voxels that the table does not name.
std::vector<LabelFragments> repair_labels(mesh::LabelVolume& labels, double keep_fraction = 0.02, const Job& job = {});

} // namespace retractor::datasets
