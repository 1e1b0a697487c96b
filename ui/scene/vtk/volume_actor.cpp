#include "ui/scene/vtk/volume_actor.h"

#include "mesh/base/assert.h"

#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::ui {

namespace {

    constexpr std::int16_t kAir = -1000;
    /// Ray samples per voxel edge: fewer show rings on bone.
    constexpr double kSamplesPerVoxel = 1.0;

    struct Knot {
        double hu;
        Color color;
        double opacity; ///< per mm
    };

    // The look of a chest CT: lungs as a haze, soft organs, contrast-filled heart and vessels, bone.
    // Hounsfield units: lung below -500, fat near -100, organs 0 to 90, contrast-filled blood 130 to 350, bone above.
    constexpr std::array kKnots {
        Knot { -1024, { 0.0, 0.0, 0.0 }, 0.0 },
        Knot { -930, { 0.80, 0.55, 0.55 }, 0.0 },
        Knot { -850, { 0.90, 0.66, 0.64 }, 0.008 },
        Knot { -650, { 0.90, 0.64, 0.62 }, 0.014 },
        Knot { -450, { 0.80, 0.50, 0.48 }, 0.0 },
        Knot { -150, { 0.92, 0.76, 0.40 }, 0.0 },
        Knot { -60, { 0.92, 0.76, 0.40 }, 0.010 },
        Knot { 0, { 0.72, 0.32, 0.26 }, 0.020 },
        Knot { 40, { 0.66, 0.22, 0.19 }, 0.10 },
        Knot { 110, { 0.64, 0.18, 0.16 }, 0.16 },
        Knot { 180, { 0.76, 0.12, 0.10 }, 0.35 },
        Knot { 300, { 0.82, 0.20, 0.14 }, 0.40 },
        Knot { 400, { 0.92, 0.82, 0.66 }, 0.55 },
        Knot { 1000, { 0.97, 0.94, 0.86 }, 0.80 },
        Knot { 3000, { 1.0, 1.0, 1.0 }, 0.90 },
    };

    vtkSmartPointer<vtkVolumeProperty> property_of(double opacity)
    {
        auto color = vtkSmartPointer<vtkColorTransferFunction>::New();
        auto alpha = vtkSmartPointer<vtkPiecewiseFunction>::New();
        for (const Knot& k : kKnots) {
            color->AddRGBPoint(k.hu, k.color.r, k.color.g, k.color.b);
            alpha->AddPoint(k.hu, k.opacity * opacity);
        }
        auto property = vtkSmartPointer<vtkVolumeProperty>::New();
        property->SetColor(color);
        property->SetScalarOpacity(alpha);
        property->SetScalarOpacityUnitDistance(1.0);
        property->SetInterpolationTypeToLinear();
        property->ShadeOn();
        property->SetAmbient(0.38);
        property->SetDiffuse(0.95);
        property->SetSpecular(0.20);
        property->SetSpecularPower(20.0);
        return property;
    }

    /// A grid of right-handed axes over the same voxels. A left-handed grid is read backwards along k.
    struct Placed {
        mesh::ImageGrid grid;
        bool reversed_k = false;
    };

    Placed right_handed(const mesh::ImageGrid& grid)
    {
        if (grid.direction.determinant() > 0.0)
            return { grid, false };
        mesh::ImageGrid mirrored = grid;
        mirrored.origin = grid.world(Vec3(0, 0, grid.size[2] - 1));
        mirrored.direction.col(2) *= -1.0;
        return { mirrored, true };
    }

