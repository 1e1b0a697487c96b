#include "datasets/volume_io.h"

#include "datasets/dicom.h"
#include "datasets/file_checks.h"
#include "datasets/image_file.h"
#include "datasets/label_table.h"
#include "datasets/voxel_values.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <type_traits>

namespace retractor {

namespace {

    namespace fs = std::filesystem;

    ImageFormat format_of(const fs::path& path)
    {
        const std::string name = path.filename().string();
        if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
            return ImageFormat::nifti;
        if (name.ends_with(".nrrd") || name.ends_with(".nhdr"))
            return ImageFormat::nrrd;
        if (name.ends_with(".mha") || name.ends_with(".mhd"))
            return ImageFormat::metaimage;
        throw InputError(
            "unknown image format: use a DICOM folder, .nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd", path.string());
    }

    std::string stem_of(const fs::path& path)
    {
        const fs::path stem = path.filename().stem();
        return (path.extension() == ".gz" ? stem.stem() : stem).string();
    }

    ImageGrid grid_of(const ImageFile& file, const std::string& where)
    {
        ImageGrid grid;
        grid.size = file.size;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            grid.spacing[axis] = file.spacing[a];
            grid.origin[axis] = file.origin[a];
            grid.direction.col(axis) = Vec3(file.axes[a][0], file.axes[a][1], file.axes[a][2]);
        }
        try {
            check_grid(grid);
        } catch (const InputError& error) {
            throw InputError(error.what(), where);
        }
        return grid;
    }

    /// Calls `visit(T {})` with the type of the stored voxels.
    template <typename Visit> void with_voxel_type(VoxelType type, const Visit& visit)
    {
        switch (type) {
        case VoxelType::uint8:
            return visit(std::uint8_t {});
        case VoxelType::int8:
            return visit(std::int8_t {});
        case VoxelType::uint16:
            return visit(std::uint16_t {});
        case VoxelType::int16:
            return visit(std::int16_t {});
        case VoxelType::uint32:
            return visit(std::uint32_t {});
        case VoxelType::int32:
            return visit(std::int32_t {});
        case VoxelType::uint64:
            return visit(std::uint64_t {});
        case VoxelType::int64:
            return visit(std::int64_t {});
        case VoxelType::float32:
            return visit(float {});
        case VoxelType::float64:
            return visit(double {});
        }
    }

    /// Geometry and voxels of one file, each voxel made by `convert(double)`.
    template <typename Out, typename Convert>
    ImageGrid read_image(const fs::path& path, std::vector<Out>& voxels, const Convert& convert)
    {
        const ImageFormat format = format_of(path);
        if (!fs::is_regular_file(path))
            throw IoError("no such file", path.string());
        if (format == ImageFormat::nifti)
            check_nifti_file(path);
        if (format == ImageFormat::metaimage)
            check_metaimage_file(path);
        const ImageFile file = read_image_file(path, format);
        const ImageGrid grid = grid_of(file, path.string());
        voxels.resize(grid.voxel_count());
        with_voxel_type(file.type, [&](auto stored) {
            for (std::size_t v = 0; v < voxels.size(); ++v) {
                std::memcpy(&stored, file.bytes.data() + v * sizeof(stored), sizeof(stored));
                voxels[v] = convert(static_cast<double>(stored));
            }
        });
        return grid;
    }

