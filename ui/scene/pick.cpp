#include "ui/scene/pick.h"

#include "mesh/base/triangle.h"

#include <limits>

namespace retractor::ui {

namespace {

    bool is_kept(const std::optional<CutAway>& cut, const Vec3& place)
    {
        return !cut || (place - cut->point).dot(cut->kept) >= 0.0;
    }

} // namespace

namespace {

    std::optional<Picked> nearest_of(
        const Scene& scene, const Vec3& from, const Vec3& direction, double least_opacity, double& nearest_mm)
    {
        std::optional<Picked> nearest;
        for (const SurfaceItem& item : scene.surfaces) {
            if (item.opacity < least_opacity || item.on_top)
                continue;
            for (std::size_t t = 0; t < item.mesh->triangles.size(); ++t) {
                const auto& corners = item.mesh->triangles[t];
                const auto hit = line_hit(from, direction,
                    { point_at(item.mesh->vertices, corners[0]), point_at(item.mesh->vertices, corners[1]),
                        point_at(item.mesh->vertices, corners[2]) });
                const double mm = hit ? hit->distance : -1.0;
                if (!(mm > 0.0 && mm < nearest_mm) || !is_kept(scene.cut_away, from + mm * direction))
                    continue;
                nearest_mm = mm;
                nearest = Picked { .name = item.name, .place = from + mm * direction };
                if (!item.mesh->labels.empty())
                    nearest->label = item.mesh->labels[t];
            }
        }
        return nearest;
    }

} // namespace

std::optional<Picked> pick(const Scene& scene, const Vec3& from, const Vec3& direction)
{
    double nearest_mm = std::numeric_limits<double>::infinity();
    std::optional<Picked> nearest = nearest_of(scene, from, direction, kLeastPickedOpacity, nearest_mm);
    if (scene.cut_away && scene.cut_away->face) {
        const double towards = direction.dot(scene.cut_away->kept);
        const double mm = towards == 0.0 ? -1.0 : (scene.cut_away->point - from).dot(scene.cut_away->kept) / towards;
        if (mm > 0.0 && mm < nearest_mm)
            if (const Label label = mesh::label_at(*scene.cut_away->face->labels, from + mm * direction); label != 0)
                return Picked { .name = {}, .place = from + mm * direction, .label = label };
    }
    return nearest ? nearest : nearest_of(scene, from, direction, 0.0, nearest_mm);
}

} // namespace retractor::ui
