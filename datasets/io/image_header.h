#pragma once
// The content of an image file's header: the place of the voxels in the world, and their place in the files. The reader
// of each format makes a header; image_reader.h uses the header to read voxels. Memory for voxels is allocated only
// after the sizes of header and files have been compared.

#include "mesh/image/volume.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::datasets {

enum class VoxelType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };
enum class Encoding { raw, deflate, bzip2, text, hex }; ///< deflate: gzip or zlib

/// Bytes of one number of this type.
std::size_t voxel_bytes(VoxelType type);

/// Marks a length that reaches to the end of the file.
constexpr std::uint64_t kWholeFile = ~std::uint64_t {};

/// The place and encoding of the voxels. All `files` have the same layout and hold equal shares of the voxels, in
/// order.
struct VoxelStore {
    std::vector<std::filesystem::path> files;
    std::uint64_t start = 0; ///< bytes before the data
    std::uint64_t skip_lines = 0; ///< lines to skip after `start`, before decoding
    std::uint64_t skip_bytes = 0; ///< bytes to skip after these lines, after decoding
    bool at_end = false; ///< the voxels are the last decoded bytes of the file, and all bytes before are skipped
    Encoding encoding = Encoding::raw;
    std::uint64_t length = kWholeFile; ///< encoded bytes after the skipped lines
    bool base64 = false; ///< base64 text around the encoding
    std::uint64_t streams = 0; ///< see EncodedBytes
    VoxelType type = VoxelType::int16;
    bool big_endian = false;
    /// The start of the voxels is certain, because the header is in the same file. Surplus bytes then give a note.
    /// Without this certainty surplus bytes are refused, since a header that forgot to skip bytes looks the same.
    bool anchored = false;
};

/// The header of an image, in the terms of this project.
struct ImageHeader {
    std::string where; ///< the requested file, for messages
    mesh::ImageGrid grid; ///< patient LPS, mm
    int components = 1; ///< numbers per voxel, fastest in memory
    VoxelStore store;
    double slope = 1.0; ///< value = slope * stored + intercept
    double intercept = 0.0;
    std::map<std::string, std::string> keys; ///< key/value pairs of an NRRD header
    std::vector<std::string> notes; ///< decisions of the reader, one line each
};

/// Converts three sizes to integers.
/// @throws InputError unless the sizes are whole numbers of at least 1 with a product of at most 2^36 voxels.
std::array<int, 3> checked_sizes(const std::vector<double>& sizes, const std::string& where);

/// Sets spacing and direction of a grid. Column a of `steps` is the vector (mm) from a voxel to the next along index a.
/// @throws InputError for numbers that are not finite, a step of length zero, and axes that are not perpendicular.
void set_steps(mesh::ImageGrid& grid, const Mat3& steps, const std::string& where);

} // namespace retractor::datasets
