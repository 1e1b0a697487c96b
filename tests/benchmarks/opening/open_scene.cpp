#include "tests/benchmarks/opening/open_scene.h"

#include "mesh/base/error.h"
#include "planner/case/solver_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

namespace retractor::benchmarks {

namespace {

    constexpr double kSpacing = 4.0;
    constexpr double kCutLength = 100.0, kDepthShare = 0.6;
    constexpr double kHeadingDeg = 7.3, kTiltDeg = 10.0;
    constexpr double kPatchAlong = 10.0, kPatchAcross = 15.0, kFromLip = 2.0, kOpeningEachSide = 10.0;
    constexpr double kMiddleShare = 0.8;

    struct OpenBox {
        const char* name;
        std::array<int, 3> cells;
    };
    constexpr std::array<OpenBox, 4> kBoxes { { { "12k", { 20, 20, 5 } }, { "67k", { 40, 40, 7 } },
        { "96k", { 40, 40, 10 } }, { "175k", { 54, 54, 10 } } } };

    /// Hooks on the skin beside the incision, half of them on each lip.
    void add_hooks(OpenScene& scene, const std::vector<VertexId>& skin, const Vec3& centre, const Vec3& along,
        const Vec3& across, double length)
    {
        const double apart = kMiddleShare * length / (kOpenSceneHooks / 2);
        const double patch = std::min(kPatchAlong, 0.9 * apart); // limits the patch in the smallest box only
        for (int h = 0; h < kOpenSceneHooks; ++h) {
            const int side = h % 2 == 0 ? 1 : -1, place = h / 2;
            const double at = apart * (place + 0.5 - kOpenSceneHooks / 4.0);
            fem::OnlineHook hook;
            hook.name = (side > 0 ? "left " : "right ") + std::to_string(place + 1);
            hook.side = side;
            hook.drive.displacement = side * kOpeningEachSide * across;
            for (const VertexId v : skin) {
                const Vec3 d = scene.mesh.vertices.row(v).transpose() - centre;
                const double from_lip = side * d.dot(across) - kFromLip;
                if (std::abs(d.dot(along) - at) <= 0.5 * patch && from_lip >= 0.0 && from_lip <= kPatchAcross)
                    hook.nodes.push_back(v);
            }
            scene.hooks.push_back(std::move(hook));
        }
    }

} // namespace

OpenScene open_scene(const std::string& name, const Job& job)
{
    return name == "thorax" ? open_scene_of_thorax(job) : open_scene_of_box(name);
}

OpenScene open_scene_of_thorax(const Job& job)
{
    BenchBody body = bench_thorax(job);
    OpenScene scene { body.name, std::move(body.mesh), std::move(body.blade), std::move(body.materials),
        std::move(body.supports), {} };
    scene.cut.uncut_labels = body.uncut_labels;
    for (fem::Material& material : scene.materials)
        material = planner::as_solved(std::move(material), planner::ElementKind::p1);
    const auto steps = static_cast<std::size_t>(kCutLength / kFreehandStep);
    if (scene.blade.line.size() < steps + 1)
        throw SolverError("the incision of the bench's thorax is too short", "open bench");
    const auto first = static_cast<std::ptrdiff_t>((scene.blade.line.size() - steps - 1) / 2);
    const auto middle = [&](std::vector<Vec3>& points) {
        if (points.size() > 1)
            points = { points.begin() + first, points.begin() + first + static_cast<std::ptrdiff_t>(steps) + 1 };
    };
    middle(scene.blade.line);
    middle(scene.blade.directions);
    const Vec3 centre = scene.blade.line[steps / 2], inward = scene.blade.directions[scene.blade.directions.size() / 2];
    const Vec3 along = (scene.blade.line.back() - scene.blade.line.front()).normalized();
    const Vec3 across = along.cross(inward).normalized();
    std::set<VertexId> skin;
    constexpr double kFront = 25.0; // mm from the line's plane: excludes the back of the chest
    for (const mesh::TetFace& face : mesh::boundary_faces(scene.mesh))
        if (std::binary_search(
                body.skin.begin(), body.skin.end(), scene.mesh.labels[static_cast<std::size_t>(face.tet)]))
            for (const VertexId v : mesh::face_vertices(scene.mesh, face))
                if (std::abs((scene.mesh.vertices.row(v).transpose() - centre).dot(inward)) < kFront)
                    skin.insert(v);
    add_hooks(scene, { skin.begin(), skin.end() }, centre, along, across, kCutLength);
    return scene;
}

OpenScene open_scene_of_box(const std::string& name)
{
    const auto* const box
        = std::find_if(kBoxes.begin(), kBoxes.end(), [&](const OpenBox& b) { return name == b.name; });
    if (box == kBoxes.end())
        throw InputError("there is no such box: 12k, 67k, 96k or 175k", name);
    const auto& n = box->cells;
    OpenScene scene { name, mesh::kuhn_box(n[0], n[1], n[2], kSpacing), {}, {}, {}, {} };
    const double heading = kHeadingDeg * std::numbers::pi / 180.0, tilt = kTiltDeg * std::numbers::pi / 180.0;
    const Vec3 along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
    const Vec3 centre(0.5 * n[0] * kSpacing + 1.3, 0.5 * n[1] * kSpacing + 0.9, n[2] * kSpacing);
    const double length = std::min(kCutLength, 0.6 * n[0] * kSpacing); // 100 mm in the larger boxes
    const mesh::Blade straight { .line = { centre - 0.5 * length * along, centre + 0.5 * length * along },
        .directions = { -std::cos(tilt) * Vec3::UnitZ() + std::sin(tilt) * across },
        .depth_mm = kDepthShare * n[2] * kSpacing };
    scene.blade = resampled(straight, kFreehandStep);
    const fem::Material tissue { "tissue", 0.02, 0.45, 1e-9, "a soft tissue of the benchmark" };
    scene.materials = { tissue, tissue };
    for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v)
        if (scene.mesh.vertices(v, 2) == 0.0)
            scene.supports.fixed.push_back(v);
    std::vector<VertexId> skin;
    for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v)
        if (scene.mesh.vertices(v, 2) == centre.z())
            skin.push_back(v);
    add_hooks(scene, skin, centre, along, across, length);
    return scene;
}

} // namespace retractor::benchmarks
