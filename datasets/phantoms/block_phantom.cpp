#include "datasets/phantoms/phantom.h"

#include "datasets/phantoms/phantom_ct.h"
#include "mesh/base/error.h"

#include <cmath>

namespace retractor::datasets {

namespace {

    enum BlockLabel : Label { kSkin = 1, kFat, kMuscle, kBone, kCavity, kTarget };

    constexpr double kBoneHeight = 12.0, kBoneThickness = 6.0; // mm along z and y

    void check(const BlockParameters& p)
    {
        for (const double size : p.size_mm)
            check_parameter("size_mm", size, 20.0, 1000.0);
        for (const double spacing : p.spacing_mm)
            check_parameter("spacing_mm", spacing, 0.25, 10.0);
        check_parameter("margin_mm", p.margin_mm, 0.0, 200.0);
        check_parameter("skin_mm", p.skin_mm, 0.5, 50.0);
        check_parameter("fat_mm", p.fat_mm, 0.5, 200.0);
        check_parameter("muscle_mm", p.muscle_mm, 0.5, 200.0);
        const double wall = p.skin_mm + p.fat_mm + p.muscle_mm;
        if (wall >= p.size_mm.y())
            throw InputError("skin, fat and muscle are thicker than the block", "size_mm");
        if (p.bone_bar)
            check_parameter("muscle_mm", p.muscle_mm, kBoneThickness, 200.0);
        check_parameter("target_radius_mm", p.target_radius_mm, 0.5, 500.0);
        check_parameter(
            "target_depth_mm", p.target_depth_mm, wall + p.target_radius_mm, p.size_mm.y() - p.target_radius_mm);
        check_parameter("noise_hu", p.noise_hu, 0.0, 1000.0);
    }

    Label label_of(const BlockParameters& b, const Vec3& p)
    {
        if (std::abs(p.x()) > 0.5 * b.size_mm.x() || std::abs(p.z()) > 0.5 * b.size_mm.z() || p.y() < 0.0
            || p.y() > b.size_mm.y())
            return 0;
        if ((p - Vec3(0.0, b.target_depth_mm, 0.0)).norm() < b.target_radius_mm)
            return kTarget;
        const double fat_top = b.skin_mm;
        const double muscle_top = fat_top + b.fat_mm;
        const double cavity_top = muscle_top + b.muscle_mm;
        if (p.y() >= cavity_top)
            return kCavity;
        const bool in_bar = b.bone_bar && std::abs(p.z()) < 0.5 * kBoneHeight
            && std::abs(p.y() - 0.5 * (muscle_top + cavity_top)) < 0.5 * kBoneThickness;
        if (in_bar)
            return kBone;
        return p.y() < fat_top ? kSkin : p.y() < muscle_top ? kFat : kMuscle;
    }

    float hu_of(Label label)
    {
        switch (label) {
        case kSkin:
            return 40.0F;
        case kFat:
            return -100.0F;
        case kMuscle:
            return 50.0F;
        case kBone:
            return 600.0F;
        case kCavity:
            return -850.0F;
        case kTarget:
            return 350.0F;
        default:
            return -1000.0F;
        }
    }

} // namespace

Phantom make_block_phantom(const BlockParameters& b, const Job& job)
{
    check(b);
    const Stopwatch watch;
    mesh::ImageGrid grid;
    grid.spacing = b.spacing_mm;
    for (int axis = 0; axis < 3; ++axis)
        grid.size[static_cast<std::size_t>(axis)]
            = static_cast<int>(std::lround((b.size_mm[axis] + 2.0 * b.margin_mm) / b.spacing_mm[axis]));
    const Vec3 middle(0.0, 0.5 * b.size_mm.y(), 0.0);
    grid.origin = middle - 0.5 * grid.spacing.cwiseProduct(Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1));

    Phantom phantom;
    phantom.labels = { grid, std::vector<Label>(grid.voxel_count(), 0),
        { { kSkin, "skin", "skin", mesh::Role::wall }, { kFat, "fat", "fat", mesh::Role::wall },
            { kMuscle, "muscle", "muscle", mesh::Role::wall }, { kCavity, "cavity", "lung", mesh::Role::voxel },
            { kTarget, "target", "vessel", mesh::Role::target } } };
    if (b.bone_bar)
        phantom.labels.table.insert(phantom.labels.table.begin() + 3, { kBone, "bone", "bone", mesh::Role::wall });
    std::vector<float> hu(grid.voxel_count());
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i) {
                const std::size_t v = grid.offset(i, j, k);
                phantom.labels.voxels[v] = label_of(b, grid.world(Vec3(i, j, k)));
                hu[v] = hu_of(phantom.labels.voxels[v]);
            }
    record_part(job, "labels", watch, phantom.labels.voxels.size() * sizeof(Label));
    const Stopwatch ct_watch;
    phantom.ct = render_ct(grid, hu, b.noise_hu, b.seed);
    record_part(job, "voxels", ct_watch, phantom.ct.voxels.size() * sizeof(std::int16_t));
    return phantom;
}

Phantom transformed(const Phantom& phantom, const Mat3& rotation, const Vec3& translation)
{
    constexpr double kTolerance = 1e-9;
    const bool orthonormal = rotation.allFinite()
        && (rotation.transpose() * rotation - Mat3::Identity()).cwiseAbs().maxCoeff() < kTolerance;
    if (!orthonormal || rotation.determinant() < 0.0 || !translation.allFinite())
        throw InputError("a phantom can only be moved by a proper rotation and a finite translation");
    Phantom moved = phantom;
    for (mesh::ImageGrid* grid : { &moved.ct.grid, &moved.labels.grid }) {
        grid->origin = rotation * grid->origin + translation;
        grid->direction = rotation * grid->direction;
    }
    return moved;
}

} // namespace retractor::datasets
