#include "ui/cli/open_scene.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace retractor::cli {

namespace {

    constexpr double kSpacing = 4.0;
    constexpr double kLength = 100.0, kDepthShare = 0.6;
    constexpr double kHeadingDeg = 7.3, kTiltDeg = 10.0;
    constexpr double kPatchAlong = 10.0, kPatchAcross = 15.0, kFromLip = 2.0, kOpeningEachSide = 10.0;
    constexpr double kMiddleShare = 0.8;

    struct OpenBox {
        const char* name;
        std::array<int, 3> cells;
    };
    constexpr std::array<OpenBox, 4> kBoxes { { { "12k", { 20, 20, 5 } }, { "67k", { 40, 40, 7 } },
        { "96k", { 40, 40, 10 } }, { "175k", { 54, 54, 10 } } } };

} // namespace

OpenScene open_scene_of_box(const std::string& name)
{
    const auto* const box
        = std::find_if(kBoxes.begin(), kBoxes.end(), [&](const OpenBox& b) { return name == b.name; });
    if (box == kBoxes.end())
        throw InputError("there is no such box: 12k, 67k, 96k or 175k", name);
    const auto& n = box->cells;
    OpenScene scene { name, kuhn_box(n[0], n[1], n[2], kSpacing), {}, {}, {}, {} };
    const double heading = kHeadingDeg * std::numbers::pi / 180.0, tilt = kTiltDeg * std::numbers::pi / 180.0;
    const Vec3 along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
    const Vec3 centre(0.5 * n[0] * kSpacing + 1.3, 0.5 * n[1] * kSpacing + 0.9, n[2] * kSpacing);
    const double length = std::min(kLength, 0.6 * n[0] * kSpacing); // 100 mm in the boxes of the issue
    const Blade straight { .line = { centre - 0.5 * length * along, centre + 0.5 * length * along },
        .directions = { -std::cos(tilt) * Vec3::UnitZ() + std::sin(tilt) * across },
        .depth_mm = kDepthShare * n[2] * kSpacing };
    scene.blade = resampled(straight, kFreehandStep);
    const Material tissue { "tissue", 0.02, 0.45, 1e-9, "bench.json" };
    scene.materials = { tissue, tissue };
    for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v)
        if (scene.mesh.vertices(v, 2) == 0.0)
            scene.supports.fixed.push_back(v);
    const double apart = kMiddleShare * length / (kOpenSceneHooks / 2);
    const double patch = std::min(kPatchAlong, 0.9 * apart); // only in the smallest box
    for (int h = 0; h < kOpenSceneHooks; ++h) {
        const int side = h % 2 == 0 ? 1 : -1, place = h / 2;
        const double at = apart * (place + 0.5 - kOpenSceneHooks / 4.0);
        OnlineHook hook;
        hook.name = (side > 0 ? "left " : "right ") + std::to_string(place + 1);
        hook.side = side;
        hook.drive.displacement = side * kOpeningEachSide * across;
        for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v) {
            const Vec3 d = scene.mesh.vertices.row(v).transpose() - centre;
            const double from_lip = side * d.dot(across) - kFromLip;
            if (d.z() == 0.0 && std::abs(d.dot(along) - at) <= 0.5 * patch && from_lip >= 0.0
                && from_lip <= kPatchAcross)
                hook.nodes.push_back(v);
        }
        scene.hooks.push_back(std::move(hook));
    }
    return scene;
}

} // namespace retractor::cli
