#pragma once
// Converts the number of one voxel to the type that the project stores, or refuses the number. All readers share these
// functions.

#include "datasets/io/image_header.h"
#include "mesh/base/geometry.h"

#include <cstdint>
#include <string>

namespace retractor::datasets {

/// Rounds to the nearest Hounsfield unit. @throws InputError for NaN and for numbers that do not fit 16 bits.
std::int16_t to_hounsfield(double value, const std::string& where);

/// Converts a number to a label. @throws InputError unless the number is whole and from 0 to 65535.
Label to_label(double value, const std::string& where);

/// Calls `visit(T {})` with T the type of the stored voxels.
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

} // namespace retractor::datasets
