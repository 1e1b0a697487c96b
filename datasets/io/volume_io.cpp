#include "datasets/io/volume_io.h"

#include "datasets/dicom/dicom.h"
#include "datasets/io/image_file.h"
#include "datasets/io/image_reader.h"
#include "datasets/io/label_table.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <string_view>
#include <type_traits>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    ImageFormat format_of(const fs::path& path)
    {
        const std::string name = path.filename().string();
        if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
            return ImageFormat::nifti;
        if (name.ends_with(".nrrd"))
            return ImageFormat::nrrd;
        if (name.ends_with(".mha"))
            return ImageFormat::metaimage;
        throw InputError("an image is written into one file: use .nrrd, .nii, .nii.gz or .mha", path.string());
    }

    template <typename T>
    void write_image(const fs::path& path, const mesh::ImageGrid& grid, const std::vector<T>& voxels)
    {
        mesh::check_grid(grid);
        if (voxels.size() != grid.voxel_count())
            throw InputError("the image has " + std::to_string(voxels.size()) + " voxels, its grid "
                + std::to_string(grid.voxel_count()));
        const ImageFormat format = format_of(path);
        ImageFile image;
        image.size = grid.size;
        image.is_signed = std::is_signed_v<T>;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            image.spacing[a] = grid.spacing[axis];
            image.origin[a] = grid.origin[axis];
            image.axes[a] = { grid.direction(0, axis), grid.direction(1, axis), grid.direction(2, axis) };
        }
        write_file_atomically(path, std::function([&](const fs::path& temporary) {
            write_image_file(temporary, format, image, voxels.data());
        }));
    }

    /// True for a DICOM file, recognised by its mark, since hospitals omit suffixes. Older files have no mark, but the
    /// suffix .dcm.
    bool is_dicom_file(const fs::path& path)
    {
        constexpr std::streamoff kPreamble = 128;
        std::ifstream file(path, std::ios::binary);
        std::array<char, 4> mark {};
        file.seekg(kPreamble);
        file.read(mark.data(), mark.size());
        return (file && std::string_view(mark.data(), mark.size()) == "DICM") || path.extension() == ".dcm";
    }

    ImportedVolume read_file(const fs::path& path, const Job& job)
    {
        const Stopwatch watch;
        ImportedVolume imported;
        ImageHeader header = read_hounsfield_image(path, imported.volume.voxels, job);
        if (job.cancelled())
            return {};
        imported.volume.grid = header.grid;
        imported.notes = std::move(header.notes);
        record_part(job, "voxels", watch, imported.volume.voxels.size() * sizeof(std::int16_t));
        return imported;
    }

    /// Replaces values below air, with which scanners and other tools mark places without a measurement.
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

    /// Replaces padding by air, and adds a note for every property that a chest CT in Hounsfield units and mm does not
    /// have.
    void tell_values(ImportedVolume& imported, const std::string& where)
    {
        constexpr std::int16_t kLung = -200; // HU; every CT of a body has lower values, in lung or in the air outside
        constexpr std::int16_t kMetal = 4000; // HU; above the usual 12-bit range
        constexpr double kFinest_mm = 0.05;
        constexpr double kCoarsest_mm = 20.0;
        replace_padding(imported);
        const mesh::Volume& volume = imported.volume;
        if (volume.voxels.empty())
            throw InputError("the image has no voxels", where);
        const auto [least, most] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
        const std::string range = "values from " + std::to_string(*least) + " to " + std::to_string(*most);
        if (*least == *most)
            imported.notes.push_back("all voxels are " + std::to_string(*least));
        else if (*least >= 0 && *most <= 255)
            imported.notes.push_back(range + ": probably not Hounsfield units (a label map, or a picture?)");
        else if (*least > kLung)
            imported.notes.push_back(
                range + ": no air or lung, so perhaps not Hounsfield units (raw scanner values are 1024 higher)");
        if (*most > kMetal)
            imported.notes.push_back(range + ": metal, or not Hounsfield units");
        const Vec3& spacing = volume.grid.spacing;
        if (spacing.minCoeff() < kFinest_mm || spacing.maxCoeff() > kCoarsest_mm)
            imported.notes.emplace_back("the spacing is unlike a CT's: is its unit mm?");
    }

} // namespace

fs::path label_table_path(const fs::path& image) { return image.parent_path() / (image_stem(image) + ".labels.json"); }

mesh::Volume read_volume(const fs::path& path, const Job& job)
{
    if (fs::is_directory(path))
        return read_dicom_series(path, job);
    return read_file(path, job).volume;
}

ImportedVolume import_volume(const fs::path& path, const ImportOptions& options, const Job& job)
{
    ImportedVolume imported;
    if (fs::is_directory(path) || is_dicom_file(path)) {
        DicomVolume dicom = read_dicom(path, { options.series, options.rectify_tilt }, job);
        imported = { std::move(dicom.volume), std::move(dicom.notes) };
    } else {
        if (!options.series.empty())
            throw InputError("a series can be chosen in DICOM only", path.string());
        imported = read_file(path, job);
    }
    if (!job.cancelled())
        tell_values(imported, path.string());
    return imported;
}

mesh::LabelVolume read_label_voxels(const fs::path& path, std::vector<std::string>* notes, const Job& job)
{
    const Stopwatch watch;
    mesh::LabelVolume labels;
    ImageHeader header = read_label_image(path, labels.voxels, false, job);
    if (job.cancelled())
        return {};
    labels.grid = header.grid;
    if (notes != nullptr)
        notes->insert(notes->end(), header.notes.begin(), header.notes.end());
    record_part(job, "labels", watch, labels.voxels.size() * sizeof(Label));
    return labels;
}

mesh::LabelVolume read_label_volume(const fs::path& path, const Job& job)
{
    mesh::LabelVolume labels = read_label_voxels(path, nullptr, job);
    if (job.cancelled())
        return {};
    labels.table = read_label_table(label_table_path(path));
    check_labels_named(labels, path.string());
    return labels;
}

void write_volume(const fs::path& path, const mesh::Volume& volume) { write_image(path, volume.grid, volume.voxels); }

void write_label_volume(const fs::path& path, const mesh::LabelVolume& labels)
{
    check_labels_named(labels, path.string());
    write_image(path, labels.grid, labels.voxels);
    write_label_table(label_table_path(path), labels.table);
}

mesh::LabelVolume resample_labels_to(const mesh::LabelVolume& labels, const mesh::ImageGrid& grid)
{
    mesh::check_grid(grid);
    mesh::LabelVolume result { grid, std::vector<Label>(grid.voxel_count(), 0), labels.table };
    const mesh::ImageGrid& from = labels.grid;
    const Vec3 start = from.index(grid.origin);
    Mat3 step; // change of the source index per step of the target index
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

} // namespace retractor::datasets
