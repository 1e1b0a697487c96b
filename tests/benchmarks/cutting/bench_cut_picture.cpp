#include "tests/benchmarks/cutting/bench_cut_picture.h"

#include "ui/scene/vtk/render.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>
#include <utility>

namespace retractor::benchmarks {

namespace {

    constexpr int kTileWidth = 900, kTileHeight = 640; // pixels
    constexpr Label kLip = 1, kMade = 2, kOld = 3;
    constexpr double kMargin = 1.12; ///< width of the picture over the lip's length, with margins left and right
    constexpr double kLookDownDeg = 30.0; ///< angle from which the camera also sees some skin

    Vec3 at(const mesh::TetMesh& mesh, VertexId v) { return mesh.vertices.row(v).transpose(); }

    /// The elements on the blade's positive side, with their boundary.
    TriMesh lip_and_elements(const mesh::CutMesh& cut, const mesh::TetMesh& before, const mesh::SweptBlade& blade)
    {
        mesh::TetMesh part;
        part.vertices = cut.mesh.vertices;
        std::vector<TetId> kept;
        for (TetId t = 0; t < static_cast<TetId>(cut.mesh.tet_count()); ++t) {
            Vec3 centroid = Vec3::Zero();
            for (const VertexId v : cut.mesh.tet(t))
                centroid += 0.25 * at(cut.mesh, v);
            if (blade.coordinates(centroid).side < 0.0)
                continue;
            const auto nodes = cut.mesh.tet(t);
            part.nodes.insert(part.nodes.end(), nodes.begin(), nodes.end());
            const TetId origin = cut.origin[static_cast<std::size_t>(t)];
            const auto old = before.tet(origin);
            const bool same = std::equal(nodes.begin(), nodes.end(), old.begin(),
                [&](VertexId a, VertexId b) { return at(cut.mesh, a) == at(before, b); });
            part.labels.push_back(same ? kOld : kMade);
            kept.push_back(t);
        }
        std::set<std::pair<TetId, int>> lips;
        for (const mesh::LipFace& lip : cut.lips)
            lips.emplace(lip.face.tet, lip.face.corner);
        TriMesh shown;
        shown.vertices = part.vertices;
        for (const mesh::TetFace& face : mesh::boundary_faces(part)) {
            shown.triangles.push_back(mesh::face_vertices(part, face));
            const bool lip = lips.contains({ kept[static_cast<std::size_t>(face.tet)], face.corner });
            shown.labels.push_back(lip ? kLip : part.labels[static_cast<std::size_t>(face.tet)]);
        }
        return shown;
    }

    ui::Camera camera_on(const mesh::SweptBlade& blade)
    {
        const double length = blade.length(), depth = blade.depth();
        const Vec3 middle = blade.at(0.5 * length, 0.5 * depth);
        const Vec3 along = (blade.at(length, 0.0) - blade.at(0.0, 0.0)).normalized();
        const Vec3 up = (blade.at(0.5 * length, 0.0) - blade.at(0.5 * length, depth)).normalized();
        Vec3 to_minus = along.cross(up);
        if (blade.coordinates(middle + to_minus).side > 0.0)
            to_minus = -to_minus;
        const double tilt = kLookDownDeg * std::numbers::pi / 180.0;
        ui::Camera camera;
        camera.aim = middle;
        camera.eye = middle + 4.0 * length * (std::cos(tilt) * to_minus + std::sin(tilt) * up);
        camera.up = up;
        camera.parallel = true;
        camera.half_height_mm = 0.5 * kMargin * length * kTileHeight / kTileWidth;
        return camera;
    }

    ui::Scene scene_of(const PicturedCut& pictured, const BenchBody& body, const mesh::SweptBlade& blade)
    {
        ui::Scene scene;
        scene.title = pictured.title;
        scene.notes = pictured.notes;
        scene.surfaces.push_back({ .name = pictured.title,
            .mesh = std::make_shared<const TriMesh>(lip_and_elements(pictured.cut, body.mesh, blade)),
            .look_of_label = { { kLip, { .color = { 0.86, 0.36, 0.32 } } },
                { kMade, { .color = { 0.95, 0.85, 0.50 } } }, { kOld, { .color = { 0.70, 0.72, 0.75 } } } },
            .smooth = false,
            .show_edges = true });
        scene.camera = camera_on(blade);
        scene.orientation_marker = false;
        return scene;
    }

} // namespace

void write_cut_picture(const std::filesystem::path& file, const BenchBody& body, const std::vector<PicturedCut>& cuts)
{
    const mesh::SweptBlade blade(body.blade);
    const int columns = cuts.size() > 4 ? 4 : cuts.size() > 1 ? 2 : 1;
    const int rows = (static_cast<int>(cuts.size()) + columns - 1) / columns;
    ui::Picture picture { .width = columns * kTileWidth, .height = rows * kTileHeight, .viewports = {} };
    for (int i = 0; i < static_cast<int>(cuts.size()); ++i) {
        const int column = i % columns, row = rows - 1 - i / columns;
        picture.viewports.push_back({ .left = static_cast<double>(column) / columns,
            .bottom = static_cast<double>(row) / rows,
            .right = static_cast<double>(column + 1) / columns,
            .top = static_cast<double>(row + 1) / rows,
            .scene = scene_of(cuts[static_cast<std::size_t>(i)], body, blade) });
    }
    ui::OffscreenRenderer renderer(ui::make_offscreen_context());
    ui::write_png(file, renderer.render(picture));
}

} // namespace retractor::benchmarks
