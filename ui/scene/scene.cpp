#include "ui/scene/scene.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::ui {

namespace {

    void refuse(bool bad, const std::string& what, const std::string& where)
    {
        if (bad)
            throw InputError(what, where);
    }

    void check_color(const Color& c, const std::string& where)
    {
        for (const double x : { c.r, c.g, c.b })
            refuse(!(x >= 0.0 && x <= 1.0), "a colour must be within 0 to 1", where);
    }

    void check_share(double x, const char* what, const std::string& where)
    {
        refuse(!(x >= 0.0 && x <= 1.0), std::string(what) + " must be within 0 to 1", where);
    }

    void check_mesh_arrays(const TriMesh& mesh, const std::string& where)
    {
        const auto count = static_cast<VertexId>(mesh.vertices.rows());
        for (VertexId v = 0; v < count; ++v)
            refuse(!mesh.vertices.row(v).allFinite(), "vertex " + std::to_string(v) + " is not finite", where);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const VertexId v : mesh.triangles[t])
                refuse(v < 0 || v >= count,
                    "triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + " of "
                        + std::to_string(count),
                    where);
        refuse(!mesh.labels.empty() && mesh.labels.size() != mesh.triangles.size(),
            "there must be one label per triangle", where);
    }

    void check_surface(const SurfaceItem& item)
    {
        const std::string where = "surface " + item.name;
        refuse(item.mesh == nullptr, "a surface has no mesh", where);
        check_mesh_arrays(*item.mesh, where);
        check_share(item.opacity, "opacity", where);
        check_color(item.look.color, where);
        check_share(item.look.texture, "texture", where);
        for (const auto& [label, look] : item.look_of_label) {
            check_color(look.color, where);
            check_share(look.texture, "texture", where);
        }
        if (item.look_of_label.empty())
            return;
        refuse(
            item.mesh->labels.empty() && !item.mesh->triangles.empty(), "looks by label need triangle labels", where);
        for (const Label label : item.mesh->labels)
            refuse(!item.look_of_label.contains(label), "label " + std::to_string(label) + " has no look", where);
    }

    void check_volume(const VolumeItem& item)
    {
        const std::string where = "volume " + item.name;
        refuse(item.image == nullptr, "a volume has no image", where);
        mesh::check_grid(item.image->grid);
        refuse(item.image->voxels.size() != item.image->grid.voxel_count(),
            "the image's voxel count does not match its size", where);
        check_share(item.opacity, "opacity", where);
        if (item.mask != nullptr) {
            mesh::check_grid(item.mask->grid);
            refuse(item.mask->hidden.size() != item.mask->grid.voxel_count(),
                "the mask's voxel count does not match its size", where);
        }
    }

    void check_line(const LineItem& item)
    {
        const std::string where = "line " + item.name;
        refuse(item.points.size() < 2, "a line needs at least two points", where);
        for (const Vec3& p : item.points)
            refuse(!p.allFinite(), "a line has a point that is not finite", where);
        refuse(!(item.width_px > 0.0), "a line's width must be positive", where);
        check_color(item.color, where);
    }

    void check_slice(const SliceItem& item)
    {
        const std::string where = "slice";
        if (item.oblique) {
            constexpr double kUnit = 1e-6;
            const ObliqueSlice& frame = *item.oblique;
            refuse(!(std::abs(frame.right.norm() - 1.0) < kUnit && std::abs(frame.up.norm() - 1.0) < kUnit
                       && std::abs(frame.right.dot(frame.up)) < kUnit),
                "the directions of an oblique slice must be unit vectors at right angles", where);
            refuse(!(frame.half_width_mm > 0.0 && frame.half_height_mm > 0.0 && std::isfinite(frame.half_width_mm)
                       && std::isfinite(frame.half_height_mm)),
                "the size of an oblique slice must be positive", where);
        }
        refuse(item.image == nullptr, "a slice has no image", where);
        mesh::check_grid(item.image->grid);
        refuse(item.image->voxels.size() != item.image->grid.voxel_count(),
            "the image's voxel count does not match its size", where);
        refuse(!item.point.allFinite(), "the slice's point is not finite", where);
        refuse(!(item.window_hu > 0.0) || !std::isfinite(item.level_hu), "the slice's window must be positive", where);
        check_share(item.fill, "fill", where);
        refuse(
            !(item.pixel_mm >= 0.0 && std::isfinite(item.pixel_mm)), "the slice's pixels must not be negative", where);
        if (item.labels != nullptr) {
            mesh::check_grid(item.labels->grid);
            refuse(item.labels->voxels.size() != item.labels->grid.voxel_count(),
                "the labels' voxel count does not match their size", where);
        }
        for (const auto& [label, color] : item.outline_of_label)
            check_color(color, where);
    }

    void check_cut_away(const CutAway& cut)
    {
        const std::string where = "cut away";
        constexpr double kUnit = 1e-6;
        refuse(!cut.point.allFinite(), "the point of the plane is not finite", where);
        refuse(!(std::abs(cut.kept.norm() - 1.0) < kUnit), "the direction must be a unit vector", where);
        if (!cut.face)
            return;
        check_slice(*cut.face);
        refuse(cut.face->labels == nullptr, "the slice on the plane has no labels", where);
    }

    void check_camera(const Camera& camera)
    {
        const std::string where = "camera";
        refuse(!camera.eye.allFinite() || !camera.aim.allFinite() || !camera.up.allFinite(), "the camera is not finite",
            where);
        const Vec3 sight = camera.aim - camera.eye;
        refuse(sight.norm() == 0.0, "the camera's eye is at its aim", where);
        refuse(sight.normalized().cross(camera.up).norm() <= 1e-6 * camera.up.norm() || camera.up.norm() == 0.0,
            "the camera's up direction lies along its line of sight", where);
        refuse(!camera.parallel && !(camera.view_angle_deg > 0.0 && camera.view_angle_deg < 180.0),
            "the camera's view angle must be within 0 to 180 degrees", where);
        refuse(camera.parallel && !(camera.half_height_mm > 0.0 && std::isfinite(camera.half_height_mm)),
            "the camera's half height must be positive", where);
    }

    struct Bounds {
        Box box;
        bool any = false;
        void add(const Vec3& p)
        {
            box.low = any ? Vec3(box.low.cwiseMin(p)) : p;
            box.high = any ? Vec3(box.high.cwiseMax(p)) : p;
            any = true;
        }
        void add(const mesh::ImageGrid& grid)
        {
            for (int corner = 0; corner < 8; ++corner)
                add(grid.world(Vec3((corner & 1) != 0 ? grid.size[0] - 1 : 0, (corner & 2) != 0 ? grid.size[1] - 1 : 0,
                    (corner & 4) != 0 ? grid.size[2] - 1 : 0)));
        }
    };

} // namespace

