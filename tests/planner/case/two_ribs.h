#pragma once
// A small label volume for tests of corrections: muscle with two ribs in it.

#include "mesh/image/volume.h"

#include <memory>

namespace retractor::test_support {

inline std::shared_ptr<mesh::LabelVolume> two_ribs()
{
    auto labels = std::make_shared<mesh::LabelVolume>();
    labels->grid.size = { 20, 20, 20 };
    labels->table = { { 1, "muscle", "muscle", mesh::Role::wall }, { 2, "rib_left_4", "bone", mesh::Role::wall },
        { 3, "rib_left_5", "bone", mesh::Role::wall } };
    labels->voxels.assign(labels->grid.voxel_count(), 1);
    for (int i = 0; i < 20; ++i) {
        labels->voxels[labels->grid.offset(i, 5, 5)] = 2;
        labels->voxels[labels->grid.offset(i, 15, 5)] = 3;
    }
    return labels;
}

} // namespace retractor::test_support
