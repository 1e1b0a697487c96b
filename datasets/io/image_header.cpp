#include "datasets/io/image_header.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::datasets {

std::size_t voxel_bytes(VoxelType type)
{
    switch (type) {
    case VoxelType::uint8:
    case VoxelType::int8:
        return 1;
    case VoxelType::uint16:
    case VoxelType::int16:
        return 2;
    case VoxelType::uint32:
    case VoxelType::int32:
    case VoxelType::float32:
        return 4;
    default:
        return 8;
    }
}

std::array<int, 3> checked_sizes(const std::vector<double>& sizes, const std::string& where)
{
    constexpr double kMostVoxels = 1LL << 36; // 128 GiB of 16-bit voxels
    std::array<int, 3> checked { 1, 1, 1 };
    double voxels = 1.0;
    for (std::size_t a = 0; a < 3; ++a) {
        const double n = sizes.at(a);
        if (!(n >= 1.0) || n != std::floor(n))
            throw InputError(
                "the size along axis " + std::to_string(a + 1) + " must be a whole number of at least 1", where);
        voxels *= n;
        if (n > std::numeric_limits<int>::max() || voxels > kMostVoxels)
            throw InputError("the header promises more voxels than an image can have", where);
        checked[a] = static_cast<int>(n);
    }
    return checked;
}

void set_steps(mesh::ImageGrid& grid, const Mat3& steps, const std::string& where)
{
    constexpr double kSquare = 1e-4; // cosine between axes, as in check_grid()
    if (!steps.allFinite())
        throw InputError("the axes have numbers that are not finite", where);
    for (int a = 0; a < 3; ++a) {
        grid.spacing[a] = steps.col(a).norm();
        if (!(grid.spacing[a] > 0.0))
            throw InputError("the spacing along axis " + std::to_string(a + 1) + " must be positive, it is 0", where);
        grid.direction.col(a) = steps.col(a) / grid.spacing[a];
    }
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < a; ++b) {
            const double cosine = grid.direction.col(a).dot(grid.direction.col(b));
            if (std::abs(cosine) <= kSquare)
                continue;
            throw InputError(formatted("axes %d and %d meet at %.3f degrees: a sheared image is not read", b + 1, a + 1,
                                 std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi),
                where);
        }
    try {
        mesh::check_grid(grid);
    } catch (const InputError& error) {
        throw InputError(error.what(), where);
    }
}

} // namespace retractor::datasets
