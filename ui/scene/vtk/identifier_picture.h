#pragma once
// A scene drawn with one plain colour per structure: which structure each pixel shows. Pictures take the places of
// names from it, and the share of the target that is seen is checked with it.

#include "ui/scene/scene.h"
#include "ui/scene/vtk/render.h"

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace retractor::ui {

struct IdentifierPicture {
    int width = 0, height = 0;
    std::vector<std::string> names; ///< of the structures
    std::vector<int> structure; ///< of each pixel, the top row first: index into `names`; -1: none, or an edge
};

/// Draws the scene's opaque surfaces, each in a colour of its own. Volumes, lines, slices and surfaces that are
/// translucent or drawn on top are left out.
/// @param label_names names of the parts of surfaces with labels; labels without a name get that of their surface
/// @throws InputError on more than 215 structures
IdentifierPicture identifier_picture(OffscreenRenderer& renderer, const Scene& scene,
    const std::map<Label, std::string>& label_names, int width, int height);

/// The label at each pixel of a slice.
IdentifierPicture identifier_picture(const SliceItem& slice, const Camera& camera,
    const std::map<Label, std::string>& label_names, int width, int height);

/// The number of pixels of a scene's target, with everything that hides it and alone.
struct TargetPixels {
    std::size_t visible = 0, alone = 0;
    double share() const { return alone == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(alone); }
};

/// Counts the target's pixels from the camera's eye, in a picture that holds the whole target. Surfaces hide it, except
/// those that are translucent or drawn on top; volumes, lines and slices do not.
TargetPixels target_pixels(OffscreenRenderer& renderer, const Scene& scene, int pixels = 960);

/// Adds the name of each structure in the picture where the structure is widest, and leaves out names that would cover
/// each other.
void add_names(Scene& scene, const IdentifierPicture& picture);

} // namespace retractor::ui
