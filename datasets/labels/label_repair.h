#pragma once
// Labels in pieces: told, and mended only when asked.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <string>
#include <vector>

namespace retractor::datasets {

struct LabelFragments {
    std::string name;
    std::size_t voxels = 0;
    std::size_t pieces = 1; ///< connected over faces, edges and corners
    std::size_t stray_voxels = 0; ///< outside the largest piece
    std::size_t hole_voxels = 0; ///< enclosed by the label, belonging to no label
};

/// One entry for each label that has voxels and is in more than one piece or has holes.
std::vector<LabelFragments> find_fragments(const mesh::LabelVolume& labels, const Job& job = {});

/// Keeps the largest piece of each label (stray voxels become 0) and fills holes that belong to no label. Labels that
/// are pairs or many by nature (ribs under one name, costal cartilages, skin, fat, muscle, vertebrae as one spine) keep
/// every piece of at least `keep_fraction` of the largest.
/// Skin is a shell: what it encloses is no hole of it. Of equal pieces the first in memory order is kept. Returns what
/// was changed: voxels and pieces as they were, strays removed, holes filled. Cancelled, nothing is changed.
/// @throws InputError for a fraction outside 0 to 1, and for voxels that the table does not name.
std::vector<LabelFragments> repair_labels(mesh::LabelVolume& labels, double keep_fraction = 0.02, const Job& job = {});

} // namespace retractor::datasets