void check_scene(const Scene& scene)
{
    for (const SurfaceItem& item : scene.surfaces)
        check_surface(item);
    for (const VolumeItem& item : scene.volumes)
        check_volume(item);
    for (const LineItem& item : scene.lines)
        check_line(item);
    for (const SliceItem& item : scene.slices)
        check_slice(item);
    if (scene.cut_away)
        check_cut_away(*scene.cut_away);
    for (const TextItem& item : scene.words) {
        refuse(!item.position.allFinite(), "a text's place is not finite", "text " + item.text);
        check_color(item.color, "text " + item.text);
    }
    refuse(!(scene.font_px >= 0.0 && scene.font_px < 1000.0), "letters must be 0 to 1000 pixels high", "letters");
    refuse(
        !(scene.legend_share > 0.0 && scene.legend_share <= 1.0), "a legend's share must be within 0 to 1", "legend");
    for (const LegendLine& line : scene.legend)
        if (line.swatch)
            check_color(*line.swatch, "legend " + line.key);
    check_color(scene.background_low, "background");
    check_color(scene.background_high, "background");
    check_camera(scene.camera);
}

void check_picture(const Picture& picture)
{
    /// Larger than any printer or screen needs, and accepted by drivers.
    constexpr int kLargest = 16384;
    if (picture.width <= 0 || picture.height <= 0 || picture.width > kLargest || picture.height > kLargest)
        throw InputError("a picture's size must be within 1 to 16384 pixels, got " + std::to_string(picture.width) + "x"
                + std::to_string(picture.height),
            "picture");
    if (picture.viewports.empty())
        throw InputError("a picture needs at least one viewport", "picture");
    for (const Viewport& v : picture.viewports) {
        if (!(v.left >= 0.0 && v.bottom >= 0.0 && v.right <= 1.0 && v.top <= 1.0 && v.left < v.right
                && v.bottom < v.top))
            throw InputError("a viewport must be a rectangle within 0 to 1", "viewport " + v.scene.title);
        check_scene(v.scene);
    }
}

