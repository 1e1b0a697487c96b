// Divides bones that touch in the image, where the image between them is darkest.

#include "datasets/segmentation/bones/bones_steps.h"

#include <algorithm>
#include <array>
#include <queue>

namespace retractor::datasets::segmentation {

void grow_seeds(const WorkingImage& image, const Mask& bone, const std::vector<std::int16_t>& smooth_hu,
    std::vector<Label>& labels, const std::function<bool(Label, Voxel)>& may_enter)
{
    // All bright voxels have the same level, because outer cortex must not win over inner marrow.
    constexpr int kBright = 350, kStep = 10, kDark = -50;
    constexpr std::size_t kLevels = (kBright - kDark) / kStep + 1;
    const auto level = [&](Voxel v) {
        return static_cast<std::size_t>((std::clamp<int>(smooth_hu[v], kDark, kBright) - kDark) / kStep);
    };
    const auto nx = static_cast<Voxel>(image.grid.size[0]), ny = static_cast<Voxel>(image.grid.size[1]);
    const auto nz = static_cast<Voxel>(image.grid.size[2]);
    const Voxel slice = nx * ny;
    std::array<std::queue<Voxel>, kLevels> waiting; // labelled voxels with neighbours to visit
    for (Voxel v = 0; v < labels.size(); ++v)
        if (labels[v] != 0)
            waiting[kLevels - 1].push(v);
    std::size_t at = kLevels - 1;
    while (true) {
        while (waiting[at].empty()) {
            if (at == 0)
                return;
            --at;
        }
        const Voxel v = waiting[at].front();
        waiting[at].pop();
        const Voxel i = v % nx, j = (v / nx) % ny, k = v / slice;
        const auto visit = [&](bool inside, Voxel u) {
            if (!inside || !bone[u] || labels[u] != 0 || !may_enter(labels[v], u))
                return;
            labels[u] = labels[v];
            waiting[std::min(at, level(u))].push(u);
        };
        visit(i > 0, v - 1);
        visit(i + 1 < nx, v + 1);
        visit(j > 0, v - nx);
        visit(j + 1 < ny, v + nx);
        visit(k > 0, v - slice);
        visit(k + 1 < nz, v + slice);
    }
}

} // namespace retractor::datasets::segmentation
