#include "datasets/segmentation/image/image_filters.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkImportImageFilter.h>
#include <itkMultiThreaderBase.h>
#include <itkRelabelComponentImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    using MaskImage = itk::Image<std::uint8_t, 3>;
    using ValueImage = itk::Image<std::int16_t, 3>;
    using FloatImage = itk::Image<float, 3>;
    using PieceImage = itk::Image<std::int32_t, 3>;

    std::atomic<int> threads_in_use { 2 };

    [[maybe_unused]] bool is_grid(const Extent& extent, std::size_t values)
    {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (extent.size[axis] <= 0 || !(extent.spacing[axis] > 0.0) || !std::isfinite(extent.spacing[axis]))
                return false;
        return values == extent.voxel_count();
    }

    [[maybe_unused]] bool is_radius(double radius_mm) { return radius_mm >= 0.0 && std::isfinite(radius_mm); }

    /// Makes an image of the caller's memory without copying. The memory must outlive the image.
    template <typename Pixel>
    typename itk::ImportImageFilter<Pixel, 3>::Pointer import_image(const Extent& extent, std::span<const Pixel> values)
    {
        auto import = itk::ImportImageFilter<Pixel, 3>::New();
        typename itk::ImportImageFilter<Pixel, 3>::SizeType size {};
        for (unsigned axis = 0; axis < 3; ++axis)
            size[axis] = static_cast<itk::SizeValueType>(extent.size[axis]);
        import->SetRegion({ {}, size });
        import->SetSpacing(extent.spacing.data());
        // ITK only reads through this pointer; its interface predates const.
        import->SetImportPointer(const_cast<Pixel*>(values.data()), values.size(), false);
        import->Update();
        return import;
    }

    template <typename Filter> typename Filter::Pointer make_filter()
    {
        auto filter = Filter::New();
        filter->SetNumberOfWorkUnits(static_cast<itk::ThreadIdType>(threads_in_use.load()));
        return filter;
    }

    template <typename Image> auto values_of(const Image& image)
    {
        using Pixel = typename Image::PixelType;
        const Pixel* first = image.GetBufferPointer();
        return std::vector<Pixel>(first, first + image.GetLargestPossibleRegion().GetNumberOfPixels());
    }

    /// A box of voxels, [low, high).
    struct Box {
        std::array<int, 3> low { 0, 0, 0 };
        std::array<int, 3> high { 0, 0, 0 };
        bool empty() const { return high[0] <= low[0]; }
    };

    /// Calls visit(offset of the first voxel, number of voxels) for each row of a box.
    template <typename Visit> void for_rows(const Extent& extent, const Box& box, const Visit& visit)
    {
        const auto nx = static_cast<std::size_t>(extent.size[0]);
        const auto ny = static_cast<std::size_t>(extent.size[1]);
        for (int k = box.low[2]; k < box.high[2]; ++k)
            for (int j = box.low[1]; j < box.high[1]; ++j)
                visit((static_cast<std::size_t>(k) * ny + static_cast<std::size_t>(j)) * nx
                        + static_cast<std::size_t>(box.low[0]),
                    static_cast<std::size_t>(box.high[0] - box.low[0]));
    }

    /// The bounding box of the set voxels, extended by a margin; empty for an empty mask.
    Box box_of(const Extent& extent, const Mask& mask, double margin_mm)
    {
        Box box { extent.size, { 0, 0, 0 } };
        const auto nx = static_cast<std::size_t>(extent.size[0]);
        std::size_t row = 0;
        for (int k = 0; k < extent.size[2]; ++k)
            for (int j = 0; j < extent.size[1]; ++j, row += nx) {
                const auto* first = mask.data() + row;
                const auto* found = std::find_if(first, first + nx, [](std::uint8_t m) { return m != 0; });
                if (found == first + nx)
                    continue;
                const auto* last = first + nx - 1;
                while (*last == 0)
                    --last;
                box.low = { std::min(box.low[0], static_cast<int>(found - first)), std::min(box.low[1], j),
                    std::min(box.low[2], k) };
                box.high = { std::max(box.high[0], static_cast<int>(last - first) + 1), std::max(box.high[1], j + 1),
                    std::max(box.high[2], k + 1) };
            }
        if (box.empty())
            return {};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int margin = static_cast<int>(std::ceil(margin_mm / extent.spacing[axis])) + 1;
            box.low[axis] = std::max(0, box.low[axis] - margin);
            box.high[axis] = std::min(extent.size[axis], box.high[axis] + margin);
        }
        return box;
    }

    /// The mask within a box, optionally inverted.
    Mask cropped(const Extent& extent, const Mask& mask, const Box& box, bool inverted)
    {
        Mask out;
        out.reserve(mask.size());
        for_rows(extent, box, [&](std::size_t first, std::size_t count) {
            for (std::size_t v = first; v < first + count; ++v)
                out.push_back(static_cast<std::uint8_t>((mask[v] != 0) != inverted));
        });
        return out;
    }

    Extent extent_of(const Extent& extent, const Box& box)
    {
        Extent out = extent;
        for (std::size_t axis = 0; axis < 3; ++axis)
            out.size[axis] = box.high[axis] - box.low[axis];
        return out;
    }

    /// Returns a mask with keep(distance) in each voxel of the box and 0 outside. The distance leads to the nearest set
    /// voxel, or with `inverted` to the nearest unset voxel.
    template <typename Keep>
    Mask by_distance(const Extent& extent, const Mask& mask, const Box& box, bool inverted, const Keep& keep)
    {
        const std::vector<float> distance = distance_to(extent_of(extent, box), cropped(extent, mask, box, inverted));
        Mask out(mask.size(), 0);
        std::size_t at = 0;
        for_rows(extent, box, [&](std::size_t first, std::size_t count) {
            for (std::size_t v = first; v < first + count; ++v, ++at)
                out[v] = static_cast<std::uint8_t>(keep(static_cast<double>(distance[at])));
        });
        return out;
    }

    /// A slightly larger radius, because distances have single precision and a radius of whole voxels must reach the
    /// last voxel.
    double with_slack(double radius_mm) { return radius_mm * (1.0 + 1e-5) + 1e-6; }

} // namespace