    template <typename T> void write_image(const fs::path& path, const ImageGrid& grid, const std::vector<T>& voxels)
    {
        check_grid(grid);
        if (voxels.size() != grid.voxel_count())
            throw InputError("the image has " + std::to_string(voxels.size()) + " voxels, its grid "
                + std::to_string(grid.voxel_count()));
        const ImageFormat format = format_of(path);
        if (path.extension() == ".nhdr" || path.extension() == ".mhd")
            throw InputError("an image is written into one file: use .nrrd or .mha", path.string());
        ImageFile image;
        image.size = grid.size;
        image.type = std::is_signed_v<T> ? VoxelType::int16 : VoxelType::uint16;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            image.spacing[a] = grid.spacing[axis];
            image.origin[a] = grid.origin[axis];
            image.axes[a] = { grid.direction(0, axis), grid.direction(1, axis), grid.direction(2, axis) };
        }
        write_file_atomically(path, std::function([&](const fs::path& temporary) {
            if (path.extension() != ".gz")
                return write_image_file(temporary, format, image, voxels.data());
            // The library wants the whole suffix, of which the temporary name keeps the last part.
            const fs::path named = temporary.string() + ".nii.gz";
            write_image_file(named, format, image, voxels.data());
            fs::rename(named, temporary);
        }));
    }

    /// Scanners and other tools mark what they did not measure with values below air.
    void replace_padding(ImportedVolume& imported)
    {
        constexpr std::int16_t kAir = -1024;
        std::size_t padded = 0;
        std::int16_t least = kAir;
        for (std::int16_t& hu : imported.volume.voxels)
            if (hu < kAir) {
                least = std::min(least, hu);
                hu = kAir;
                ++padded;
            }
        if (padded > 0)
            imported.notes.push_back(std::to_string(padded) + " voxels below -1024 HU (down to " + std::to_string(least)
                + ") are padding: set to -1024");
    }

} // namespace

fs::path label_table_path(const fs::path& image) { return image.parent_path() / (stem_of(image) + ".labels.json"); }

Volume read_volume(const fs::path& path, const Job& job)
{
    if (fs::is_directory(path))
        return read_dicom_series(path, job);
    const Stopwatch watch;
    job.report("read CT", 0.0);
    Volume volume;
    const std::string where = path.string();
    volume.grid = read_image(path, volume.voxels, [&](double value) { return to_hounsfield(value, where); });
    record_part(job, "voxels", watch, volume.voxels.size() * sizeof(std::int16_t));
    job.report("read CT", 1.0);
    return volume;
}

ImportedVolume import_volume(const fs::path& path, const ImportOptions& options, const Job& job)
{
    if (!options.series.empty())
        throw InputError("series can be chosen in a DICOM folder only", path.string());
    ImportedVolume imported { read_volume(path, job), {} };
    replace_padding(imported);
    return imported;
}

LabelVolume read_label_voxels(const fs::path& path)
{
    LabelVolume labels;
    const std::string where = path.string();
    labels.grid = read_image(path, labels.voxels, [&](double value) { return to_label(value, where); });
    return labels;
}

LabelVolume read_label_volume(const fs::path& path, const Job& job)
{
    const Stopwatch watch;
    job.report("read labels", 0.0);
    LabelVolume labels = read_label_voxels(path);
    labels.table = read_label_table(label_table_path(path));
    check_labels_named(labels, path.string());
    record_part(job, "labels", watch, labels.voxels.size() * sizeof(Label));
    job.report("read labels", 1.0);
    return labels;
}

void write_volume(const fs::path& path, const Volume& volume) { write_image(path, volume.grid, volume.voxels); }

void write_label_volume(const fs::path& path, const LabelVolume& labels)
{
    check_labels_named(labels, path.string());
    write_image(path, labels.grid, labels.voxels);
    write_label_table(label_table_path(path), labels.table);
}

LabelVolume resample_labels_to(const LabelVolume& labels, const ImageGrid& grid)
{
    check_grid(grid);
    LabelVolume result { grid, std::vector<Label>(grid.voxel_count(), 0), labels.table };
    const ImageGrid& from = labels.grid;
    const Vec3 start = from.index(grid.origin);
    Mat3 step; // change of the source index per target index
    for (int axis = 0; axis < 3; ++axis)
        step.col(axis) = from.index(grid.world(Vec3::Unit(axis))) - start;
    bool overlap = false;
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i, ++v) {
                const Vec3 index = (start + step * Vec3(i, j, k)).array().round();
                if (index.minCoeff() < 0.0 || index.x() >= from.size[0] || index.y() >= from.size[1]
                    || index.z() >= from.size[2])
                    continue;
                overlap = true;
                result.voxels[v] = labels.voxels[from.offset(
                    static_cast<int>(index.x()), static_cast<int>(index.y()), static_cast<int>(index.z()))];
            }
    if (!overlap)
        throw InputError("CT and labels do not overlap in space: they are not of the same patient position or not in "
                         "the same frame");
    return result;
}

} // namespace retractor
