#include "tests/support/synthetic_chest.h"

#include <cmath>
#include <numbers>
#include <string>

namespace retractor::test_support {

namespace {

    constexpr Label kSkin = 1, kMuscle = 2, kSternum = 3, kSpine = 4, kLungLeft = 5, kLungRight = 6, kFat = 7,
                    kHeart = 8, kCoronary = 9, kAneurysm = 10, kRibLeft = 20, kRibRight = 40;

    mesh::LabelTable table(const ChestShape& shape)
    {
        mesh::LabelTable t {
            { kSkin, "skin", "skin", mesh::Role::wall },
            { kMuscle, "muscle", "muscle", mesh::Role::wall },
            { kSternum, "sternum", "bone", mesh::Role::wall },
            { kSpine, "spine", "bone", mesh::Role::wall },
            { kLungLeft, "lung_left", "lung", mesh::Role::voxel },
            { kLungRight, "lung_right", "lung", mesh::Role::voxel },
            { kFat, "mediastinal_fat", "fat", mesh::Role::voxel },
            { kHeart, "heart", "heart", mesh::Role::at_risk },
            { kCoronary, "coronary_target", "vessel", mesh::Role::target },
            { kAneurysm, "aneurysm", "vessel", mesh::Role::target },
        };
        for (int n = 1; n <= shape.ribs; ++n) {
            t.push_back(
                { static_cast<Label>(kRibLeft + n), "rib_left_" + std::to_string(n), "bone", mesh::Role::wall });
            t.push_back(
                { static_cast<Label>(kRibRight + n), "rib_right_" + std::to_string(n), "bone", mesh::Role::wall });
        }
        return t;
    }

    Label rib_at(const ChestShape& shape, const Vec3& p)
    {
        const double radius = std::hypot(p.x(), p.y());
        if (std::abs(radius - shape.rib_radius) > 0.5 * shape.rib_thickness)
            return 0;
        const double angle = std::atan2(std::abs(p.x()), p.y()) * 180.0 / std::numbers::pi;
        if (angle < kRibFromDeg || angle > kRibToDeg)
            return 0;
        for (int n = 1; n <= shape.ribs; ++n)
            if (std::abs(p.z() - rib_height_at(shape, n, angle)) <= 0.5 * shape.rib_height)
                return static_cast<Label>((p.x() > 0.0 ? kRibLeft : kRibRight) + n);
        return 0;
    }

    Label label_of(const ChestShape& shape, const Vec3& p)
    {
        const double radius = std::hypot(p.x(), p.y());
        if (radius > shape.radius)
            return 0;
        if (std::hypot(p.x(), p.y() - 104.0) <= 14.0)
            return kSpine;
        if (std::abs(p.x()) <= 15.0 && std::abs(p.y() + 104.0) <= 5.0 && p.z() <= kSternumTop
            && p.z() >= kSternumBottom)
            return kSternum;
        if (radius > shape.radius - 3.0)
            return kSkin;
        if (radius > shape.radius - shape.wall) {
            const Label rib = rib_at(shape, p);
            return rib != 0 ? rib : kMuscle;
        }
        if ((p - Vec3(45.0, -55.0, -30.0)).norm() < 9.0)
            return kCoronary;
        if ((p - Vec3(35.0, 45.0, 20.0)).norm() < 20.0)
            return kAneurysm;
        if ((p - Vec3(15.0, -30.0, -30.0)).norm() < 45.0)
            return kHeart;
        if (std::abs(p.x()) < 12.0)
            return kFat;
        return p.x() > 0.0 ? kLungLeft : kLungRight;
    }

} // namespace

double rib_height_at(const ChestShape& shape, int number, double angle_deg)
{
    return shape.first_rib - shape.rib_pitch * (number - 1) - shape.rib_slope * angle_deg;
}

double upper_edge_at(const ChestShape& shape, int number, double angle_deg)
{
    return rib_height_at(shape, number, angle_deg) + 0.5 * shape.rib_height;
}

mesh::LabelVolume synthetic_chest(const ChestShape& shape)
{
    mesh::LabelVolume labels;
    const double half = shape.radius + 3.0 * shape.spacing;
    const int across = static_cast<int>(std::ceil(2.0 * half / shape.spacing));
    labels.grid.size = { across, across + 1, static_cast<int>(260.0 / shape.spacing) };
    labels.grid.spacing = Vec3::Constant(shape.spacing);
    // Off the axes of symmetry, like real patients.
    labels.grid.origin = Vec3(-half + 0.3, -half - 0.4, -130.0);
    labels.table = table(shape);
    labels.voxels.reserve(labels.grid.voxel_count());
    for (int k = 0; k < labels.grid.size[2]; ++k)
        for (int j = 0; j < labels.grid.size[1]; ++j)
            for (int i = 0; i < labels.grid.size[0]; ++i)
                labels.voxels.push_back(label_of(shape, labels.grid.world(Vec3(i, j, k))));
    return labels;
}

mesh::LabelVolume moved(const mesh::LabelVolume& labels, const Mat3& rotation, const Vec3& translation)
{
    mesh::LabelVolume result = labels;
    result.grid.direction = rotation * labels.grid.direction;
    result.grid.origin = rotation * labels.grid.origin + translation;
    return result;
}

mesh::LabelVolume stored_backwards(const mesh::LabelVolume& labels, int axis)
{
    mesh::LabelVolume result = labels;
    const auto a = static_cast<std::size_t>(axis);
    Vec3 last = Vec3::Zero();
    last[axis] = labels.grid.size[a] - 1;
    result.grid.origin = labels.grid.world(last);
    result.grid.direction.col(axis) *= -1.0;
    std::array<int, 3> v {};
    for (v[2] = 0; v[2] < labels.grid.size[2]; ++v[2])
        for (v[1] = 0; v[1] < labels.grid.size[1]; ++v[1])
            for (v[0] = 0; v[0] < labels.grid.size[0]; ++v[0]) {
                std::array<int, 3> w = v;
                w[a] = labels.grid.size[a] - 1 - v[a];
                result.voxels[labels.grid.offset(w[0], w[1], w[2])]
                    = labels.voxels[labels.grid.offset(v[0], v[1], v[2])];
            }
    return result;
}

} // namespace retractor::test_support
