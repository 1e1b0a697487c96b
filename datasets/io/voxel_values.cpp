#include "datasets/io/voxel_values.h"

#include "mesh/base/error.h"

#include <cmath>
#include <limits>

namespace retractor::datasets {

std::int16_t to_hounsfield(double value, const std::string& where)
{
    const double rounded = std::round(value);
    // The negated condition also refuses NaN.
    if (!(rounded >= std::numeric_limits<std::int16_t>::min() && rounded <= std::numeric_limits<std::int16_t>::max()))
        throw InputError("voxel value " + std::to_string(value) + " is not a Hounsfield number (16 bits)", where);
    return static_cast<std::int16_t>(rounded);
}

Label to_label(double value, const std::string& where)
{
    // The negated condition also refuses NaN. The range is compared first, since converting a number out of range is
    // undefined.
    if (!(value >= 0.0 && value <= std::numeric_limits<Label>::max())
        || value != static_cast<double>(static_cast<Label>(value)))
        throw InputError(
            "voxel value " + std::to_string(value) + " is not a label (a whole number from 0 to 65535)", where);
    return static_cast<Label>(value);
}

} // namespace retractor::datasets
