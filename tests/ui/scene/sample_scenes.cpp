#include "tests/ui/scene/sample_scenes.h"

#include "ui/scene/tissue_colors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace retractor::ui::samples {

namespace {

    // The miniature lies with its skin at y = -40 (front) and its opening along z.
    constexpr double kSkin = -40.0;
    constexpr double kHalf = 60.0;
    constexpr double kOpening = 16.0; ///< half width of the opening at its middle

    struct Layer {
        double thickness;
        Label label;
    };
    constexpr std::array<Layer, 4> kLayers { { { 2.0, 1 }, { 6.0, 2 }, { 4.0, 3 }, { 6.0, 4 } } };

    double opening_at(double z)
    {
        const double u = z / 42.0;
        return std::abs(u) < 1.0 ? kOpening * std::sqrt(1.0 - u * u) : 0.0;
    }

    /// One lip of the wall: its layers from the skin down, its edge following the opening.
    TriMesh lip(double side)
    {
        constexpr int kSteps = 40;
        TriMesh mesh;
        std::vector<Vec3> points;
        const auto quad = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, Label label) {
            const auto first = static_cast<VertexId>(points.size());
            points.insert(points.end(), { a, b, c, d });
            const std::array<VertexId, 3> one = side > 0 ? std::array<VertexId, 3> { first, first + 1, first + 2 }
                                                         : std::array<VertexId, 3> { first, first + 2, first + 1 };
            const std::array<VertexId, 3> two = side > 0 ? std::array<VertexId, 3> { first, first + 2, first + 3 }
                                                         : std::array<VertexId, 3> { first, first + 3, first + 2 };
            mesh.triangles.insert(mesh.triangles.end(), { one, two });
            mesh.labels.insert(mesh.labels.end(), { label, label });
        };
        for (int i = 0; i < kSteps; ++i) {
            const double z0 = -kHalf + 2.0 * kHalf * i / kSteps, z1 = -kHalf + 2.0 * kHalf * (i + 1) / kSteps;
            const double x0 = side * opening_at(z0), x1 = side * opening_at(z1), far = side * kHalf;
            quad({ x0, kSkin, z0 }, { far, kSkin, z0 }, { far, kSkin, z1 }, { x1, kSkin, z1 }, 1);
            double y = kSkin;
            for (const Layer& layer : kLayers) {
                const double deep = y + layer.thickness;
                quad({ x0, y, z0 }, { x1, y, z1 }, { x1, deep, z1 }, { x0, deep, z0 }, layer.label);
                y = deep;
            }
            quad({ x0, y, z0 }, { x1, y, z1 }, { far, y, z1 }, { far, y, z0 }, 4);
        }
        mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.vertices.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
        return mesh;
    }

} // namespace

TriMesh box_mesh(const Vec3& low, const Vec3& high, Label label)
{
    TriMesh mesh;
    mesh.vertices.resize(8, 3);
    for (int c = 0; c < 8; ++c)
        mesh.vertices.row(c) << ((c & 1) != 0 ? high.x() : low.x()), ((c & 2) != 0 ? high.y() : low.y()),
            ((c & 4) != 0 ? high.z() : low.z());
    mesh.triangles = { { 0, 2, 3 }, { 0, 3, 1 }, { 4, 5, 7 }, { 4, 7, 6 }, { 0, 1, 5 }, { 0, 5, 4 }, { 2, 6, 7 },
        { 2, 7, 3 }, { 0, 4, 6 }, { 0, 6, 2 }, { 1, 3, 7 }, { 1, 7, 5 } };
    mesh.labels.assign(mesh.triangles.size(), label);
    return mesh;
}

TriMesh sphere_mesh(const Vec3& centre, double radius, int rings)
{
    const int around = 2 * rings;
    TriMesh mesh;
    mesh.vertices.resize((rings + 1) * around, 3);
    for (int r = 0; r <= rings; ++r)
        for (int a = 0; a < around; ++a) {
            const double polar = std::numbers::pi * r / rings, angle = 2.0 * std::numbers::pi * a / around;
            mesh.vertices.row(r * around + a) = (centre
                + radius * Vec3(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar)))
                                                    .transpose();
        }
    for (int r = 0; r < rings; ++r)
        for (int a = 0; a < around; ++a) {
            const VertexId p = r * around + a, q = r * around + (a + 1) % around;
            if (r > 0)
                mesh.triangles.push_back({ p, q + around, q });
            if (r + 1 < rings)
                mesh.triangles.push_back({ p, p + around, q + around });
        }
    return mesh;
}

SurfaceItem unlit(TriMesh mesh, const Color& color)
{
    SurfaceItem item;
    item.name = "box";
    item.mesh = std::make_shared<TriMesh>(std::move(mesh));
    item.look = { .color = color, .finish = Finish::unlit };
    return item;
}

