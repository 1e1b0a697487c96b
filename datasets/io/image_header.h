#pragma once
// What the header of an image file says: where its voxels lie in the world, and where they are stored. Made by the
// reader of each format, used by image_reader.h. Nothing is allocated for voxels before the sizes of header and file
// have been compared.

#include "mesh/image/volume.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::datasets {

enum class VoxelType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };
enum class Encoding { raw, deflate, bzip2, text, hex }; ///< deflate: gzip or zlib

std::size_t voxel_bytes(VoxelType type);

constexpr std::uint64_t kWholeFile = ~std::uint64_t {};

/// Where the voxels are. Each of `files` holds an equal share of them, in order, laid out alike.
struct VoxelStore {
    std::vector<std::filesystem::path> files;
    std::uint64_t start = 0; ///< bytes of the file before the data
    std::uint64_t skip_lines = 0; ///< then lines, still encoded
    std::uint64_t skip_bytes = 0; ///< then bytes, decoded
    bool at_end = false; ///< the voxels are the last bytes, decoded, whatever comes before
    Encoding encoding = Encoding::raw;
    std::uint64_t length = kWholeFile; ///< encoded bytes after the lines
    bool base64 = false; ///< around the encoding
    std::uint64_t streams = 0; ///< see EncodedBytes
    VoxelType type = VoxelType::int16;
    bool big_endian = false;
    /// The start is certain (a header in the same file): surplus bytes are told. Otherwise they are refused, since a
    /// forgotten skip looks just so.
    bool anchored = false;
};

struct ImageHeader {
    std::string where; ///< the file that was asked for
    mesh::ImageGrid grid;
    int components = 1; ///< numbers per voxel, fastest
    VoxelStore store;
    double slope = 1.0; ///< value = slope * stored + intercept
    double intercept = 0.0;
    std::map<std::string, std::string> keys; ///< key/value pairs of NRRD
    std::vector<std::string> notes; ///< what was decided, one line each
};

/// Sizes, with the product that memory could hold. @throws InputError.
std::array<int, 3> checked_sizes(const std::vector<double>& sizes, const std::string& where);

/// Spacing and direction from steps: column a is the way (mm) from a voxel to the next along index a.
/// @throws InputError for numbers that are not finite, a step of length zero, axes that are not square to each other.
void set_steps(mesh::ImageGrid& grid, const Mat3& steps, const std::string& where);

} // namespace retractor::datasets
