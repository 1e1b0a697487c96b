#pragma once
// The motion that a simulated hand intends: key points in time, joined by minimum-jerk motion from rest to rest (Flash,
// Hogan 1985, eq. 3). Units mm, s.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <vector>

namespace retractor::haptics {

struct HandKey {
    double time_s = 0.0;
    Vec3 position = Vec3::Zero(); ///< device frame, mm
    std::uint32_t buttons = 0; ///< pressed buttons from this time on
};

/// The hand rests at the first key before its time, and at the last key after its time.
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
