#include "mesh/surface/label_surface.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkImageGaussianSmooth.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::mesh {

namespace {

    constexpr double kLevel = 0.5;
    /// The Gaussian is cut off at this number of standard deviations; the filter renormalises the missing 0.3 %.
    constexpr double kKernelRadius = 3.0;
    /// Value of voxels that smoothing would erase. Their outline then runs about half-way to the neighbours outside,
    /// whose smoothed value is about 0.2.
    constexpr float kThinValue = 0.75F;

    using Box = Eigen::AlignedBox3i; ///< first and last index per axis

    /// The box round the voxels of the mask; empty when there is none.
    Box bounding_box(const ImageGrid& grid, std::span<const std::uint8_t> mask)
    {
        Box box;
        std::size_t at = 0;
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i, ++at)
                    if (mask[at] != 0)
                        box.extend(Eigen::Vector3i(i, j, k));
        return box;
    }

    /// The values inside `box` as an image with the extent of the box. Values beyond the original image are 0.
    template <typename Value>
    vtkSmartPointer<vtkImageData> indicator(const ImageGrid& grid, const Value& values, const Box& box)
    {
        auto image = vtkSmartPointer<vtkImageData>::New();
        const Eigen::Vector3i low = box.min(), high = box.max();
        image->SetExtent(low[0], high[0], low[1], high[1], low[2], high[2]);
        image->AllocateScalars(VTK_FLOAT, 1);
        auto* value = static_cast<float*>(image->GetScalarPointer());
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i)
                    *value++ = grid.contains(i, j, k) ? static_cast<float>(values[grid.offset(i, j, k)]) : 0.0F;
        return image;
    }

    /// Offsets of the 26 neighbours in an image with these row lengths.
    std::array<std::ptrdiff_t, 26> neighbours(std::size_t nx, std::size_t ny)
    {
        std::array<std::ptrdiff_t, 26> offsets {};
        std::size_t n = 0;
        for (int k = -1; k <= 1; ++k)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    if (i != 0 || j != 0 || k != 0)
                        offsets[n++] = (k * static_cast<std::ptrdiff_t>(ny) + j) * static_cast<std::ptrdiff_t>(nx) + i;
        return offsets;
    }

    /// Restores voxels of the mask that smoothing erased together with all their neighbours, and voxels that connect
    /// the restored voxels to the rest. The box has an empty margin, so that every voxel has all neighbours.
    void keep_thin_parts(const float* sharp, float* smooth, const Box& box)
    {
        const auto size = [&](int axis) { return static_cast<std::size_t>(box.sizes()[axis] + 1); };
        const std::size_t count = size(0) * size(1) * size(2);
        const auto around = neighbours(size(0), size(1));
        const auto erased = [&](std::size_t v) { return sharp[v] > 0.5F && smooth[v] < static_cast<float>(kLevel); };
        const auto at = [](std::size_t v, std::ptrdiff_t offset) { return v + static_cast<std::size_t>(offset); };

        std::vector<std::size_t> lost;
        for (std::size_t v = 0; v < count; ++v)
            if (erased(v) && std::none_of(around.begin(), around.end(), [&](std::ptrdiff_t o) {
                    return sharp[at(v, o)] > 0.5F && !erased(at(v, o));
                }))
                lost.push_back(v);
        std::vector<std::size_t> lifted = lost;
        for (const std::size_t v : lost)
            for (const std::ptrdiff_t o : around)
                if (erased(at(v, o)))
                    lifted.push_back(at(v, o));
        for (const std::size_t v : lifted)
            smooth[v] = kThinValue;
    }

    double signed_volume(const TriMesh& mesh)
    {
        const Vec3 origin = mesh.vertices.row(0).transpose();
        double volume = 0.0;
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.vertices.row(t[0]).transpose() - origin;
            const Vec3 b = mesh.vertices.row(t[1]).transpose() - origin;
            const Vec3 c = mesh.vertices.row(t[2]).transpose() - origin;
            volume += a.dot(b.cross(c)) / 6.0;
        }
        return volume;
    }

    TriMesh in_world(vtkPolyData* contour, const ImageGrid& grid)
    {
        TriMesh mesh;
        mesh.vertices.resize(contour->GetNumberOfPoints(), 3);
        for (vtkIdType v = 0; v < contour->GetNumberOfPoints(); ++v) {
            Vec3 index;
            contour->GetPoint(v, index.data());
            mesh.vertices.row(v) = grid.world(index).transpose();
        }
        const auto cells = vtk::TakeSmartPointer(contour->GetPolys()->NewIterator());
        for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
            vtkIdType n = 0;
            const vtkIdType* ids = nullptr;
            cells->GetCurrentCell(n, ids);
            mesh.triangles.push_back(
                { static_cast<VertexId>(ids[0]), static_cast<VertexId>(ids[1]), static_cast<VertexId>(ids[2]) });
        }
        // The signed volume of a closed surface is positive when the surface faces outwards, for axes of either
        // handedness.
        if (!mesh.triangles.empty() && signed_volume(mesh) < 0.0)
            for (auto& t : mesh.triangles)
                std::swap(t[1], t[2]);
        return mesh;
    }

    std::size_t bytes_of(const TriMesh& mesh)
    {
        return static_cast<std::size_t>(mesh.vertices.size()) * sizeof(double)
            + mesh.triangles.size() * sizeof(mesh.triangles[0]);
    }

    vtkSmartPointer<vtkImageData> smoothed(vtkImageData& image, const Vec3& sigma)
    {
        vtkNew<vtkImageGaussianSmooth> gaussian;
        gaussian->SetInputData(&image);
        gaussian->SetStandardDeviations(sigma[0], sigma[1], sigma[2]);
        gaussian->SetRadiusFactors(kKernelRadius, kKernelRadius, kKernelRadius);
        gaussian->Update();
        return gaussian->GetOutput();
    }

    TriMesh contour_of(vtkImageData& image, const ImageGrid& grid)
    {
        vtkNew<vtkFlyingEdges3D> contour;
        contour->SetInputData(&image);
        contour->SetValue(0, kLevel);
        contour->ComputeNormalsOff();
        contour->ComputeScalarsOff();
        contour->Update();
        return in_world(contour->GetOutput(), grid);
    }

    /// Widens the box by the radius of the Gaussian and an empty border.
    void widen(Box& box, const Vec3& sigma)
    {
        const Eigen::Vector3i margin = ((kKernelRadius * sigma).array().ceil().cast<int>() + 1).matrix();
        box.min() -= margin;
        box.max() += margin;
    }

    /// The grid whose voxels are blocks of `factor` voxels of `grid`. The last blocks may reach beyond `grid`.
    ImageGrid joined(const ImageGrid& grid, const std::array<int, 3>& factor)
    {
        ImageGrid coarse = grid;
        Vec3 middle;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<Eigen::Index>(axis);
            middle[a] = 0.5 * (factor[axis] - 1);
            coarse.spacing[a] *= factor[axis];
            coarse.size[axis] = (grid.size[axis] + factor[axis] - 1) / factor[axis];
        }
        coarse.origin = grid.world(middle);
        return coarse;
    }

    std::vector<std::uint8_t> wanted_labels(std::span<const Label> which)
    {
        std::vector<std::uint8_t> wanted(std::size_t { 1 } << 16U, 0);
        for (const Label label : which)
            wanted[label] = 1;
        return wanted;
    }

    void check_input(const ImageGrid& grid, std::size_t voxels, double smoothing_mm)
    {
        check_grid(grid);
        if (voxels != grid.voxel_count())
            throw InputError(
                "the mask has " + std::to_string(voxels) + " voxels, its grid " + std::to_string(grid.voxel_count()));
        if (!(smoothing_mm >= 0.0) || !std::isfinite(smoothing_mm))
            throw InputError("smoothing must be zero or more mm, not " + std::to_string(smoothing_mm));
    }

} // namespace

