#include "datasets/segmentation/wall_layers.h"

#include "mesh/base/assert.h"

#include <algorithm>

namespace retractor::datasets::segmentation {

namespace {

    /// Removes small pieces of the mask, and fills small pieces of the remaining `wall`.
    Mask without_specks(const Extent& extent, Mask mask, const Mask& wall)
    {
        constexpr double kSpeckMl = 0.5;
        const auto least
            = static_cast<std::size_t>(1000.0 * kSpeckMl / (extent.spacing[0] * extent.spacing[1] * extent.spacing[2]));
        for (const std::uint8_t side : { std::uint8_t { 1 }, std::uint8_t { 0 } }) {
            Mask part(mask.size());
            for (std::size_t v = 0; v < part.size(); ++v)
                part[v] = wall[v] != 0 && mask[v] == side ? 1 : 0;
            const Pieces pieces = connected_pieces(extent, part);
            for (std::size_t v = 0; v < part.size(); ++v)
                if (part[v] != 0 && pieces.voxels[static_cast<std::size_t>(pieces.piece_of[v] - 1)] < least)
                    mask[v] = side == 1 ? 0 : 1;
        }
        return mask;
    }

} // namespace

std::vector<Layer> wall_layers(const WallInput& input, int threads)
{
    constexpr double kSkin = 3.0; // mm: epidermis, dermis, and the blur between dermis and air
    constexpr int kFatHu = -30; // between fat (-100) and muscle (50); the margin keeps thin muscle
    constexpr int kCells = 2;
    constexpr double kBetweenRibs = 13.0; // half the widest space between two ribs, mm
    const Extent extent = input.image.extent();
    RETRACTOR_ASSERT(input.wall.size() == extent.voxel_count() && input.air.size() == input.wall.size());
    RETRACTOR_ASSERT(input.depth.size() == input.wall.size() && input.shell.size() == input.wall.size());
    RETRACTOR_ASSERT(input.ribs.size() == input.wall.size());
    const double skin = std::max(kSkin, extent.spacing[0]) * (1.0 + 1e-4);
    constexpr int kBlur = 2; // voxels at which air and tissue mix
    Mask beside_air = input.air;
    for (int step = 0; step < kBlur; ++step)
        beside_air = grown_by_a_voxel(extent, beside_air, Mask(beside_air.size(), 1));
    Mask fat(input.wall.size());
    for (std::size_t v = 0; v < fat.size(); ++v)
        fat[v] = input.wall[v] != 0 && beside_air[v] == 0 && input.image.hu[v] < kFatHu ? 1 : 0;
    fat = without_specks(extent, common(majority(extent, fat, 1, threads), input.wall), input.wall);
    const Mask near_ribs = fine_values(extent,
        dilated(coarse_extent(extent, kCells), coarse_mask(extent, input.ribs, kCells, 0.3), kBetweenRibs), kCells);
    std::vector<Layer> layers(fat.size(), Layer::none);
    for (std::size_t v = 0; v < fat.size(); ++v) {
        if (input.wall[v] == 0)
            continue;
        if (static_cast<double>(input.depth[v]) <= skin)
            layers[v] = Layer::skin;
        else if (fat[v] != 0)
            layers[v] = Layer::fat;
        else
            layers[v] = input.shell[v] != 0 && near_ribs[v] != 0 ? Layer::intercostal : Layer::muscle;
    }
    return layers;
}

} // namespace retractor::datasets::segmentation
