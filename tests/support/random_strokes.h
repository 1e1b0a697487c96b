#pragma once
// Random strokes into a box, for the tests of followers of a CutSession.

#include "mesh/cutting/cut_session.h"

#include <cmath>
#include <functional>
#include <random>

namespace retractor::test_support {

/// A straight blade through the top of a box with one corner at the origin.
inline mesh::Blade random_blade(std::mt19937& random, const Vec3& box)
{
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
    const double heading = between(0.0, 6.28);
    const Vec3 along(std::cos(heading), std::sin(heading), 0.0);
    const Vec3 middle(between(0.25, 0.75) * box.x(), between(0.25, 0.75) * box.y(), box.z());
    const double length = between(0.3, 0.9) * box.x();
    return { .line = { middle - 0.5 * length * along, middle + 0.5 * length * along },
        .directions = { Vec3(between(-0.2, 0.2), between(-0.2, 0.2), -1.0) },
        .depth_mm = between(0.3, 0.7) * box.z() };
}

/// Makes a random change of the session: a cut, a freehand stroke in steps, an undo or a redo. Each delta goes to
/// `follow`.
inline void random_change(mesh::CutSession& session, std::mt19937& random, const Vec3& box,
    const std::function<void(const mesh::MeshDelta&)>& follow)
{
    const unsigned choice = random() % 8;
    if (choice < 2 && session.can_undo())
        return follow(session.undo());
    if (choice == 2 && session.can_redo())
        return follow(session.redo());
    const mesh::Blade blade = random_blade(random, box);
    if (choice < 6) {
        const mesh::CutResult result = session.cut(blade);
        if (result.status == mesh::CutStatus::done)
            follow(result.delta);
        return;
    }
    mesh::Blade drawn = blade;
    drawn.line = { blade.line[0] };
    constexpr int kSteps = 3;
    for (int i = 1; i <= kSteps; ++i) {
        drawn.line.push_back(blade.line[0] + (blade.line[1] - blade.line[0]) * (i / static_cast<double>(kSteps)));
        const mesh::CutResult result = session.extend_stroke(drawn);
        if (result.status == mesh::CutStatus::done)
            follow(result.delta);
    }
    const mesh::CutResult result = session.finish_stroke();
    if (result.status == mesh::CutStatus::done)
        follow(result.delta);
}

} // namespace retractor::test_support
