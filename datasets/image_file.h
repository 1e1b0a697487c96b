#pragma once
// The border to the image library (ITK): files as plain arrays. It keeps ITK in one source file, which must not see
// Eigen (ITK brings an older one of its own). Geometry is patient LPS mm, as the library gives it for every format.

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace retractor {

enum class ImageFormat { nifti, nrrd, metaimage };
enum class VoxelType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };

struct ImageFile {
    std::array<int, 3> size { 0, 0, 0 };
    std::array<double, 3> spacing { 1.0, 1.0, 1.0 };
    std::array<double, 3> origin { 0.0, 0.0, 0.0 };
    std::array<std::array<double, 3>, 3> axes {}; ///< axes[a] is the world direction of index a
    VoxelType type = VoxelType::int16;
    std::vector<char> bytes; ///< x fastest
};

/// @throws InputError unless the file is a three-dimensional image with one number per voxel.
ImageFile read_image_file(const std::filesystem::path& path, ImageFormat format);

/// `bytes` as above, int16 or uint16. NIfTI is compressed when the name ends with .gz, the others always.
/// @throws IoError.
void write_image_file(const std::filesystem::path& path, ImageFormat format, const ImageFile& image, const void* bytes);

} // namespace retractor