TriMesh mask_surface(const ImageGrid& grid, std::span<const std::uint8_t> mask, double smoothing_mm, const Job& job)
{
    check_input(grid, mask.size(), smoothing_mm);
    const Stopwatch watch;
    Box box = bounding_box(grid, mask);
    if (box.isEmpty() || job.cancelled())
        return {};
    const Vec3 sigma = Vec3::Constant(smoothing_mm).cwiseQuotient(grid.spacing);
    widen(box, sigma);

    vtkSmartPointer<vtkImageData> image = indicator(grid, mask, box);
    if (smoothing_mm > 0.0) {
        const vtkSmartPointer<vtkImageData> smooth = smoothed(*image, sigma);
        keep_thin_parts(
            static_cast<const float*>(image->GetScalarPointer()), static_cast<float*>(smooth->GetScalarPointer()), box);
        image = smooth;
    }
    TriMesh mesh = contour_of(*image, grid);
    record_part(job, "label surface", watch, bytes_of(mesh));
    return mesh;
}

TriMesh label_surface(const LabelVolume& labels, std::span<const Label> which, double smoothing_mm, const Job& job)
{
    check_input(labels.grid, labels.voxels.size(), smoothing_mm);
    const std::vector<std::uint8_t> wanted = wanted_labels(which);
    std::vector<std::uint8_t> mask(labels.voxels.size());
    std::transform(
        labels.voxels.begin(), labels.voxels.end(), mask.begin(), [&](Label label) { return wanted[label]; });
    return mask_surface(labels.grid, mask, smoothing_mm, job);
}

