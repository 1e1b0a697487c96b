#pragma once
// Counts the pixels of a scene's target, to compare them with the rays of planner/measures/sight/exposure.h.

#include "ui/scene/vtk/render.h"

#include <cstddef>
#include <memory>

namespace retractor::ui::samples {

/// Number of target pixels in a view, and their number when everything else is removed.
struct TargetPixels {
    std::size_t visible = 0, unobstructed = 0;
    double share() const
    {
        return unobstructed == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(unobstructed);
    }
};

/// Counts pixels of surfaces marked `target`. All other surfaces hide them, except surfaces that are
/// drawn on top or translucent; volumes, lines and slices do not.
inline TargetPixels target_pixels(OffscreenRenderer& renderer, const Scene& scene, int width, int height)
{
    Scene bare;
    bare.camera = scene.camera;
    bare.orientation_marker = bare.scale_bar = false;
    bare.background_low = bare.background_high = { 0.0, 0.0, 0.0 };
    const auto add = [](Scene& to, std::shared_ptr<const TriMesh> mesh, const Color& color) {
        to.surfaces.push_back({ .name = "surface " + std::to_string(to.surfaces.size()),
            .mesh = std::move(mesh),
            .look = { .color = color, .finish = Finish::unlit },
            .smooth = false });
    };
    const auto lit = [&](const Scene& counted) {
        Picture picture { .width = width, .height = height, .viewports = {} };
        picture.viewports.push_back({ .scene = counted });
        const Image image = renderer.render(picture);
        std::size_t count = 0;
        for (std::size_t i = 0; i < image.rgb.size(); i += 3)
            count += image.rgb[i] > 127 ? 1 : 0;
        return count;
    };
    for (const SurfaceItem& item : scene.surfaces)
        if (item.target && !item.mesh->triangles.empty())
            add(bare, item.mesh, { 1.0, 1.0, 1.0 });
    Scene full = bare;
    for (const SurfaceItem& item : scene.surfaces)
        if (!item.target && !item.on_top && item.opacity >= 1.0 && !item.mesh->triangles.empty())
            add(full, item.mesh, { 0.0, 0.0, 0.0 });
    return { .visible = lit(full), .unobstructed = lit(bare) };
}

} // namespace retractor::ui::samples
