#include "ui/scene/volume_actor.h"

#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPlane.h>
#include <vtkPlaneCollection.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor {

namespace {

    constexpr std::int16_t kAir = -1000;
    /// Ray samples per voxel edge: fewer show rings on bone.
    constexpr double kSamplesPerVoxel = 1.0;

    struct Knot {
        double hu;
        Color color;
        double opacity; ///< per mm
    };

    // Lung below -500, fat near -100, organs 0 to 90, contrast-filled blood 130 to 350, bone above.
    const std::vector<Knot>& knots(VolumePreset preset)
    {
        static const std::vector<Knot> thorax {
            { -1024, { 0.0, 0.0, 0.0 }, 0.0 },
            { -930, { 0.80, 0.55, 0.55 }, 0.0 },
            { -850, { 0.90, 0.66, 0.64 }, 0.008 },
            { -650, { 0.90, 0.64, 0.62 }, 0.014 },
            { -450, { 0.80, 0.50, 0.48 }, 0.0 },
            { -150, { 0.92, 0.76, 0.40 }, 0.0 },
            { -60, { 0.92, 0.76, 0.40 }, 0.010 },
            { 0, { 0.72, 0.32, 0.26 }, 0.020 },
            { 40, { 0.66, 0.22, 0.19 }, 0.10 },
            { 110, { 0.64, 0.18, 0.16 }, 0.16 },
            { 180, { 0.76, 0.12, 0.10 }, 0.35 },
            { 300, { 0.82, 0.20, 0.14 }, 0.40 },
            { 400, { 0.92, 0.82, 0.66 }, 0.55 },
            { 1000, { 0.97, 0.94, 0.86 }, 0.80 },
            { 3000, { 1.0, 1.0, 1.0 }, 0.90 },
        };
        static const std::vector<Knot> soft_tissue {
            { -1024, { 0.0, 0.0, 0.0 }, 0.0 },
            { -20, { 0.80, 0.50, 0.35 }, 0.0 },
            { 30, { 0.66, 0.22, 0.19 }, 0.25 },
            { 110, { 0.64, 0.18, 0.16 }, 0.30 },
            { 180, { 0.76, 0.12, 0.10 }, 0.50 },
            { 300, { 0.82, 0.20, 0.14 }, 0.50 },
            { 400, { 0.92, 0.82, 0.66 }, 0.60 },
            { 3000, { 1.0, 1.0, 1.0 }, 0.90 },
        };
        static const std::vector<Knot> bone {
            { -1024, { 0.0, 0.0, 0.0 }, 0.0 },
            { 180, { 0.80, 0.60, 0.45 }, 0.0 },
            { 300, { 0.92, 0.82, 0.66 }, 0.25 },
            { 1000, { 0.97, 0.94, 0.86 }, 0.80 },
            { 3000, { 1.0, 1.0, 1.0 }, 0.90 },
        };
        static const std::vector<Knot> skin {
            { -1024, { 0.0, 0.0, 0.0 }, 0.0 },
            { -400, { 0.86, 0.65, 0.53 }, 0.0 },
            { -250, { 0.86, 0.65, 0.53 }, 0.6 },
            { 3000, { 0.86, 0.65, 0.53 }, 0.9 },
        };
        switch (preset) {
        case VolumePreset::soft_tissue:
            return soft_tissue;
        case VolumePreset::bone:
            return bone;
        case VolumePreset::skin:
            return skin;
        case VolumePreset::thorax:
            break;
        }
        return thorax;
    }

