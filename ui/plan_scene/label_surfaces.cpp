#include "ui/plan_scene/label_surfaces.h"

#include "mesh/image/skeleton.h"
#include "mesh/surface/label_surface.h"
#include "ui/scene/label_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace retractor::ui {

namespace {

    constexpr double kSurfaceSpacing_mm = 2.0, kBodySpacing_mm = 4.0;
    constexpr double kBodySmoothing_mm = 3.0, kBodyOpacity = 0.18;
    constexpr Color kBodyColor { 0.95, 0.78, 0.68 };

    /// Keeps every n-th voxel, which is enough for a small picture.
    mesh::LabelVolume thinned(const mesh::LabelVolume& labels, double spacing_mm)
    {
        std::array<int, 3> step {};
        mesh::LabelVolume coarse;
        coarse.table = labels.table;
        coarse.grid = labels.grid;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            step[a] = std::max(1, static_cast<int>(std::lround(spacing_mm / labels.grid.spacing[axis])));
            coarse.grid.size[a] = (labels.grid.size[a] - 1) / step[a] + 1;
            coarse.grid.spacing[axis] = labels.grid.spacing[axis] * step[a];
        }
        coarse.voxels.reserve(coarse.grid.voxel_count());
        for (int k = 0; k < labels.grid.size[2]; k += step[2])
            for (int j = 0; j < labels.grid.size[1]; j += step[1])
                for (int i = 0; i < labels.grid.size[0]; i += step[0])
                    coarse.voxels.push_back(labels.voxels[labels.grid.offset(i, j, k)]);
        return coarse;
    }

    bool is_solid(const mesh::LabelInfo& info, bool has_wall)
    {
        if (mesh::is_skeleton(info) || info.role == mesh::Role::target || info.role == mesh::Role::at_risk)
            return true;
        return !has_wall && info.role != mesh::Role::wall && info.material != "lung";
    }

    std::vector<bool> labels_met(const mesh::LabelVolume& labels)
    {
        std::vector<bool> met(static_cast<std::size_t>(std::numeric_limits<Label>::max()) + 1, false);
        for (const Label label : labels.voxels)
            met[label] = true;
        return met;
    }

    SurfaceItem organ_item(const mesh::LabelVolume& labels, const mesh::LabelInfo& info)
    {
        SurfaceItem item;
        item.name = info.name;
        item.mesh = std::make_shared<const TriMesh>(mesh::label_surface(labels, std::array { info.id }));
        item.look = { label_color(info.name), Finish::matte, 0.0 };
        return item;
    }

    SurfaceItem body_item(const mesh::LabelVolume& labels)
    {
        std::vector<Label> all;
        for (const mesh::LabelInfo& info : labels.table)
            all.push_back(info.id);
        SurfaceItem body;
        body.name = "body";
        body.mesh = std::make_shared<const TriMesh>(
            mesh::label_surface(thinned(labels, kBodySpacing_mm), all, kBodySmoothing_mm));
        body.look = { kBodyColor, Finish::matte, 0.0 };
        body.opacity = kBodyOpacity;
        return body;
    }

} // namespace

std::vector<SurfaceItem> label_surfaces(const mesh::LabelVolume& labels, const Job& job)
{
    std::vector<SurfaceItem> items;
    const mesh::LabelVolume coarse = thinned(labels, kSurfaceSpacing_mm);
    const std::vector<bool> met = labels_met(coarse);
    const bool has_wall = std::any_of(coarse.table.begin(), coarse.table.end(), [&](const mesh::LabelInfo& info) {
        return info.role == mesh::Role::wall && !mesh::is_skeleton(info) && met[info.id];
    });
    for (const mesh::LabelInfo& info : coarse.table)
        if (met[info.id] && is_solid(info, has_wall) && !job.cancelled())
            items.push_back(organ_item(coarse, info));
    if (items.empty() && !has_wall)
        for (const mesh::LabelInfo& info : coarse.table)
            if (met[info.id] && !job.cancelled())
                items.push_back(organ_item(coarse, info));
    if (has_wall && !job.cancelled())
        items.push_back(body_item(coarse));
    return items;
}

} // namespace retractor::ui
