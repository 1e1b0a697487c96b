#include "fem/hooks_apart.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace retractor {

namespace {

    /// A hook's patch as a disc: middle, radius, outward unit normal of the surface it lies on (zero: on none).
    struct PatchPlane {
        Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();
        double radius = 0.0;
    };

    std::vector<PatchPlane> patch_planes(const TetMesh& mesh, std::span<const HookPatch> hooks)
    {
        std::vector<PatchPlane> planes(hooks.size());
        std::vector<int> hook_of_node(mesh.vertex_count(), -1);
        for (std::size_t h = 0; h < hooks.size(); ++h) {
            for (const VertexId v : hooks[h].nodes) {
                hook_of_node[static_cast<std::size_t>(v)] = static_cast<int>(h);
                planes[h].middle += mesh.vertices.row(v).transpose() / static_cast<double>(hooks[h].nodes.size());
            }
            for (const VertexId v : hooks[h].nodes)
                planes[h].radius
                    = std::max(planes[h].radius, (mesh.vertices.row(v).transpose() - planes[h].middle).norm());
        }
        for (const TetFace& face : boundary_faces(mesh)) {
            const auto corners = face_vertices(mesh, face);
            const int hook = hook_of_node[static_cast<std::size_t>(corners[0])];
            if (hook < 0 || hook_of_node[static_cast<std::size_t>(corners[1])] != hook
                || hook_of_node[static_cast<std::size_t>(corners[2])] != hook)
                continue;
            const Vec3 a = mesh.vertices.row(corners[0]), b = mesh.vertices.row(corners[1]),
                       c = mesh.vertices.row(corners[2]);
            planes[static_cast<std::size_t>(hook)].normal += (b - a).cross(c - a);
        }
        for (PatchPlane& plane : planes)
            plane.normal.normalize(); // leaves zero as it is
        return planes;
    }

} // namespace

void check_hooks_apart(const TetMesh& mesh, std::span<const HookPatch> hooks)
{
    bool two_sides = false;
    for (const HookPatch& hook : hooks)
        two_sides |= hook.side * hooks.front().side < 0;
    if (!two_sides)
        return;
    const std::vector<PatchPlane> planes = patch_planes(mesh, hooks);
    constexpr double kFacing = -0.5, kRoundOff = 1e-9;
    for (std::size_t a = 0; a < hooks.size(); ++a)
        for (std::size_t b = a + 1; b < hooks.size(); ++b) {
            if (hooks[a].side * hooks[b].side >= 0 || planes[a].normal.dot(planes[b].normal) > kFacing)
                continue;
            const Vec3 normal = (planes[a].normal - planes[b].normal).normalized();
            const Vec3 apart = planes[b].middle - planes[a].middle;
            const double gap = apart.dot(normal), reach = planes[a].radius + planes[b].radius;
            if ((apart - gap * normal).norm() > reach || std::abs(gap) > reach)
                continue; // they do not face each other
            const double crossing = -(hooks[b].displacement - hooks[a].displacement).dot(normal) - std::max(gap, 0.0);
            if (crossing > kRoundOff * reach)
                throw InputError("hooks '" + hooks[a].name + "' and '" + hooks[b].name
                        + "' would pass through each other by " + std::to_string(crossing)
                        + " mm: their lips meet before",
                    "hook '" + hooks[a].name + "'");
        }
}

} // namespace retractor