void set_filter_threads(int threads)
{
    RETRACTOR_ASSERT(threads >= 1);
    threads_in_use = threads;
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(static_cast<itk::ThreadIdType>(threads));
}

Mask threshold(std::span<const std::int16_t> values, int low, int high)
{
    Mask mask(values.size());
    std::transform(values.begin(), values.end(), mask.begin(),
        [low, high](int value) { return static_cast<std::uint8_t>(value >= low && value <= high); });
    return mask;
}

std::vector<float> distance_to(const Extent& extent, const Mask& mask)
{
    RETRACTOR_ASSERT(is_grid(extent, mask.size()));
    if (std::find_if(mask.begin(), mask.end(), [](std::uint8_t m) { return m != 0; }) == mask.end()) {
        double squared = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            squared += std::pow(extent.spacing[axis] * extent.size[axis], 2.0);
        return std::vector<float>(mask.size(), static_cast<float>(std::sqrt(squared)));
    }
    const auto image = import_image<std::uint8_t>(extent, mask);
    auto filter = make_filter<itk::SignedMaurerDistanceMapImageFilter<MaskImage, FloatImage>>();
    filter->SetInput(image->GetOutput());
    filter->SetBackgroundValue(0);
    filter->SetSquaredDistance(false);
    filter->SetUseImageSpacing(true);
    filter->Update();
    std::vector<float> distance = values_of(*filter->GetOutput());
    // Inside the mask, the filter gives the negative distance to the rim.
    for (float& d : distance)
        d = std::max(d, 0.0F);
    return distance;
}

Mask dilated(const Extent& extent, const Mask& mask, double radius_mm)
{
    RETRACTOR_ASSERT(is_grid(extent, mask.size()));
    RETRACTOR_ASSERT(is_radius(radius_mm));
    const Box box = box_of(extent, mask, radius_mm);
    if (box.empty())
        return Mask(mask.size(), 0);
    return by_distance(extent, mask, box, false, [r = with_slack(radius_mm)](double d) { return d <= r; });
}