TriMesh viewing_surface(const LabelVolume& labels, std::span<const Label> which, double smoothing_mm, const Job& job)
{
    check_input(labels.grid, labels.voxels.size(), smoothing_mm);
    const Stopwatch watch;
    constexpr double kVoxelPerSmoothing = 0.6;
    std::array<int, 3> factor {};
    for (std::size_t axis = 0; axis < 3; ++axis)
        factor[axis] = std::max(1,
            static_cast<int>(kVoxelPerSmoothing * smoothing_mm / labels.grid.spacing[static_cast<Eigen::Index>(axis)]));
    const ImageGrid grid = joined(labels.grid, factor);
    const std::vector<std::uint8_t> wanted = wanted_labels(which);
    std::vector<float> inside(grid.voxel_count(), 0.0F);
    const float share = 1.0F / static_cast<float>(factor[0] * factor[1] * factor[2]);
    std::size_t from = 0;
    for (int k = 0; k < labels.grid.size[2]; ++k)
        for (int j = 0; j < labels.grid.size[1]; ++j)
            for (int i = 0; i < labels.grid.size[0]; ++i, ++from)
                if (wanted[labels.voxels[from]] != 0)
                    inside[grid.offset(i / factor[0], j / factor[1], k / factor[2])] += share;
    std::vector<std::uint8_t> occupied(inside.size());
    std::transform(inside.begin(), inside.end(), occupied.begin(), [](float f) { return f > 0.0F ? 1 : 0; });
    Box box = bounding_box(grid, occupied);
    if (box.isEmpty() || job.cancelled())
        return {};
    const Vec3 sigma = Vec3::Constant(smoothing_mm).cwiseQuotient(grid.spacing);
    widen(box, sigma);
    const vtkSmartPointer<vtkImageData> image = indicator(grid, inside, box);
    TriMesh mesh = contour_of(smoothing_mm > 0.0 ? *smoothed(*image, sigma) : *image, grid);
    record_part(job, "viewing surface", watch, bytes_of(mesh));
    return mesh;
}

} // namespace retractor::mesh
