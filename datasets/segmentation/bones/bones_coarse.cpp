#include "datasets/segmentation/bones/bones_steps.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

CoarseImage coarsened(const BonesInput& input)
{
    constexpr double kCoarse = 3.0; // mm
    const mesh::ImageGrid& fine = input.image.grid;
    CoarseImage coarse;
    coarse.factor = std::max(1, static_cast<int>(std::lround(kCoarse / fine.spacing.x())));
    const int f = coarse.factor;
    coarse.grid = fine;
    coarse.grid.spacing = fine.spacing * f;
    coarse.grid.origin = fine.origin + 0.5 * (f - 1) * fine.spacing;
    for (int& n : coarse.grid.size)
        n = std::max(1, n / f);
    const std::size_t count = coarse.grid.voxel_count();
    coarse.hu.resize(count);
    coarse.body.resize(count);
    coarse.lungs.resize(count);
    std::size_t at = 0;
    for (int k = 0; k < coarse.grid.size[2]; ++k)
        for (int j = 0; j < coarse.grid.size[1]; ++j)
            for (int i = 0; i < coarse.grid.size[0]; ++i, ++at) {
                int hu = 0, body = 0, lungs = 0, n = 0;
                for (int c = k * f; c < std::min((k + 1) * f, fine.size[2]); ++c)
                    for (int b = j * f; b < std::min((j + 1) * f, fine.size[1]); ++b)
                        for (int a = i * f; a < std::min((i + 1) * f, fine.size[0]); ++a, ++n) {
                            const std::size_t v = fine.offset(a, b, c);
                            hu += input.image.hu[v];
                            body += input.body[v];
                            lungs += input.lungs[v];
                        }
                coarse.hu[at] = static_cast<std::int16_t>(hu / n);
                coarse.body[at] = 2 * body >= n;
                coarse.lungs[at] = 2 * lungs >= n;
            }
    return coarse;
}

Eigen::Vector2d MidlinePath::operator()(double z) const
{
    if (at.empty())
        return Eigen::Vector2d::Zero();
    const double s = (z - z0) / dz;
    // Beyond its ends the line continues in the direction of its last part.
    constexpr int kStretch = 12;
    const auto point = [&](int n) { return at[static_cast<std::size_t>(std::clamp(n, first, last))]; };
    if (s <= first || s >= last) {
        const int end = s <= first ? first : last;
        const int back = s <= first ? std::min(last, first + kStretch) : std::max(first, last - kStretch);
        if (end == back)
            return point(end);
        return point(end) + (s - end) / (end - back) * (point(end) - point(back));
    }
    const int n = static_cast<int>(std::floor(s));
    return point(n) + (s - n) * (point(n + 1) - point(n));
}

MidlinePath path_of_label(const CoarseImage& image, const mesh::LabelVolume& labels, Label label)
{
    const mesh::ImageGrid& grid = image.grid;
    MidlinePath path;
    path.z0 = grid.origin.z();
    path.dz = grid.spacing.z();
    path.at.assign(static_cast<std::size_t>(grid.size[2]), Eigen::Vector2d::Zero());
    path.first = grid.size[2];
    for (int k = 0; k < grid.size[2]; ++k) {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        int n = 0;
        const int slice = std::min(k * image.factor, labels.grid.size[2] - 1);
        for (int j = 0; j < labels.grid.size[1]; ++j)
            for (int i = 0; i < labels.grid.size[0]; ++i)
                if (labels.voxels[labels.grid.offset(i, j, slice)] == label) {
                    sum += labels.grid.world(Vec3(i, j, slice)).head<2>();
                    ++n;
                }
        if (n > 0) {
            path.at[static_cast<std::size_t>(k)] = sum / n;
            path.first = std::min(path.first, k);
            path.last = k;
        } else if (path.last >= 0)
            path.at[static_cast<std::size_t>(k)] = path.at[static_cast<std::size_t>(path.last)];
    }
    return path;
}

} // namespace retractor::datasets::segmentation
