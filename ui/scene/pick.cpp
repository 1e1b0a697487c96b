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

std::optional<Picked> pick(const Scene& scene, const Vec3& from, const Vec3& direction)
{
    std::optional<Picked> nearest;
    double nearest_mm = std::numeric_limits<double>::infinity();
    for (const SurfaceItem& item : scene.surfaces) {
        if (item.opacity < kLeastPickedOpacity || item.on_top)
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
