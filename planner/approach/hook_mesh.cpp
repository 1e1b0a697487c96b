#include "planner/approach/hook_mesh.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kBendRadius = 6.0; ///< mm
    constexpr int kBendSteps = 12;

    /// A cross-section of the ribbon: centre of its outer face, in mm along pull (p) and outward (o).
    struct CrossSection {
        double p = 0.0, o = 0.0;
        double half_width = 0.0;
    };

    void check(const HookShape& hook)
    {
        const std::string where = "hook " + hook.name;
        if (!hook.position.allFinite() || !hook.pull.allFinite() || !hook.outward.allFinite())
            throw InputError("a hook is not finite", where);
        if (!(hook.width_mm > 0.0 && hook.depth_mm > 0.0 && hook.shaft_mm > 0.0 && hook.height_mm >= 0.0))
            throw InputError("a hook's sizes must be positive", where);
        const double cross = hook.pull.cross(hook.outward).norm();
        if (!(cross > 1e-6 * hook.pull.norm() * hook.outward.norm() && cross > 0.0))
            throw InputError("a hook's pull must be a direction and not lie along its outward direction", where);
    }

    double height_of(const HookShape& hook) { return hook.height_mm > 0.0 ? hook.height_mm : 0.5 * hook.depth_mm; }

    std::vector<CrossSection> profile(const HookShape& hook)
    {
        const double half = 0.5 * hook.width_mm;
        const double narrow = std::max(0.35 * half, 2.0);
        const double height = height_of(hook);
        std::vector<CrossSection> line;
        // A rounded toe, so that the blade does not end in a square.
        const double toe = std::min(0.4 * half, 0.3 * hook.depth_mm);
        for (int i = 0; i < 5; ++i) {
            const double angle = 0.5 * std::numbers::pi * i / 4.0;
            line.push_back(
                { 0.0, -0.5 * hook.depth_mm + toe * (1.0 - std::cos(angle)), half - toe * (1.0 - std::sin(angle)) });
        }
        line.push_back({ 0.0, std::max(height, 0.1 * hook.depth_mm), half });
        // The bend turns by 75 degrees, from outward to slightly above the skin.
        const double turn = 75.0 * std::numbers::pi / 180.0;
        const double base = line.back().o;
        for (int i = 1; i <= kBendSteps; ++i) {
            const double share = static_cast<double>(i) / kBendSteps;
            const double angle = turn * share;
            line.push_back({ kBendRadius * (1.0 - std::cos(angle)), base + kBendRadius * std::sin(angle),
                half + (narrow - half) * share * share });
        }
        const CrossSection end = line.back();
        for (int i = 1; i <= 8; ++i) {
            const double step = hook.shaft_mm * i / 8.0;
            line.push_back({ end.p + step * std::sin(turn), end.o + step * std::cos(turn), narrow });
        }
        return line;
    }

    /// A bar of square cross-section. @param up not along the bar
    void add_bar(TriMesh& mesh, const Vec3& from, const Vec3& to, const Vec3& up)
    {
        constexpr double kHalf = 4.0; // mm
        const Vec3 along = (to - from).normalized();
        const Vec3 side = kHalf * along.cross(up).normalized(), high = kHalf * side.cross(along).normalized();
        const auto first = static_cast<VertexId>(mesh.vertices.rows());
        mesh.vertices.conservativeResize(first + 8, 3);
        Eigen::Index row = first;
        for (const Vec3& end : { from, to })
            for (const Vec3& corner : { Vec3(-side - high), Vec3(side - high), Vec3(side + high), Vec3(-side + high) })
                mesh.vertices.row(row++) = (end + corner).transpose();
        const auto quad = [&](VertexId a, VertexId b, VertexId c, VertexId d) {
            mesh.triangles.push_back({ first + a, first + b, first + c });
            mesh.triangles.push_back({ first + a, first + c, first + d });
        };
        for (VertexId e = 0; e < 4; ++e) {
            const VertexId f = (e + 1) % 4;
            quad(4 + e, 4 + f, f, e);
        }
        quad(0, 1, 2, 3);
        quad(7, 6, 5, 4);
    }

} // namespace