Scene box_scene(const Vec3& low, const Vec3& high, const Color& color)
{
    Scene scene;
    scene.surfaces.push_back(unlit(box_mesh(low, high), color));
    scene.background_low = scene.background_high = { 0.0, 0.0, 0.0 };
    scene.orientation_marker = scene.scale_bar = false;
    return scene;
}

std::shared_ptr<const mesh::Volume> little_ct()
{
    auto volume = std::make_shared<mesh::Volume>();
    volume->grid = { .size = { 100, 80, 100 }, .spacing = { 1.5, 1.5, 1.5 }, .origin = { -74.25, -59.25, -74.25 } };
    volume->voxels.resize(volume->grid.voxel_count());
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, 12.0);
    for (int k = 0; k < 100; ++k)
        for (int j = 0; j < 80; ++j)
            for (int i = 0; i < 100; ++i) {
                const Vec3 p = volume->grid.world(Vec3(i, j, k));
                double hu = -1000.0;
                const bool body = std::abs(p.x()) < kHalf && std::abs(p.z()) < kHalf && p.y() > kSkin && p.y() < 58.0;
                if (body)
                    hu = -820.0; // lung
                if (body && p.y() < kSkin + 18.0)
                    hu = 40.0; // the wall
                const double heart = (Vec3(p.x() / 34.0, (p.y() - 22.0) / 26.0, p.z() / 42.0)).norm();
                if (heart < 1.0)
                    hu = heart < 0.7 ? 230.0 : 60.0;
                if (std::hypot(p.x(), p.y() - 50.0) < 9.0 && body)
                    hu = std::fmod(p.z() + 60.0, 14.0) < 10.0 ? 600.0 : 90.0; // spine
                volume->voxels[volume->grid.offset(i, j, k)]
                    = static_cast<std::int16_t>(std::lround(hu + noise(random)));
            }
    return volume;
}

std::shared_ptr<const VoxelMask> little_wall_mask()
{
    auto mask = std::make_shared<VoxelMask>();
    mask->grid = little_ct()->grid;
    mask->hidden.assign(mask->grid.voxel_count(), 0);
    for (int k = 0; k < mask->grid.size[2]; ++k)
        for (int j = 0; j < mask->grid.size[1]; ++j)
            for (int i = 0; i < mask->grid.size[0]; ++i)
                if (mask->grid.world(Vec3(i, j, k)).y() < kSkin + 18.0)
                    mask->hidden[mask->grid.offset(i, j, k)] = 1;
    return mask;
}

Scene little_chest(bool with_volume)
{
    Scene scene;
    scene.title = "Little chest, surgeon's eye";
    const std::map<Label, Look> looks { { 1, tissue_look("skin") }, { 2, tissue_look("fat") },
        { 3, tissue_look("muscle") }, { 4, tissue_look("bone") } };
    for (const double side : { 1.0, -1.0 }) {
        SurfaceItem wall;
        wall.name = "wall";
        wall.mesh = std::make_shared<TriMesh>(lip(side));
        wall.look_of_label = looks;
        scene.surfaces.push_back(std::move(wall));
        SurfaceItem blade;
        blade.name = "blade";
        const double inner = side * (kOpening - 2.0), outer = side * kOpening;
        blade.mesh = std::make_shared<TriMesh>(
            box_mesh({ std::min(inner, outer), kSkin - 1.0, -9.0 }, { std::max(inner, outer), kSkin + 11.0, 9.0 }));
        blade.look = steel_look();
        scene.surfaces.push_back(std::move(blade));
    }
    SurfaceItem target;
    target.name = "target";
    target.mesh = std::make_shared<TriMesh>(sphere_mesh({ 4.0, 0.0, 6.0 }, 7.0));
    target.look = { target_color(), Finish::wet, 0.0 };
    target.target = true;
    scene.surfaces.push_back(std::move(target));
    if (with_volume) {
        VolumeItem ct;
        ct.name = "ct";
        ct.image = little_ct();
        ct.mask = little_wall_mask();
        scene.volumes.push_back(std::move(ct));
    }
    scene.lines.push_back({ .name = "incision",
        .points = { { 0.0, kSkin - 0.2, -58.0 }, { 0.0, kSkin - 0.2, -43.0 } },
        .color = incision_color() });
    scene.legend = { { "Intercostal, 4th space", "", std::nullopt }, { "visible target", "87 %", target_color() },
        { "opening", "24.1 cm2", std::nullopt }, { "hook force", "42 N", std::nullopt } };
    scene.camera
        = { .eye = { -25.0, -260.0, 40.0 }, .aim = { 0.0, -20.0, 0.0 }, .up = Vec3::UnitZ(), .view_angle_deg = 32.0 };
    return scene;
}

} // namespace retractor::ui::samples