std::optional<Box> scene_bounds(const Scene& scene)
{
    Bounds bounds;
    for (const SurfaceItem& item : scene.surfaces)
        if (item.mesh != nullptr)
            for (Eigen::Index v = 0; v < item.mesh->vertices.rows(); ++v)
                bounds.add(Vec3(item.mesh->vertices.row(v)));
    for (const VolumeItem& item : scene.volumes)
        if (item.image != nullptr)
            bounds.add(item.image->grid);
    for (const LineItem& item : scene.lines)
        for (const Vec3& p : item.points)
            bounds.add(p);
    for (const SliceItem& item : scene.slices)
        if (item.image != nullptr)
            bounds.add(item.image->grid);
    if (!bounds.any)
        return std::nullopt;
    return bounds.box;
}

Camera camera_for_box(const Box& box, const Vec3& direction, const Vec3& up, double view_angle_deg)
{
    const double radius = std::max(0.5 * (box.high - box.low).norm(), 1.0);
    Camera camera;
    camera.aim = 0.5 * (box.low + box.high);
    camera.view_angle_deg = view_angle_deg;
    const double half_angle = 0.5 * view_angle_deg * std::numbers::pi / 180.0;
    camera.eye = camera.aim - direction.normalized() * radius / std::sin(half_angle);
    camera.up = up;
    return camera;
}

Camera camera_for_slice(const SliceItem& slice, double aspect)
{
    if (slice.image == nullptr)
        throw InputError("a slice has no image", "slice");
    Bounds bounds;
    bounds.add(slice.image->grid);
    return camera_for_slice(slice, bounds.box, aspect);
}

Camera camera_for_slice(const SliceItem& slice, const Box& box, double aspect)
{
    if (!(aspect > 0.0))
        throw InputError("the aspect must be positive", "slice");
    constexpr double kMargin = 1.06;
    const Vec3 extent = box.high - box.low;
    Camera camera;
    camera.parallel = true;
    if (slice.oblique) {
        const ObliqueSlice& frame = *slice.oblique;
        camera.aim = slice.point;
        camera.up = frame.up;
        camera.eye = camera.aim + frame.right.cross(frame.up) * (extent.norm() + 10.0);
        camera.half_height_mm = std::max(frame.half_height_mm, frame.half_width_mm / aspect);
        return camera;
    }
    camera.aim = 0.5 * (box.low + box.high);
    int normal = 2, across = 0, upward = 1;
    Vec3 toward_eye = -Vec3::UnitZ(); // axial: seen from the feet
    camera.up = -Vec3::UnitY();
    if (slice.plane == SlicePlane::coronal) {
        normal = 1;
        upward = 2;
        toward_eye = -Vec3::UnitY();
        camera.up = Vec3::UnitZ();
    } else if (slice.plane == SlicePlane::sagittal) {
        normal = 0;
        across = 1;
        upward = 2;
        toward_eye = Vec3::UnitX();
        camera.up = Vec3::UnitZ();
    }
    camera.aim[normal] = slice.point[normal];
    camera.eye = camera.aim + toward_eye * (extent.norm() + 10.0);
    camera.half_height_mm = kMargin * 0.5 * std::max(extent[upward], extent[across] / aspect);
    return camera;
}

} // namespace retractor::ui
