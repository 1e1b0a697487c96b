#include "ui/scene/vtk/slice_actor.h"

#include "mesh/base/assert.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkPlaneSource.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace retractor::ui {

namespace {

    /// Largest number of pixels per side; more than a viewport shows.
    constexpr double kLargestSide = 1400.0;
    /// Samples are finer than the voxels, so that outlines stay thin.
    constexpr double kPixelsPerVoxel = 2.0;

    /// The continuous index of each pixel of a slice: it grows by the same steps along rows and columns.
    struct PixelIndices {
        Vec3 first, across, upward;

        PixelIndices(const mesh::ImageGrid& grid, const SliceImage& image)
            : first(grid.index(image.corner))
            , across(grid.index(image.corner + image.across) - first)
            , upward(grid.index(image.corner + image.upward) - first)
        {
        }
        Vec3 at(int column, int row) const { return first + column * across + row * upward; }
    };

    /// Trilinear interpolation at a continuous index; nothing outside the grid.
    std::optional<double> value_at(const mesh::Volume& image, const Vec3& at)
    {
        const mesh::ImageGrid& grid = image.grid;
        std::array<int, 3> low {};
        std::array<double, 3> share {};
        for (int a = 0; a < 3; ++a) {
            const auto axis = static_cast<std::size_t>(a);
            if (!(at[a] >= -0.5 && at[a] <= grid.size[axis] - 0.5))
                return std::nullopt;
            const double inside = std::clamp(at[a], 0.0, static_cast<double>(grid.size[axis] - 1));
            low[axis] = std::min(static_cast<int>(inside), std::max(grid.size[axis] - 2, 0));
            share[axis] = inside - low[axis];
        }
        const std::size_t along_i = grid.size[0] > 1 ? 1 : 0;
        const std::size_t along_j = grid.size[1] > 1 ? static_cast<std::size_t>(grid.size[0]) : 0;
        const std::size_t along_k
            = grid.size[2] > 1 ? static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]) : 0;
        const std::int16_t* const corner = &image.voxels[grid.offset(low[0], low[1], low[2])];
        const auto along_row = [&](std::size_t offset) {
            return (1.0 - share[0]) * corner[offset] + share[0] * corner[offset + along_i];
        };
        const auto in_plane = [&](std::size_t offset) {
            return (1.0 - share[1]) * along_row(offset) + share[1] * along_row(offset + along_j);
        };
        return (1.0 - share[2]) * in_plane(0) + share[2] * in_plane(along_k);
    }

    SliceImage oblique_frame(const SliceItem& slice, const ObliqueSlice& frame)
    {
        const double wanted
            = slice.pixel_mm > 0.0 ? slice.pixel_mm : slice.image->grid.spacing.minCoeff() / kPixelsPerVoxel;
        const double pixel = std::max(wanted, 2.0 * std::max(frame.half_width_mm, frame.half_height_mm) / kLargestSide);
        SliceImage image;
        image.columns = std::max(1, static_cast<int>(std::lround(2.0 * frame.half_width_mm / pixel)));
        image.rows = std::max(1, static_cast<int>(std::lround(2.0 * frame.half_height_mm / pixel)));
        image.across = frame.right * (2.0 * frame.half_width_mm / image.columns);
        image.upward = frame.up * (2.0 * frame.half_height_mm / image.rows);
        image.corner = slice.point - frame.half_width_mm * frame.right - frame.half_height_mm * frame.up
            + 0.5 * image.across + 0.5 * image.upward;
        return image;
    }

    /// The rectangle of the plane that covers the grid, divided into pixels; an oblique slice has its own.
    SliceImage frame_of(const SliceItem& slice)
    {
        if (slice.oblique)
            return oblique_frame(slice, *slice.oblique);
        const mesh::ImageGrid& grid = slice.image->grid;
        Vec3 low = grid.world(Vec3(-0.5, -0.5, -0.5)), high = low;
        for (int corner = 1; corner < 8; ++corner) {
            const Vec3 p = grid.world(Vec3((corner & 1) != 0 ? grid.size[0] - 0.5 : -0.5,
                (corner & 2) != 0 ? grid.size[1] - 0.5 : -0.5, (corner & 4) != 0 ? grid.size[2] - 0.5 : -0.5));
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        int normal = 2, across = 0, upward = 1;
        if (slice.plane == SlicePlane::coronal) {
            normal = 1;
            upward = 2;
        } else if (slice.plane == SlicePlane::sagittal) {
            normal = 0;
            across = 1;
            upward = 2;
        }
        const Vec3 extent = high - low;
        const double wanted = slice.pixel_mm > 0.0 ? slice.pixel_mm : grid.spacing.minCoeff() / kPixelsPerVoxel;
        const double pixel = std::max(wanted, std::max(extent[across], extent[upward]) / kLargestSide);
        SliceImage image;
        image.columns = std::max(1, static_cast<int>(std::lround(extent[across] / pixel)));
        image.rows = std::max(1, static_cast<int>(std::lround(extent[upward] / pixel)));
        image.across = Vec3::Unit(across) * (extent[across] / image.columns);
        image.upward = Vec3::Unit(upward) * (extent[upward] / image.rows);
        image.corner = low + 0.5 * image.across + 0.5 * image.upward;
        image.corner[normal] = slice.point[normal];
        return image;
    }

    std::vector<Label> sample_labels(const SliceItem& slice, const SliceImage& image)
    {
        std::vector<Label> labels;
        labels.reserve(static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(image.rows));
        const mesh::ImageGrid& grid = slice.labels->grid;
        const PixelIndices indices(grid, image);
        for (int row = 0; row < image.rows; ++row)
            for (int column = 0; column < image.columns; ++column) {
                const Vec3 at = indices.at(column, row);
                const auto i = std::lround(at[0]), j = std::lround(at[1]), k = std::lround(at[2]);
                const bool inside
                    = i >= 0 && j >= 0 && k >= 0 && i < grid.size[0] && j < grid.size[1] && k < grid.size[2];
                labels.push_back(inside
                        ? slice.labels
                              ->voxels[grid.offset(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k))]
                        : Label { 0 });
            }
        return labels;
    }

    void paint_labels(const SliceItem& slice, SliceImage& image)
    {
        const std::vector<Label> labels = sample_labels(slice, image);
        std::vector<const Color*> color_of(slice.outline_of_label.rbegin()->first + 1U, nullptr);
        for (const auto& [label, color] : slice.outline_of_label)
            color_of[label] = &color;
        RETRACTOR_ASSERT(image.rgb.size() == 3 * labels.size());
        const auto at = [&](int column, int row) {
            return labels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.columns)
                + static_cast<std::size_t>(column)];
        };
        for (int row = 0; row < image.rows; ++row)
            for (int column = 0; column < image.columns; ++column) {
                const Label here = at(column, row);
                const Color* const color = here < color_of.size() ? color_of[here] : nullptr;
                if (color == nullptr)
                    continue;
                const bool border = column == 0 || row == 0 || column + 1 == image.columns || row + 1 == image.rows
                    || at(column - 1, row) != here || at(column + 1, row) != here || at(column, row - 1) != here
                    || at(column, row + 1) != here;
                const double share = border ? 1.0 : slice.fill;
                const std::array<double, 3> rgb { color->r, color->g, color->b };
                const std::size_t first = 3
                    * (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.columns)
                        + static_cast<std::size_t>(column));
                for (std::size_t c = 0; c < 3; ++c)
                    image.rgb[first + c] = static_cast<std::uint8_t>(
                        std::lround((1.0 - share) * image.rgb[first + c] + share * 255.0 * rgb[c]));
            }
    }

} // namespace