    vtkSmartPointer<vtkVolumeProperty> property_of(VolumePreset preset, double opacity)
    {
        auto color = vtkSmartPointer<vtkColorTransferFunction>::New();
        auto alpha = vtkSmartPointer<vtkPiecewiseFunction>::New();
        for (const Knot& k : knots(preset)) {
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

    /// A grid of right-handed axes over the same voxels: a left-handed one is read backwards along k.
    struct Placed {
        ImageGrid grid;
        bool reversed_k = false;
    };

    Placed right_handed(const ImageGrid& grid)
    {
        if (grid.direction.determinant() > 0.0)
            return { grid, false };
        ImageGrid mirrored = grid;
        mirrored.origin = grid.world(Vec3(0, 0, grid.size[2] - 1));
        mirrored.direction.col(2) *= -1.0;
        return { mirrored, true };
    }

    vtkSmartPointer<vtkMatrix4x4> pose_of(const ImageGrid& grid)
    {
        auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                matrix->SetElement(r, c, grid.direction(r, c));
            matrix->SetElement(r, 3, grid.origin[r]);
        }
        return matrix;
    }

    /// One pass of (1 2 1) / 4 along each axis: shading by gradients turns CT noise into grain. It reaches one voxel
    /// far, as far as hide_voxels() hides beyond the mask.
    Volume without_noise(const Volume& image)
    {
        Volume smooth = image;
        const std::array<std::size_t, 3> size { static_cast<std::size_t>(image.grid.size[0]),
            static_cast<std::size_t>(image.grid.size[1]), static_cast<std::size_t>(image.grid.size[2]) };
        std::size_t stride = 1;
        for (const std::size_t count : size) {
            const std::size_t block = stride * count;
            for (std::size_t first = 0; first < smooth.voxels.size(); first += block)
                for (std::size_t column = first; column < first + stride; ++column) {
                    int before = smooth.voxels[column];
                    for (std::size_t n = 0; n < count; ++n) {
                        const std::size_t at = column + n * stride;
                        const int here = smooth.voxels[at];
                        const int after = n + 1 < count ? smooth.voxels[at + stride] : here;
                        smooth.voxels[at] = static_cast<std::int16_t>((before + 2 * here + after) / 4);
                        before = here;
                    }
                }
            stride = block;
        }
        return smooth;
    }

    vtkSmartPointer<vtkImageData> image_of(
        const Volume& image, const VoxelMask* mask, bool reversed_k, std::size_t& bytes)
    {
        const ImageGrid& grid = image.grid;
        auto scalars = vtkSmartPointer<vtkShortArray>::New();
        const Volume smooth = without_noise(image);
        const std::vector<std::int16_t> shown = mask != nullptr ? hide_voxels(smooth, *mask) : smooth.voxels;
        scalars->SetNumberOfValues(static_cast<vtkIdType>(shown.size()));
        const std::size_t layer = static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
        const auto layers = static_cast<std::size_t>(grid.size[2]);
        for (std::size_t k = 0; k < layers; ++k)
            std::copy_n(shown.data() + (reversed_k ? layers - 1 - k : k) * layer, layer,
                scalars->GetPointer(static_cast<vtkIdType>(k * layer)));
        bytes = shown.size() * sizeof(std::int16_t);
        auto data = vtkSmartPointer<vtkImageData>::New();
        data->SetDimensions(grid.size.data());
        data->SetSpacing(grid.spacing.data());
        data->GetPointData()->SetScalars(scalars);
        return data;
    }

    void crop(vtkVolumeMapper& mapper, const Box& box)
    {
        auto planes = vtkSmartPointer<vtkPlaneCollection>::New();
        for (int axis = 0; axis < 3; ++axis)
            for (const bool low : { true, false }) {
                auto plane = vtkSmartPointer<vtkPlane>::New();
                const Vec3 normal = Vec3::Unit(axis) * (low ? 1.0 : -1.0);
                plane->SetOrigin((low ? box.low : box.high).data());
                plane->SetNormal(normal.data());
                planes->AddItem(plane);
            }
        mapper.SetClippingPlanes(planes);
    }

} // namespace

std::vector<std::int16_t> hide_voxels(const Volume& image, const VoxelMask& mask)
{
    const ImageGrid& grid = image.grid;
    const auto [nx, ny, nz] = grid.size;
    std::vector<std::uint8_t> hidden(grid.voxel_count(), 0);
    // Index of the mask is affine in the index of the image: one step per axis instead of a transform per voxel.
    const Vec3 start = mask.grid.index(grid.world(Vec3::Zero()));
    const Mat3 step = (mask.grid.direction.transpose() * grid.direction * grid.spacing.asDiagonal()).array().colwise()
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
    std::vector<std::int16_t> shown = image.voxels;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                if (hidden[grid.offset(i, j, k)] == 0)
                    continue;
                for (int c = std::max(k - 1, 0); c <= std::min(k + 1, nz - 1); ++c)
                    for (int b = std::max(j - 1, 0); b <= std::min(j + 1, ny - 1); ++b)
                        for (int a = std::max(i - 1, 0); a <= std::min(i + 1, nx - 1); ++a)
                            shown[grid.offset(a, b, c)] = kAir;
            }
    return shown;
}

struct VolumeCache::State {
    struct Entry {
        VolumeItem item; // keeps image and mask alive, so that their addresses stay theirs
        vtkSmartPointer<vtkVolume> volume;
        double sample_mm = 1.0;
        bool used = true;
    };
    Job job;
    std::vector<Entry> entries;
    bool interactive = false;

    static bool same(const VolumeItem& a, const VolumeItem& b)
    {
        const auto same_box = [](const Box& p, const Box& q) { return p.low == q.low && p.high == q.high; };
        return a.image == b.image && a.mask == b.mask && a.preset == b.preset && a.opacity == b.opacity
            && a.crop.has_value() == b.crop.has_value() && (!a.crop || same_box(*a.crop, *b.crop));
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
VolumeCache::VolumeCache(VolumeCache&&) noexcept = default;
VolumeCache& VolumeCache::operator=(VolumeCache&&) noexcept = default;

vtkSmartPointer<vtkVolume> VolumeCache::volume(const VolumeItem& item)
{
    for (State::Entry& entry : state_->entries)
        if (State::same(entry.item, item)) {
            entry.used = true;
            return entry.volume;
        }
    const Stopwatch watch;
    const Placed placed = right_handed(item.image->grid);
    std::size_t bytes = 0;
    const auto data = image_of(*item.image, item.mask.get(), placed.reversed_k, bytes);
    auto mapper = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
    mapper->SetInputData(data);
    mapper->SetAutoAdjustSampleDistances(0);
    mapper->SetLockSampleDistanceToInputSpacing(0);
    mapper->SetUseJittering(1); // breaks up the rings of equal depth
    if (item.crop)
        crop(*mapper, *item.crop);
    auto volume = vtkSmartPointer<vtkVolume>::New();
    volume->SetMapper(mapper);
    volume->SetProperty(property_of(item.preset, item.opacity));
    volume->SetUserMatrix(pose_of(placed.grid));
    state_->entries.push_back({ item, volume, item.image->grid.spacing.minCoeff() / kSamplesPerVoxel, true });
    state_->set_quality(state_->entries.back());
    // Once here and once as a texture.
    record_part(state_->job, "volume rendering", watch, 2 * bytes);
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

} // namespace retractor