Mask eroded(const Extent& extent, const Mask& mask, double radius_mm)
{
    RETRACTOR_ASSERT(is_grid(extent, mask.size()));
    RETRACTOR_ASSERT(is_radius(radius_mm));
    const Box box = box_of(extent, mask, 0.0);
    if (box.empty())
        return Mask(mask.size(), 0);
    const Mask unset = cropped(extent, mask, box, true);
    if (std::find_if(unset.begin(), unset.end(), [](std::uint8_t m) { return m != 0; }) == unset.end())
        return mask; // outside counts as set, so there is nothing to shrink from
    return by_distance(extent, mask, box, true, [r = with_slack(radius_mm)](double d) { return d > r; });
}

Mask opened(const Extent& extent, const Mask& mask, double radius_mm)
{
    return dilated(extent, eroded(extent, mask, radius_mm), radius_mm);
}

Mask closed(const Extent& extent, const Mask& mask, double radius_mm)
{
    return eroded(extent, dilated(extent, mask, radius_mm), radius_mm);
}

Pieces connected_pieces(const Extent& extent, const Mask& mask)
{
    RETRACTOR_ASSERT(is_grid(extent, mask.size()));
    const auto image = import_image<std::uint8_t>(extent, mask);
    auto components = make_filter<itk::ConnectedComponentImageFilter<MaskImage, PieceImage>>();
    components->SetInput(image->GetOutput());
    components->FullyConnectedOff();
    auto relabel = make_filter<itk::RelabelComponentImageFilter<PieceImage, PieceImage>>();
    relabel->SetInput(components->GetOutput());
    relabel->SetSortByObjectSize(true);
    relabel->Update();
    Pieces pieces;
    pieces.piece_of = values_of(*relabel->GetOutput());
    for (const auto size : relabel->GetSizeOfObjectsInPixels())
        pieces.voxels.push_back(static_cast<std::size_t>(size));
    return pieces;
}

Mask largest_piece(const Extent& extent, const Mask& mask)
{
    const Pieces pieces = connected_pieces(extent, mask);
    Mask out(mask.size());
    std::transform(pieces.piece_of.begin(), pieces.piece_of.end(), out.begin(),
        [](std::int32_t piece) { return static_cast<std::uint8_t>(piece == 1); });
    return out;
}

Mask reached_from(const Extent& extent, const Mask& mask, const Mask& seeds)
{
    RETRACTOR_ASSERT(is_grid(extent, seeds.size()));
    const Pieces pieces = connected_pieces(extent, mask);
    std::vector<std::uint8_t> reached(pieces.voxels.size() + 1, 0);
    for (std::size_t v = 0; v < seeds.size(); ++v)
        if (seeds[v] != 0)
            reached[static_cast<std::size_t>(pieces.piece_of[v])] = 1;
    reached[0] = 0;
    Mask out(mask.size());
    std::transform(pieces.piece_of.begin(), pieces.piece_of.end(), out.begin(),
        [&](std::int32_t piece) { return reached[static_cast<std::size_t>(piece)]; });
    return out;
}

Mask holes_filled(const Extent& extent, const Mask& mask)
{
    RETRACTOR_ASSERT(is_grid(extent, mask.size()));
    const auto image = import_image<std::uint8_t>(extent, mask);
    auto filter = make_filter<itk::BinaryFillholeImageFilter<MaskImage>>();
    filter->SetInput(image->GetOutput());
    filter->SetForegroundValue(1);
    filter->SetFullyConnected(false);
    filter->Update();
    return values_of(*filter->GetOutput());
}

std::vector<std::int16_t> smoothed(const Extent& extent, std::span<const std::int16_t> values, double sigma_mm)
{
    RETRACTOR_ASSERT(is_grid(extent, values.size()));
    RETRACTOR_ASSERT(is_radius(sigma_mm));
    if (sigma_mm == 0.0)
        return { values.begin(), values.end() };
    for (const int size : extent.size)
        if (size < 4)
            throw InputError("the recursive filter needs at least 4 voxels along each axis", "smoothed");
    const auto image = import_image<std::int16_t>(extent, values);
    auto filter = make_filter<itk::SmoothingRecursiveGaussianImageFilter<ValueImage, FloatImage>>();
    filter->SetInput(image->GetOutput());
    filter->SetSigma(sigma_mm);
    filter->Update();
    const float* first = filter->GetOutput()->GetBufferPointer();
    std::vector<std::int16_t> out(values.size());
    std::transform(first, first + out.size(), out.begin(),
        [](float value) { return static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0F, 32767.0F))); });
    return out;
}

} // namespace retractor::datasets::segmentation