    vtkSmartPointer<vtkMatrix4x4> pose_of(const mesh::ImageGrid& grid)
    {
        auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                matrix->SetElement(r, c, grid.direction(r, c));
            matrix->SetElement(r, 3, grid.origin[r]);
        }
        return matrix;
    }

    /// Smooths by one pass of (1 2 1) / 4 along each axis, because shading by gradients turns CT noise into grain. The
    /// smoothing reaches one voxel, like hidden_in() beyond the mask.
    void smooth_noise(std::vector<std::int16_t>& voxels, const mesh::ImageGrid& grid)
    {
        std::size_t stride = 1;
        for (const int size : grid.size) {
            const auto count = static_cast<std::size_t>(size);
            // Neighbouring lines are smoothed together, so that memory is read in order along every axis.
            std::vector<int> before(stride);
            for (std::size_t first = 0; first < voxels.size(); first += stride * count) {
                std::copy_n(voxels.begin() + static_cast<std::ptrdiff_t>(first), stride, before.begin());
                for (std::size_t n = 0; n < count; ++n) {
                    std::int16_t* row = voxels.data() + first + n * stride;
                    const std::int16_t* next = n + 1 < count ? row + stride : row;
                    for (std::size_t column = 0; column < stride; ++column) {
                        const int here = row[column];
                        const int after = next[column];
                        row[column] = static_cast<std::int16_t>((before[column] + 2 * here + after) / 4);
                        before[column] = here;
                    }
                }
            }
            stride *= count;
        }
    }

    /// Sets every voxel with a non-zero neighbour along `axis`.
    void spread(std::vector<std::uint8_t>& flags, const mesh::ImageGrid& grid, std::size_t axis)
    {
        std::size_t stride = 1;
        for (std::size_t a = 0; a < axis; ++a)
            stride *= static_cast<std::size_t>(grid.size[a]);
        const auto count = static_cast<std::size_t>(grid.size[axis]);
        std::vector<std::uint8_t> before(stride);
        for (std::size_t first = 0; first < flags.size(); first += stride * count) {
            std::fill(before.begin(), before.end(), std::uint8_t { 0 });
            for (std::size_t n = 0; n < count; ++n) {
                std::uint8_t* row = flags.data() + first + n * stride;
                const std::uint8_t* next = n + 1 < count ? row + stride : row;
                for (std::size_t column = 0; column < stride; ++column) {
                    const std::uint8_t here = row[column];
                    row[column] = static_cast<std::uint8_t>(before[column] | here | next[column]);
                    before[column] = here;
                }
            }
        }
    }

    /// One byte per voxel of `grid`; other than 0 means that the mask hides the voxel or one beside it.
    std::vector<std::uint8_t> hidden_in(const mesh::ImageGrid& grid, const VoxelMask& mask)
    {
        RETRACTOR_ASSERT(mask.hidden.size() == mask.grid.voxel_count());
        const auto [nx, ny, nz] = grid.size;
        std::vector<std::uint8_t> hidden(grid.voxel_count(), 0);
        // A mask index is affine in the image index, so one step per axis replaces a transform per voxel.
        const Vec3 start = mask.grid.index(grid.world(Vec3::Zero()));
        const Mat3 step
            = (mask.grid.direction.transpose() * grid.direction * grid.spacing.asDiagonal()).array().colwise()
            / mask.grid.spacing.array();
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j) {
                Vec3 at = start + step * Vec3(0, j, k);
                for (int i = 0; i < nx; ++i, at += step.col(0)) {
                    const int a = static_cast<int>(std::lround(at.x())), b = static_cast<int>(std::lround(at.y())),
                              c = static_cast<int>(std::lround(at.z()));
                    if (mask.grid.contains(a, b, c) && mask.hidden[mask.grid.offset(a, b, c)] != 0)
                        hidden[grid.offset(i, j, k)] = 1;
                }
            }
        for (std::size_t axis = 0; axis < 3; ++axis)
            spread(hidden, grid, axis);
        return hidden;
    }

    /// The value below which nothing shows.
    double clear_below()
    {
        const auto* const first
            = std::find_if(kKnots.begin(), kKnots.end(), [](const Knot& knot) { return knot.opacity > 0.0; });
        return std::prev(first)->hu;
    }

    /// The box of voxels that can be visible, with a margin for smoothing and interpolation; all voxels when none can.
    struct IndexBox {
        std::array<int, 3> low {}, high {}; ///< inclusive
    };

    IndexBox visible_box(const mesh::Volume& image, const std::vector<std::uint8_t>& hidden, double above)
    {
        RETRACTOR_ASSERT(image.voxels.size() == image.grid.voxel_count());
        RETRACTOR_ASSERT(hidden.empty() || hidden.size() == image.voxels.size());
        constexpr int kMargin = 3;
        const auto [nx, ny, nz] = image.grid.size;
        IndexBox box { { nx, ny, nz }, { -1, -1, -1 } };
        std::size_t at = 0;
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i, ++at)
                    if (image.voxels[at] > above && (hidden.empty() || hidden[at] == 0)) {
                        const std::array<int, 3> index { i, j, k };
                        for (std::size_t a = 0; a < 3; ++a) {
                            box.low[a] = std::min(box.low[a], index[a]);
                            box.high[a] = std::max(box.high[a], index[a]);
                        }
                    }
        if (box.high[0] < 0)
            return { { 0, 0, 0 }, { nx - 1, ny - 1, nz - 1 } };
        for (std::size_t a = 0; a < 3; ++a) {
            box.low[a] = std::max(box.low[a] - kMargin, 0);
            box.high[a] = std::min(box.high[a] + kMargin, image.grid.size[a] - 1);
        }
        return box;
    }

    /// The drawn part of the volume: without noise, with hidden voxels as air, and without the part that cannot be
    /// visible.
    mesh::Volume shown_part(const VolumeItem& item)
    {
        RETRACTOR_ASSERT(item.image != nullptr);
        const mesh::Volume& image = *item.image;
        const std::vector<std::uint8_t> hidden
            = item.mask != nullptr ? hidden_in(image.grid, *item.mask) : std::vector<std::uint8_t> {};
        const IndexBox box = visible_box(image, hidden, clear_below());
        mesh::Volume part { image.grid, {} };
        part.grid.origin = image.grid.world(Vec3(box.low[0], box.low[1], box.low[2]));
        for (std::size_t a = 0; a < 3; ++a)
            part.grid.size[a] = box.high[a] - box.low[a] + 1;
        part.voxels.resize(part.grid.voxel_count());
        const auto length = static_cast<std::size_t>(part.grid.size[0]);
        const auto row_of = [&](int j, int k) { return image.grid.offset(box.low[0], j + box.low[1], k + box.low[2]); };
        for (int k = 0; k < part.grid.size[2]; ++k)
            for (int j = 0; j < part.grid.size[1]; ++j)
                std::copy_n(image.voxels.data() + row_of(j, k), length, part.voxels.data() + part.grid.offset(0, j, k));
        smooth_noise(part.voxels, part.grid);
        if (!hidden.empty())
            for (int k = 0; k < part.grid.size[2]; ++k)
                for (int j = 0; j < part.grid.size[1]; ++j)
                    for (std::size_t i = 0; i < length; ++i)
                        if (hidden[row_of(j, k) + i] != 0)
                            part.voxels[part.grid.offset(0, j, k) + i] = kAir;
        return part;
    }

    vtkSmartPointer<vtkImageData> image_of(const mesh::Volume& shown, bool reversed_k)
    {
        RETRACTOR_ASSERT(shown.voxels.size() == shown.grid.voxel_count());
        const mesh::ImageGrid& grid = shown.grid;
        auto scalars = vtkSmartPointer<vtkShortArray>::New();
        scalars->SetNumberOfValues(static_cast<vtkIdType>(shown.voxels.size()));
        const std::size_t layer = static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
        const auto layers = static_cast<std::size_t>(grid.size[2]);
        for (std::size_t k = 0; k < layers; ++k)
            std::copy_n(shown.voxels.data() + (reversed_k ? layers - 1 - k : k) * layer, layer,
                scalars->GetPointer(static_cast<vtkIdType>(k * layer)));
        auto data = vtkSmartPointer<vtkImageData>::New();
        data->SetDimensions(grid.size.data());
        data->SetSpacing(grid.spacing.data());
        data->GetPointData()->SetScalars(scalars);
        return data;
    }

    bool same_mask(const VoxelMask* a, const VoxelMask* b)
    {
        if (a == b || a == nullptr || b == nullptr)
            return a == b;
        return a->grid.size == b->grid.size && a->grid.spacing == b->grid.spacing && a->grid.origin == b->grid.origin
            && a->grid.direction == b->grid.direction && a->hidden == b->hidden;
    }

} // namespace

