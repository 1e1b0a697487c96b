#pragma once
// The border to the image library (ITK), which writes files. It keeps ITK in one source file, which must not see
// Eigen (ITK brings an older one of its own). Geometry is patient LPS mm, as the library takes it for every format.

#include <array>
#include <filesystem>

namespace retractor::datasets {

enum class ImageFormat { nifti, nrrd, metaimage };

struct ImageFile {
    std::array<int, 3> size { 0, 0, 0 };
    std::array<double, 3> spacing { 1.0, 1.0, 1.0 };
    std::array<double, 3> origin { 0.0, 0.0, 0.0 };
    std::array<std::array<double, 3>, 3> axes {}; ///< axes[a] is the world direction of index a
    bool is_signed = true; ///< int16, else uint16
};

/// `bytes`: the voxels, x fastest. NIfTI is compressed when the name ends with .gz, the others always.
/// @throws IoError.
void write_image_file(const std::filesystem::path& path, ImageFormat format, const ImageFile& image, const void* bytes);

} // namespace retractor::datasets
