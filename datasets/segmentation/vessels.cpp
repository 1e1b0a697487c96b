#include "datasets/segmentation/vessels.h"

#include "datasets/segmentation/aorta.h"
#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kSoftHu = -20; // fat of mediastinum and pericardium is darker
    constexpr int kCells = 2;

    /// The highest plane of the heart: below the carina by the height of the left atrium's roof.
    int heart_top(const VesselsInput& input, int low, int high)
    {
        constexpr double kBelowCarina = 25.0; // mm
        constexpr double kShare = 0.55; // share of the cavity's height, used when no windpipe was found
        if (!input.lungs.carina_z)
            return low + static_cast<int>(kShare * (high - low));
        const double z = *input.lungs.carina_z - kBelowCarina;
        return static_cast<int>(std::lround(input.image.grid.index(Vec3(0.0, 0.0, z)).z()));
    }

    /// Finds the piece of soft tissue between the lungs that is thicker than any vessel.
    Mask find_heart(const VesselsInput& input, const Mask& soft)
    {
        constexpr double kThickerThanVessels = 20.0;
        const Extent extent = input.image.extent();
        const Extent cells = coarse_extent(extent, kCells);
        const auto plane = static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]);
        int low = extent.size[2];
        int high = 0;
        for (std::size_t v = 0; v < soft.size(); ++v)
            if (soft[v] != 0) {
                low = std::min(low, static_cast<int>(v / plane));
                high = std::max(high, static_cast<int>(v / plane));
            }
        // Heart and liver touch, and the erosion must not remove the heart from below.
        const Mask core
            = eroded(cells, coarse_mask(extent, united(soft, input.abdomen), kCells, 0.5), kThickerThanVessels);
        Mask heart = common(fine_values(extent, dilated(cells, core, kThickerThanVessels + 3.0), kCells), soft);
        const int top = heart_top(input, low, high);
        for (std::size_t v = 0; v < heart.size(); ++v)
            if (static_cast<int>(v / plane) > top)
                heart[v] = 0;
        return largest_piece(extent, heart);
    }

} // namespace

Vessels find_vessels(const VesselsInput& input, int threads)
{
    const Extent extent = input.image.extent();
    RETRACTOR_ASSERT(input.mediastinum.size() == extent.voxel_count());
    RETRACTOR_ASSERT(input.abdomen.size() == extent.voxel_count());
    Mask soft(input.mediastinum.size());
    for (std::size_t v = 0; v < soft.size(); ++v)
        soft[v] = input.mediastinum[v] != 0 && input.image.hu[v] > kSoftHu ? 1 : 0;
    soft = common(majority(extent, soft, 1, threads), input.mediastinum);
    Vessels vessels;
    vessels.heart = find_heart(input, soft);
    vessels.heart_how = "the soft tissue between the lungs that is thicker than 40 mm, below the great vessels";
    constexpr double kLeastHeartMl = 150.0;
    if (volume_ml(extent, vessels.heart) < kLeastHeartMl) {
        vessels.warnings.emplace_back("the heart was not found: it is part of the mediastinum");
        vessels.heart.assign(vessels.heart.size(), 0);
    }
    const Aorta aorta = find_aorta(
        { input.image, united(input.mediastinum, input.abdomen), input.lungs, input.spine, input.sternum, input.bones },
        threads);
    vessels.aorta = aorta.mask;
    vessels.contrast = aorta.contrast;
    if (count_set(aorta.mask) == 0)
        vessels.warnings.emplace_back("the aorta was not found: it is part of the mediastinum");
    else if (!aorta.contrast)
        vessels.warnings.emplace_back("no contrast in the vessels: the aorta is a rough region");
    vessels.aorta_how = aorta.contrast
        ? "contrast of " + std::to_string(std::lround(aorta.usual_hu)) + " HU, followed from the heart over the arch"
        : "a tube of soft tissue, " + std::to_string(std::lround(2.0 * aorta.radius_mm))
            + " mm wide, beside the spine and behind the sternum, joined by a bow";
    return vessels;
}

} // namespace retractor::datasets::segmentation
