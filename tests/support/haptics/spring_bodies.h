#pragma once
// Bodies of springs for tests.

#include "haptics/springs/spring_body.h"

#include <algorithm>

namespace retractor::test_support {

/// One spring along x between two particles, a model of a rheometer's sample. The first particle is held, the second
/// when it is `clamped`.
inline haptics::SpringBody spring_element(
    double length_mm, double stiffness_N_per_mm, double particle_mass_tonne, bool clamped = false)
{
    haptics::SpringBody body;
    body.surface.vertices = Points::Zero(2, 3);
    body.surface.vertices(1, 0) = length_mm;
    body.springs = { { 0, 1, length_mm, stiffness_N_per_mm } };
    body.mass = { particle_mass_tonne, particle_mass_tonne };
    body.held = { 1, static_cast<std::uint8_t>(clamped ? 1 : 0) };
    body.touchable = { 0, 1 };
    return body;
}

/// The usual sheet with no edge held: it falls under gravity.
inline haptics::SpringBody free_sheet()
{
    haptics::SpringBody body = haptics::make_spring_sheet();
    std::fill(body.held.begin(), body.held.end(), std::uint8_t { 0 });
    return body;
}

/// The usual sheet held at its side of largest y: it hangs like a curtain.
inline haptics::SpringBody hanging_sheet()
{
    haptics::SpringBody body = free_sheet();
    std::fill(body.held.end() - haptics::SheetOptions {}.columns, body.held.end(), std::uint8_t { 1 });
    return body;
}

} // namespace retractor::test_support