struct VolumeCache::State {
    struct Entry {
        VolumeItem item; // keeps image and mask alive, so that their addresses are not used again
        vtkSmartPointer<vtkVolume> volume;
        double sample_mm = 1.0;
        bool used = true;
    };
    Job job;
    std::vector<Entry> entries;
    bool interactive = false;

    static bool same(const VolumeItem& a, const VolumeItem& b)
    {
        return a.image == b.image && same_mask(a.mask.get(), b.mask.get()) && a.opacity == b.opacity;
    }

    void set_quality(const Entry& entry) const
    {
        auto* mapper = vtkGPUVolumeRayCastMapper::SafeDownCast(entry.volume->GetMapper());
        mapper->SetImageSampleDistance(interactive ? 3.0F : 1.0F);
        mapper->SetSampleDistance(static_cast<float>(entry.sample_mm * (interactive ? 2.0 : 1.0)));
    }
};

VolumeCache::VolumeCache(const Job& job)
    : state_(std::make_unique<State>())
{
    state_->job = job;
}
VolumeCache::~VolumeCache() = default;

vtkSmartPointer<vtkVolume> VolumeCache::volume(const VolumeItem& item)
{
    for (State::Entry& entry : state_->entries)
        if (State::same(entry.item, item)) {
            entry.used = true;
            return entry.volume;
        }
    const Stopwatch watch;
    const mesh::Volume shown = shown_part(item);
    const Placed placed = right_handed(shown.grid);
    const auto data = image_of(shown, placed.reversed_k);
    auto mapper = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
    mapper->SetInputData(data);
    mapper->SetAutoAdjustSampleDistances(0);
    mapper->SetLockSampleDistanceToInputSpacing(0);
    mapper->SetUseJittering(1); // breaks up the rings of equal depth
    auto volume = vtkSmartPointer<vtkVolume>::New();
    volume->SetMapper(mapper);
    volume->SetProperty(property_of(item.opacity));
    volume->SetUserMatrix(pose_of(placed.grid));
    state_->entries.push_back({ item, volume, item.image->grid.spacing.minCoeff() / kSamplesPerVoxel, true });
    state_->set_quality(state_->entries.back());
    // The voxels are in memory twice: here and as a texture.
    record_part(state_->job, "volume rendering", watch, 2 * shown.voxels.size() * sizeof(std::int16_t));
    return volume;
}

void VolumeCache::sweep()
{
    std::erase_if(state_->entries, [](const State::Entry& e) { return !e.used; });
    for (State::Entry& entry : state_->entries)
        entry.used = false;
}

void VolumeCache::set_interactive(bool interactive)
{
    state_->interactive = interactive;
    for (const State::Entry& entry : state_->entries)
        state_->set_quality(entry);
}

} // namespace retractor::ui
