#include "ui/scene/scene_map.h"

#include "ui/scene/camera_motion.h"

#include <algorithm>

namespace retractor::ui {

Scene with_map(Scene scene, const SceneMap& map)
{
    for (const SurfaceItem& colored : map.surfaces) {
        const auto same = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
            [&](const SurfaceItem& item) { return map.on_target ? item.target : item.name == colored.name; });
        if (same == scene.surfaces.end()) {
            scene.surfaces.push_back(colored);
            continue;
        }
        const std::string name = same->name;
        *same = colored;
        same->name = name;
    }
    scene.legend.insert(scene.legend.begin(), map.legend.begin(), map.legend.end());
    if (map.from_side_deg != 0.0) {
        const Camera turned = turned_round_aim(scene.camera, map.from_side_deg);
        if (const std::optional<Box> bounds = scene_bounds(scene))
            scene.camera = camera_for_box(*bounds, turned.aim - turned.eye, turned.up, scene.camera.view_angle_deg);
    }
    return scene;
}

} // namespace retractor::ui
