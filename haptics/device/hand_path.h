#pragma once
// Where a simulated hand means to be: key points in time, joined by minimum-jerk motion [Flash, Hogan 1985, eq. 3], the
// way hands move from rest to rest.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <vector>

namespace retractor::haptics {

struct HandKey {
    double time_s = 0.0;
    Vec3 position = Vec3::Zero(); ///< device frame, mm
    std::uint32_t buttons = 0; ///< from this time on
};

/// Before the first key the hand rests there, after the last one too.
class HandPath {
public:
    /// @throws InputError when there is no key, a number is not finite, or times do not increase
    explicit HandPath(std::vector<HandKey> keys);

    [[nodiscard]] Vec3 position(double time_s) const noexcept;
    [[nodiscard]] std::uint32_t buttons(double time_s) const noexcept;
    [[nodiscard]] double end_s() const noexcept { return keys_.back().time_s; }

private:
    [[nodiscard]] std::size_t key_after(double time_s) const noexcept;
    std::vector<HandKey> keys_;
};

} // namespace retractor::haptics
