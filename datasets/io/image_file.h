#pragma once
// Writes image files with ITK. ITK is confined to one source file without Eigen, because ITK brings an older Eigen. The
// geometry is patient LPS in mm, as ITK takes the geometry for every format.

#include <array>
#include <filesystem>

namespace retractor::datasets {

enum class ImageFormat { nifti, nrrd, metaimage };

/// The grid and the voxel type of a file.
struct ImageFile {
    std::array<int, 3> size { 0, 0, 0 }; ///< voxels along i, j, k
    std::array<double, 3> spacing { 1.0, 1.0, 1.0 }; ///< mm
    std::array<double, 3> origin { 0.0, 0.0, 0.0 }; ///< centre of the first voxel, mm
    std::array<std::array<double, 3>, 3> axes {}; ///< axes[a] is the world direction of index a
    bool is_signed = true; ///< true: int16; false: uint16
};

/// Writes one image. A NIfTI file is compressed when its name ends with .gz; the other formats are always compressed.
/// @param bytes the voxels, 16 bits each, x fastest
/// @throws IoError when the file cannot be written.
void write_image_file(const std::filesystem::path& path, ImageFormat format, const ImageFile& image, const void* bytes);

} // namespace retractor::datasets
