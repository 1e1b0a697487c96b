#pragma once
// Label volumes made from implicit shapes.

#include "mesh/image/volume.h"

#include <functional>

namespace retractor::test_support {

/// Labels sampled at voxel centres. `label` takes local coordinates (index times spacing, mm).
inline mesh::LabelVolume sampled_labels(std::array<int, 3> size, const Vec3& spacing, mesh::LabelTable table,
    const std::function<Label(const Vec3&)>& label)
{
    mesh::LabelVolume volume;
    volume.grid.size = size;
    volume.grid.spacing = spacing;
    volume.table = std::move(table);
    volume.voxels.resize(volume.grid.voxel_count());
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i)
                volume.voxels[volume.grid.offset(i, j, k)] = label(spacing.cwiseProduct(Vec3(i, j, k)));
    return volume;
}

inline mesh::LabelTable chest_table()
{
    return { { 1, "skin", "skin", mesh::Role::wall }, { 2, "fat", "fat", mesh::Role::wall },
        { 3, "muscle", "muscle", mesh::Role::wall }, { 4, "rib_left_5", "bone", mesh::Role::wall },
        { 5, "rib_left_6", "bone", mesh::Role::wall }, { 6, "lung", "lung", mesh::Role::voxel } };
}

/// A quarter of a cylindrical chest wall about the z axis: 3 mm of skin, 9 mm of fat, 14 mm of muscle with two ribs of
/// 8 x 12 mm, and lung inside. The wall is cut off flat at both ends and sides.
inline mesh::LabelVolume curved_wall(double length_mm = 90.0, double spacing = 1.8)
{
    const int across = static_cast<int>(120.0 / spacing), along = static_cast<int>(length_mm / spacing);
    return sampled_labels(
        { across, across, along }, Vec3::Constant(spacing), chest_table(), [length_mm](const Vec3& p) -> Label {
            const double r = std::hypot(p[0], p[1]);
            if (r > 110.0)
                return 0;
            if (r > 107.0)
                return 1;
            if (r > 98.0)
                return 2;
            if (r < 84.0)
                return 6;
            for (const int rib : { 0, 1 }) {
                const double z = length_mm * (0.3 + 0.4 * rib);
                if (std::pow((r - 90.0) / 4.0, 2) + std::pow((p[2] - z) / 6.0, 2) < 1.0)
                    return static_cast<Label>(4 + rib);
            }
            return 3;
        });
}

} // namespace retractor::test_support