SliceImage sample_slice(const SliceItem& slice)
{
    RETRACTOR_ASSERT(slice.image != nullptr);
    SliceImage image = frame_of(slice);
    RETRACTOR_ASSERT(image.columns > 0 && image.rows > 0);
    image.rgb.reserve(3 * static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(image.rows));
    const PixelIndices indices(slice.image->grid, image);
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.columns; ++column) {
            const auto hu = value_at(*slice.image, indices.at(column, row));
            const double grey = hu ? std::clamp((*hu - slice.level_hu) / slice.window_hu + 0.5, 0.0, 1.0) : 0.0;
            image.rgb.insert(image.rgb.end(), 3, static_cast<std::uint8_t>(std::lround(255.0 * grey)));
        }
    if (slice.labels != nullptr && !slice.outline_of_label.empty())
        paint_labels(slice, image);
    return image;
}

namespace {

    vtkSmartPointer<vtkTexture> texture_of(const SliceImage& image)
    {
        auto scalars = vtkSmartPointer<vtkUnsignedCharArray>::New();
        scalars->SetNumberOfComponents(3);
        scalars->SetNumberOfTuples(static_cast<vtkIdType>(image.rgb.size() / 3));
        std::copy(image.rgb.begin(), image.rgb.end(), scalars->GetPointer(0));
        auto data = vtkSmartPointer<vtkImageData>::New();
        data->SetDimensions(image.columns, image.rows, 1);
        data->GetPointData()->SetScalars(scalars);
        auto texture = vtkSmartPointer<vtkTexture>::New();
        texture->SetInputData(data);
        texture->InterpolateOn();
        texture->SetColorModeToDirectScalars();
        return texture;
    }

