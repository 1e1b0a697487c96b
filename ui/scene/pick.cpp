#include "ui/scene/pick.h"

#include <Eigen/Geometry>

#include <array>
#include <limits>

namespace retractor::ui {

namespace {

    /// The distance along a ray at which it meets a triangle [Moeller, Trumbore 1997]; infinity: it does not.
    double distance_to(
        const TriMesh& mesh, const std::array<VertexId, 3>& triangle, const Vec3& from, const Vec3& along)
    {
        constexpr double kNever = std::numeric_limits<double>::infinity();
        const Vec3 a = point_at(mesh.vertices, triangle[0]);
        const Vec3 ab = point_at(mesh.vertices, triangle[1]) - a, ac = point_at(mesh.vertices, triangle[2]) - a;
        const Vec3 p = along.cross(ac);
        const double determinant = ab.dot(p);
        if (determinant == 0.0)
            return kNever;
        const Vec3 t = from - a;
        const double u = t.dot(p) / determinant;
        if (!(u >= 0.0 && u <= 1.0))
            return kNever;
        const Vec3 q = t.cross(ab);
        const double v = along.dot(q) / determinant;
        if (!(v >= 0.0 && u + v <= 1.0))
            return kNever;
        const double distance = ac.dot(q) / determinant;
        return distance > 0.0 ? distance : kNever;
    }

    bool is_kept(const std::optional<CutAway>& cut, const Vec3& place)
    {
        return !cut || (place - cut->point).dot(cut->kept) >= 0.0;
    }

} // namespace

std::optional<Picked> pick(const Scene& scene, const Vec3& from, const Vec3& direction)
{
    std::optional<Picked> nearest;
    double nearest_mm = std::numeric_limits<double>::infinity();
    for (const SurfaceItem& item : scene.surfaces) {
        if (item.opacity < kLeastPickedOpacity || item.on_top)
            continue;
        for (std::size_t t = 0; t < item.mesh->triangles.size(); ++t) {
            const double mm = distance_to(*item.mesh, item.mesh->triangles[t], from, direction);
            if (!(mm < nearest_mm) || !is_kept(scene.cut_away, from + mm * direction))
                continue;
            nearest_mm = mm;
            nearest = Picked { .name = item.name, .place = from + mm * direction };
            if (!item.mesh->labels.empty())
                nearest->label = item.mesh->labels[t];
        }
    }
    if (!scene.cut_away || !scene.cut_away->face)
        return nearest;
    const double towards = direction.dot(scene.cut_away->kept);
    const double mm = towards == 0.0 ? -1.0 : (scene.cut_away->point - from).dot(scene.cut_away->kept) / towards;
    if (!(mm > 0.0 && mm < nearest_mm))
        return nearest;
    const Label label = mesh::label_at(*scene.cut_away->face->labels, from + mm * direction);
    return label == 0 ? nearest : Picked { .name = {}, .place = from + mm * direction, .label = label };
}

} // namespace retractor::ui
