// Labels the shoulder girdle from the remaining bone outside the rib cage: clavicles in front and above, shoulder
// blades behind, arms.

#include "datasets/segmentation/bones/bones_steps.h"

namespace retractor::datasets::segmentation {

void label_girdle(const WorkingImage& image, const Mask& bone, const Cage& cage, const GirdleIds& ids, Label cartilage,
    std::vector<Label>& labels)
{
    constexpr double kLeastMl = 0.3, kFrontDeg = 95.0,
                     kMargin = 80.0; // degrees; mm from the sternum's tip to the lowest cartilage
    const mesh::ImageGrid& grid = image.grid;
    Mask rest(bone.size());
    for (Voxel v = 0; v < bone.size(); ++v)
        rest[v] = (bone[v] && labels[v] == 0) || labels[v] == ids.other;
    const Pieces pieces = connected_pieces(image.extent(), rest);
    const auto least = static_cast<std::size_t>(kLeastMl * 1000.0 / grid.voxel_volume());
    struct Place {
        Vec3 sum = Vec3::Zero();
        double outside = 0.0;
        std::size_t n = 0;
    };
    std::vector<Place> places(pieces.voxels.size());
    Voxel v = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i, ++v) {
                if (pieces.piece_of[v] == 0)
                    continue;
                Place& place = places[static_cast<std::size_t>(pieces.piece_of[v]) - 1];
                const Vec3 p = grid.world(Vec3(i, j, k));
                place.sum += p;
                place.outside += cage.outside_at(p);
                ++place.n;
            }
    std::vector<Label> label_of(pieces.voxels.size() + 1, 0);
    for (std::size_t n = 0; n < places.size(); ++n) {
        if (places[n].n < least)
            continue;
        const Vec3 middle = places[n].sum / static_cast<double>(places[n].n);
        const Eigen::Vector2d centre = cage.centre(middle.z());
        const std::size_t side = middle.x() > centre.x() ? 0 : 1;
        const bool behind = middle.y() > centre.y();
        const bool outside = places[n].outside / static_cast<double>(places[n].n) > 12.0;
        const bool front = cage.angle(middle) > kFrontDeg && middle.z() < cage.sternum.top()
            && middle.z() > cage.sternum.bottom() - kMargin;
        // The remaining bone in front within the cage is calcified cartilage.
        label_of[n + 1] = !outside && front ? cartilage : !outside ? ids.other : behind ? ids.scapula[side] : ids.other;
    }
    for (v = 0; v < labels.size(); ++v)
        if (pieces.piece_of[v] != 0)
            labels[v] = label_of[static_cast<std::size_t>(pieces.piece_of[v])];
}

} // namespace retractor::datasets::segmentation