    vtkSmartPointer<vtkActor> textured(vtkPolyDataMapper* mapper, const SliceImage& image)
    {
        auto actor = vtkSmartPointer<vtkActor>::New();
        actor->SetMapper(mapper);
        actor->SetTexture(texture_of(image));
        actor->GetProperty()->SetLighting(false);
        return actor;
    }

    /// One rectangle for every run of pixels of a row that have a label.
    vtkSmartPointer<vtkPolyData> labelled_runs(const SliceImage& image, const std::vector<Label>& labels)
    {
        auto points = vtkSmartPointer<vtkPoints>::New();
        auto places = vtkSmartPointer<vtkFloatArray>::New(); // in the texture
        places->SetNumberOfComponents(2);
        auto cells = vtkSmartPointer<vtkCellArray>::New();
        const auto add_corner = [&](int column, int row) {
            const Vec3 at = image.corner + (column - 0.5) * image.across + (row - 0.5) * image.upward;
            places->InsertNextTuple2(
                static_cast<double>(column) / image.columns, static_cast<double>(row) / image.rows);
            cells->InsertCellPoint(points->InsertNextPoint(at.data()));
        };
        std::size_t pixel = 0;
        for (int row = 0; row < image.rows; ++row)
            for (int column = 0; column < image.columns;) {
                const int first = column;
                while (column < image.columns && labels[pixel] != 0) {
                    ++column;
                    ++pixel;
                }
                if (column == first) {
                    ++column;
                    ++pixel;
                    continue;
                }
                cells->InsertNextCell(4);
                add_corner(first, row);
                add_corner(column, row);
                add_corner(column, row + 1);
                add_corner(first, row + 1);
            }
        auto data = vtkSmartPointer<vtkPolyData>::New();
        data->SetPoints(points);
        data->SetPolys(cells);
        data->GetPointData()->SetTCoords(places);
        return data;
    }

} // namespace

vtkSmartPointer<vtkActor> cut_face_actor(const SliceItem& slice)
{
    RETRACTOR_ASSERT(slice.labels != nullptr);
    const SliceImage image = sample_slice(slice);
    auto mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
    mapper->SetInputData(labelled_runs(image, sample_labels(slice, image)));
    return textured(mapper, image);
}

vtkSmartPointer<vtkActor> slice_actor(const SliceItem& slice)
{
    const SliceImage image = sample_slice(slice);
    auto plane = vtkSmartPointer<vtkPlaneSource>::New();
    const Vec3 low = image.corner - 0.5 * image.across - 0.5 * image.upward;
    const Vec3 right = low + image.columns * image.across, top = low + image.rows * image.upward;
    plane->SetOrigin(low.x(), low.y(), low.z());
    plane->SetPoint1(right.x(), right.y(), right.z());
    plane->SetPoint2(top.x(), top.y(), top.z());
    auto mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
    mapper->SetInputConnection(plane->GetOutputPort());
    return textured(mapper, image);
}

} // namespace retractor::ui
