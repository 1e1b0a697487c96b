#pragma once
// Checks the contact of condensed tissue against the whole body.

#include "haptics/condensed/condensed_tissue.h"

#include <algorithm>
#include <cmath>

namespace retractor::test_support {

/// Check of the contact: the whole body solved again under the forces of the last tick.
struct PressedCheck {
    Eigen::VectorXd displacement; ///< of every node, mm
    double off_mm = 0.0; ///< largest distance between a pressed contact node and the place where the tick held it
    double deepest_mm = 0.0; ///< largest displacement of a contact node beyond the pulse
};

/// Simulation thread.
inline PressedCheck check_pressed(haptics::CondensedTissue& tissue)
{
    const haptics::CondensedTissue::Pressed pressed = tissue.last_pressed();
    const haptics::ContactNodeCompliance& body = tissue.compliance();
    PressedCheck check { .displacement = body.solve(pressed.pressure, pressed.forces) };
    for (std::size_t i = 0; i < pressed.forces.size(); ++i) {
        const std::int32_t s = pressed.forces[i].contact_node;
        const Vec3 given_way = pressed.pressure * body.pulse_of_contact_node(s) - body.mean(check.displacement, s);
        check.off_mm = std::max(check.off_mm, std::abs(given_way.dot(pressed.normals[i]) - pressed.demands[i]));
        check.deepest_mm = std::max(check.deepest_mm, std::abs(pressed.demands[i]));
    }
    return check;
}

} // namespace retractor::test_support
