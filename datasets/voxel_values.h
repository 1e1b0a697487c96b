#pragma once
// One voxel's number made into what the project stores, or refused. Shared by the readers.

#include "mesh/geometry.h"

#include <cstdint>
#include <string>

namespace retractor {

/// Rounded to the nearest Hounsfield unit. @throws InputError for NaN and for what 16 bits cannot hold.
std::int16_t to_hounsfield(double value, const std::string& where);

/// @throws InputError unless the value is a whole number from 0 to 65535.
Label to_label(double value, const std::string& where);

} // namespace retractor
