#include "datasets/segmentation/body.h"

#include "mesh/base/error.h"
#include "mesh/image/plane_holes.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kSkinHu = -350; // between air and skin; foam and cloth are darker
    constexpr int kTop = 32767;
    constexpr int kCells = 2; // voxels along each side of a cell
    constexpr double kLeastTrunkMl = 2000.0; // volume of a child's chest

    /// The share of the grid's side faces (left, right, front, back) that the body covers.
    double cut_off_share(const Extent& extent, const Mask& body)
    {
        std::size_t on_side = 0;
        std::size_t v = 0;
        for (int k = 0; k < extent.size[2]; ++k)
            for (int j = 0; j < extent.size[1]; ++j)
                for (int i = 0; i < extent.size[0]; ++i, ++v)
                    if (body[v] != 0 && (i == 0 || j == 0 || i + 1 == extent.size[0] || j + 1 == extent.size[1]))
                        ++on_side;
        return static_cast<double>(on_side)
            / (2.0 * static_cast<double>(extent.size[2]) * (extent.size[0] + extent.size[1]));
    }

    /// Clears voxels near the side faces. The shrinking half of a closing counts voxels beyond the border as set, and
    /// would otherwise close the air between skin and border.
    Mask away_from_sides(const Extent& extent, Mask mask, double margin_mm)
    {
        const int mx = static_cast<int>(std::ceil(margin_mm / extent.spacing[0])) + 1;
        const int my = static_cast<int>(std::ceil(margin_mm / extent.spacing[1])) + 1;
        std::size_t v = 0;
        for (int k = 0; k < extent.size[2]; ++k)
            for (int j = 0; j < extent.size[1]; ++j)
                for (int i = 0; i < extent.size[0]; ++i, ++v)
                    if (i < mx || j < my || i + mx >= extent.size[0] || j + my >= extent.size[1])
                        mask[v] = 0;
        return mask;
    }

} // namespace

Body segment_body(const WorkingImage& image, int threads)
{
    // An opening of this radius (mm) removes a table's shell, a lead and a fold of a blanket, and keeps every chest
    // wall.
    constexpr double kOpening = 4.5;
    constexpr double kRegain = 1.5; // restores the corners that the opening removes
    constexpr double kClose = 6.0;
    constexpr double kLead = 3.0;
    const Extent extent = image.extent();
    const Mask solid = threshold(image.hu, kSkinHu, kTop);
    const Extent cells = coarse_extent(extent, kCells);
    const Mask solid_cells = coarse_mask(extent, solid, kCells, 0.5);
    const Mask core = largest_piece(cells, eroded(cells, solid_cells, kOpening));
    Mask trunk = common(dilated(cells, core, kOpening + kRegain), solid_cells);
    trunk = united(trunk, away_from_sides(cells, closed(cells, trunk, kClose), kClose));
    trunk = holes_filled(cells, mesh::holes_filled_in_planes(cells.size, trunk, 2));
    if (volume_ml(cells, trunk) < kLeastTrunkMl)
        throw InputError("no body was found: the largest connected piece above " + std::to_string(kSkinHu)
                + " HU that is thicker than " + std::to_string(static_cast<int>(2.0 * kOpening)) + " mm has "
                + std::to_string(std::lround(volume_ml(cells, trunk))) + " ml",
            "body");
    // The surface comes from the fine image, within one cell of the coarse surface.
    const Mask near = fine_values(extent, dilated(cells, trunk, 1.2 * cells.spacing[0]), kCells);
    const Mask inside = fine_values(extent, eroded(cells, trunk, 1.2 * cells.spacing[0]), kCells);
    Body body;
    body.mask = united(common(near, solid), inside);
    // The window is wide enough to remove a lead on the skin.
    const int smoothing = std::max(1, static_cast<int>(std::lround(kLead / extent.spacing[0])));
    body.mask = largest_piece(extent, majority(extent, body.mask, smoothing, threads));
    body.mask = holes_filled(extent, mesh::holes_filled_in_planes(extent.size, body.mask, 2));
    constexpr double kMuch = 0.02;
    constexpr double kCrop = 0.5;
    const double cut_off = cut_off_share(extent, body.mask);
    if (cut_off > kCrop)
        throw InputError("the image is a crop from inside the body (tissue fills "
                + std::to_string(std::lround(100.0 * cut_off))
                + " % of its sides): skin and chest wall are not in view, so there is no wall to be found",
            "body");
    if (cut_off > kMuch)
        body.warnings.emplace_back(
            "the body reaches the sides of the image: skin and wall are missing there (arms or flanks out of view)");
    return body;
}

} // namespace retractor::datasets::segmentation