TriMesh hook_mesh(const HookShape& hook)
{
    check(hook);
    const Vec3 outward = hook.outward.normalized();
    const Vec3 pull = (hook.pull - outward * outward.dot(hook.pull)).normalized();
    const Vec3 across = outward.cross(pull);
    const std::vector<CrossSection> line = profile(hook);
    RETRACTOR_ASSERT(line.size() >= 2);
    const auto count = static_cast<VertexId>(line.size());

    TriMesh mesh;
    mesh.vertices.resize(4 * count, 3);
    for (VertexId s = 0; s < count; ++s) {
        const auto at = [&](VertexId i) { return line[static_cast<std::size_t>(std::clamp(i, 0, count - 1))]; };
        const CrossSection before = at(s - 1), here = at(s), after = at(s + 1);
        Eigen::Vector2d along(after.p - before.p, after.o - before.o);
        along.normalize();
        // The steel lies on the wound's side of the lip: the lip is at p > 0.
        const Vec3 inner = -kBladeThicknessMm * (along.y() * pull - along.x() * outward);
        const Vec3 centre = hook.position + here.p * pull + here.o * outward;
        const Vec3 side = here.half_width * across;
        mesh.vertices.row(4 * s + 0) = (centre - side).transpose();
        mesh.vertices.row(4 * s + 1) = (centre + side).transpose();
        mesh.vertices.row(4 * s + 2) = (centre + side + inner).transpose();
        mesh.vertices.row(4 * s + 3) = (centre - side + inner).transpose();
    }
    const auto quad = [&](VertexId a, VertexId b, VertexId c, VertexId d) {
        mesh.triangles.push_back({ a, b, c });
        mesh.triangles.push_back({ a, c, d });
    };
    for (VertexId s = 0; s + 1 < count; ++s)
        for (VertexId e = 0; e < 4; ++e) {
            const VertexId f = (e + 1) % 4;
            quad(4 * s + e, 4 * s + f, 4 * (s + 1) + f, 4 * (s + 1) + e);
        }
    quad(3, 2, 1, 0);
    const VertexId last = 4 * (count - 1);
    quad(last, last + 1, last + 2, last + 3);
    RETRACTOR_ASSERT(mesh.triangles.size() == 8 * line.size() - 4);
    return mesh;
}

TriMesh rack_mesh(const HookShape& blade, const HookShape& opposite)
{
    check(blade);
    check(opposite);
    constexpr double kAbove = kBendRadius + 4.0; ///< of the arms over the blades' bend
    constexpr double kBeside = kBendRadius + 4.0; ///< of the arms beside the lips, so that they hide no wound
    constexpr double kBeyond = 35.0; ///< of the rack beyond the blades' ends
    constexpr double kOver = 12.0; ///< of the rack over the arms, outwards
    const Vec3 outward = (blade.outward.normalized() + opposite.outward.normalized()).normalized();
    const Vec3 rack = blade.pull.normalized();
    const Vec3 along = outward.cross(rack).normalized();
    const double reach = 0.5 * std::max(blade.width_mm, opposite.width_mm) + kBeyond;
    TriMesh mesh;
    std::vector<Vec3> ends;
    for (const HookShape* one : { &blade, &opposite }) {
        const Vec3 arm = one->position + (height_of(*one) + kAbove) * outward + kBeside * one->pull.normalized();
        add_bar(mesh, arm - 0.5 * one->width_mm * along, arm + reach * along, outward);
        ends.push_back(arm + reach * along);
    }
    const Vec3 line = (ends[0] - ends[1]).norm() > 1.0 ? Vec3((ends[0] - ends[1]).normalized()) : rack;
    add_bar(mesh, ends[1] - kOver * line, ends[0] + kOver * line, outward);
    return mesh;
}

} // namespace retractor::planner
