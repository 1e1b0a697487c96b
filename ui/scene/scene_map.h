#pragma once
// Numbers as colours on the surfaces of a scene, with a legend.

#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

struct SceneMap {
    std::vector<SurfaceItem> surfaces {}; ///< each takes the place of the surface of its name, or is added
    bool on_target = false; ///< the one surface takes the place of the scene's target instead
    std::vector<LegendLine> legend {};
    /// Not 0: the map lies in front of the patient, and is seen from outside with the camera turned this far, degrees.
    double from_side_deg = 0.0;
};

/// The scene in the colours of the map, whose legend stands above what the scene's own says.
Scene with_map(Scene scene, const SceneMap& map);

} // namespace retractor::ui
